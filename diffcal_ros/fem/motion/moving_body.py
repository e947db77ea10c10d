# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A clamped body after its release: positions at the frames' stamps, tangents and adjoint.

The body rests on a support until the release, then the support is gone. Steps are counted from
the release, so that a later release shifts the whole motion: the derivative by its time is the
velocity at the frame, with the sign turned.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from diffcal_ros.damping import Damping
from diffcal_ros.fem.motion.dynamics import Dynamics
from diffcal_ros.fem.motion.giving_derivatives import would_give_way
from diffcal_ros.fem.motion.held_nodes import HeldNodes, HeldState
from diffcal_ros.fem.motion.implicit import ImplicitIntegrator
from diffcal_ros.fem.motion.inputs import (
    GravityCourse,
    HeldMotion,
    MotionChange,
    MotionError,
    MotionGradient,
    MotionInputs,
    Release,
)
from diffcal_ros.fem.motion.integrator import Integrator
from diffcal_ros.fem.motion.path import Path
from diffcal_ros.fem.motion.semi_implicit import SemiImplicitIntegrator
from diffcal_ros.fem.motion.start import Start
from diffcal_ros.fem.statics.force_changes import Change
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.fem.terms.conditions import Conditions, NO_CONDITIONS
from diffcal_ros.material import Material
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

TIME_STEP = 1.0 / 240.0
# Where the error is controlled [s]: longer ones hardly cost less, as Newton's method needs more
# rounds.
LONGEST_STEP = 1.0 / 60.0
CHECKPOINT_BYTES = 64_000_000
_IMPLICIT, _SEMI_IMPLICIT = 'implicit', 'semi_implicit'
INTEGRATOR_NAMES = (_IMPLICIT, _SEMI_IMPLICIT)


@dataclass(frozen=True)
class Motion:
    """A motion at the stamps that were asked for.

    Attributes:
        stamps: [s], shape (F,).
        positions: of the nodes in the world frame [m], shape (F, N, 3).
        velocities: their derivative by time [m/s], shape (F, N, 3); zero before the release.
        step_count: steps taken.
        halvings: how often a step did not converge and was halved.
        rungs: how often each step halves the longest one; none for `semi_implicit`.
        step_errors: what each step is off by, about [m], shape (S,); they add up to about the
            error of slow modes. Empty where no tolerance was given.
    """

    stamps: FloatArray
    positions: FloatArray
    velocities: FloatArray
    step_count: int
    halvings: int
    rungs: tuple[int, ...]
    step_errors: FloatArray


class MovingBody:
    """One body that is let go; keeps its last motion for the derivatives."""

    def __init__(
        self,
        static_body: StaticBody,
        release: Release | None,
        *,
        integrator: str = 'implicit',
        time_step: float | None = None,
        tolerance: float | None = None,
        checkpoint_bytes: int = CHECKPOINT_BYTES,
        has_derivatives: bool = True,
    ) -> None:
        """Prepare one body.

        Args:
            static_body: with its clamp. Its material and state are set anew by each motion.
            release: the support that goes and when; None: the body rests in its clamp until
                t = 0 and then follows the motion of the held vertices.
            integrator: one of `INTEGRATOR_NAMES`.
            time_step: longest step [s]; None: `TIME_STEP`, or `LONGEST_STEP` with a tolerance.
            tolerance: what one step may be off by [m]: steps of `implicit` are as long as that
                allows; None: they are fixed.
            checkpoint_bytes: bound on the states that `semi_implicit` holds for the gradient;
                `implicit` stores positions and velocities of every step.
            has_derivatives: tangents or gradients will be asked for. A motion alone is found in
                less time, to 1e-9 m where it else is to 1e-11.

        Raises:
            ValueError: for an unknown integrator, a time step or tolerance that is not positive,
                or a tolerance for `semi_implicit`.
        """
        if time_step is None:
            time_step = TIME_STEP if tolerance is None else LONGEST_STEP
        _check_steps(integrator, time_step, tolerance)
        self.static_body = static_body
        self.release = release
        self._dynamics = Dynamics(static_body)
        self._start = Start(static_body, release)
        self.integrator: Integrator
        if integrator == _IMPLICIT:
            self.integrator = ImplicitIntegrator(
                self._dynamics, time_step, tolerance=tolerance, has_derivatives=has_derivatives
            )
        else:
            self.integrator = SemiImplicitIntegrator(self._dynamics, time_step, checkpoint_bytes)
        self._motion: Motion | None = None
        self._held = HeldNodes(static_body, None, np.zeros(6))
        self._release_time = 0.0

    @property
    def motion(self) -> Motion:
        """The last motion.

        Raises:
            RuntimeError: before the first one.
        """
        if self._motion is None:
            raise RuntimeError('no motion yet: call simulate first')
        return self._motion

    @property
    def path(self) -> Path | None:
        """Where the last motion went since the release; None where that is not kept."""
        return self.integrator.path

    def simulate(
        self,
        material: Material,
        damping: Damping,
        gravity: FloatArray,
        stamps: FloatArray,
        *,
        held_motion: HeldMotion | None = None,
        conditions: Conditions = NO_CONDITIONS,
        release_time: float | None = None,
        time_offset: FloatArray | float = 0.0,
        gravity_course: GravityCourse = (),
        rungs: Sequence[int] | None = None,
        near: Path | None = None,
    ) -> Motion:
        """Find the body's positions at the stamps.

        Args:
            material: one value per tetrahedron.
            damping: one value per tetrahedron.
            gravity: acceleration in the world frame [m/s^2], shape (3,).
            stamps: [s], shape (F,), in any order; the body rests until its release.
            held_motion: positions of the held vertices in the world frame [m], shape (h, 3), at
                a time on the axis of the stamps; smooth. They rest where they are at the release
                until then. None: they stay.
            conditions: effects on the body; added masses count as inertia too.
            release_time: [s], in place of the release's own.
            time_offset: by which the stamps are late [s], of all or of each, shape (F,): the body
                is where it was so long before.
            gravity_course: what gravity is more around times on the axis of the stamps.
            rungs: steps to take since the release, such as those of an earlier `Motion`. Its
                derivatives hold them fixed: only motions of the same steps differ smoothly. None:
                they are chosen anew.
            near: a motion that this one is like, such as `path` of a body that is hardly
                different: steps are found sooner from there.

        Raises:
            EquilibriumError: when the body finds no rest before its release.
            MotionError: when a step does not converge however short, or for a clamp that gives
                way with an integrator that does not follow it.
        """
        stamps = np.asarray(stamps, dtype=np.float64)
        _check(stamps, conditions, self.integrator.name)
        if release_time is None:
            release_time = 0.0 if self.release is None else self.release.time
        self._release_time = release_time
        since_start = tuple((knot.since(release_time), own) for knot, own in gravity_course)
        gravity = np.asarray(gravity, dtype=np.float64)
        inputs = MotionInputs(material, damping, gravity, conditions, since_start)
        self._held = HeldNodes(self.static_body, held_motion, conditions.clamp_motion)
        start = self._start.solve_equilibrium(inputs, self._held.vertices_at(release_time))
        self._dynamics.take(inputs)
        since = stamps - time_offset - release_time
        reader = self.integrator.march(start, since, self._held_at, rungs, near)
        self._motion = Motion(
            stamps,
            reader.frames + self.static_body.origin,
            reader.rates,
            self.integrator.step_count,
            self.integrator.halvings,
            self.integrator.rungs,
            self.integrator.step_errors,
        )
        return self._motion

    def tangents(self, changes: Sequence[Change]) -> FloatArray:
        """Return how positions follow each change [m], shape (k, F, N, 3).

        Args:
            changes: `MotionChange` or `Change`.

        Raises:
            MotionError: for a clamp that gives way with an integrator that does not follow it.
        """
        motion, stamped = self.motion, changes
        if would_give_way(changes) and self.integrator.name != _IMPLICIT:
            raise _not_followed(self.integrator.name)
        changes = [_since(self._release_time, change) for change in changes]
        held = self._held_changes(changes, 0.0)
        clamped = np.zeros((len(changes), *motion.positions.shape[1:]))
        for number, state in enumerate(held):
            if state is not None:
                clamped[number, self.static_body.held_nodes] = state.positions
        start = self._start.tangents(changes, clamped)
        self._dynamics.take(self._dynamics.inputs)
        fields = self.integrator.tangents(
            changes, start, lambda time: self._held_changes(changes, time)
        )
        for field, change in zip(fields, stamped, strict=True):
            if isinstance(change, MotionChange):
                later = change.release_time + change.time_offset * change.weights(motion.stamps)
                if later.any():
                    field -= later[:, None, None] * motion.velocities
        return fields

    def gradient(self, by_positions: FloatArray) -> MotionGradient:
        """Pull a derivative by the positions back to the inputs.

        Args:
            by_positions: derivative of a scalar by the positions [1/m], shape (F, N, 3).

        Raises:
            NotImplementedError: where gravity is another one in the course of time, or the clamp
                gives way.
        """
        motion = self.motion
        if self._dynamics.clamp.gives_way:
            raise NotImplementedError(
                'no gradient goes through a clamp that gives way in a motion: use `tangents`'
            )
        if self._dynamics.inputs.gravity_course:
            raise NotImplementedError(
                'no gradient goes through gravity in the course of time: use `tangents`'
            )
        if by_positions.shape != motion.positions.shape:
            raise ValueError(
                f'the derivative has shape {by_positions.shape}: it must be like the positions, '
                f'{motion.positions.shape}'
            )
        by_release = by_offset = -float((by_positions * motion.velocities).sum())
        unit = MotionChange(release_time=1.0)

        def add_held(time: float, by_place: FloatArray, by_speed: FloatArray) -> None:
            nonlocal by_release
            state = self._held.change(self._release_time + time, unit)
            if state is not None:
                by_release += float((by_place * state.positions).sum())
                by_release += float((by_speed * state.velocities).sum())

        self._dynamics.take(self._dynamics.inputs)
        total, by_start = self.integrator.gradient(
            by_positions, add_held if self._held.moves else None
        )
        start, by_clamp = self._start.pull_back(by_start)
        if self._held.moves:
            held = self.static_body.held_nodes
            add_held(0.0, by_clamp[held], np.zeros_like(by_clamp[held]))
        return replace(total.total(start, by_release), time_offset=by_offset)

    def _held_at(self, time: float) -> HeldState:
        return self._held.at(self._release_time + time)

    def _held_changes(self, changes: Sequence[Change], time: float) -> list[HeldState | None]:
        return [self._held.change(self._release_time + time, change) for change in changes]


def _since(start: float, change: Change) -> Change:
    """Return a change with its knot on an axis that begins at the start [s]."""
    if not isinstance(change, MotionChange) or change.knot is None:
        return change
    return replace(change, knot=change.knot.since(start))


def _check_steps(integrator: str, time_step: float, tolerance: float | None) -> None:
    if integrator not in INTEGRATOR_NAMES:
        raise ValueError(
            f'integrator {integrator!r} is unknown: use one of {", ".join(INTEGRATOR_NAMES)}'
        )
    if not time_step > 0.0:
        raise ValueError(f'time step is {time_step:g} s: it must be positive')
    if tolerance is None:
        return
    if integrator != _IMPLICIT:
        raise ValueError(f'{integrator} steps are bound by stability: leave the tolerance out')
    if not tolerance > 0.0:
        raise ValueError(f'tolerance is {tolerance:g} m: it must be positive')


def _check(stamps: FloatArray, conditions: Conditions, integrator: str) -> None:
    if stamps.ndim != 1 or not np.isfinite(stamps).all():
        raise ValueError(
            f'stamps have shape {stamps.shape}: give finite times in seconds, one per frame'
        )
    if conditions.clamp_gives_way and integrator != _IMPLICIT:
        raise _not_followed(integrator)


def _not_followed(integrator: str) -> MotionError:
    return MotionError(
        f'a clamp that gives way is not followed by {integrator} steps: use the implicit '
        'integrator, or leave clamp_compliance out of the motion'
    )
