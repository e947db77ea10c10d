# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The default integrator: implicit, second-order, stable at any step."""

from collections.abc import Sequence

from diffcal_ros.fem.motion.dynamics import Dynamics
from diffcal_ros.fem.motion.frame_reader import FrameReader
from diffcal_ros.fem.motion.generalised_alpha import StepState
from diffcal_ros.fem.motion.giving_derivatives import GivingDerivatives, would_give_way
from diffcal_ros.fem.motion.gradient_sum import GradientSum
from diffcal_ros.fem.motion.implicit_derivatives import ImplicitDerivatives
from diffcal_ros.fem.motion.implicit_march import Marcher
from diffcal_ros.fem.motion.integrator import ByHeld, HeldAt, HeldChanges
from diffcal_ros.fem.motion.path import Path
from diffcal_ros.fem.motion.step_sizes import (
    ControlledSteps,
    FixedSteps,
    GivenSteps,
    StepSizes,
)
from diffcal_ros.fem.motion.step_system import StepSystem
from diffcal_ros.fem.motion.trajectory import Trajectory
from diffcal_ros.fem.statics.force_changes import Change
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Keeps the swing of a beam and still settles what a step cannot follow: see
# docs/decisions/implicit-integrator.md.
RHO_INF = 0.8
# The first step that is tried under control [s].
_FIRST_STEP = 1.0 / 240.0


class ImplicitIntegrator:
    """Generalised-alpha steps; stores positions and velocities of each."""

    name = 'implicit'

    def __init__(
        self,
        dynamics: Dynamics,
        time_step: float,
        *,
        tolerance: float | None = None,
        rho_inf: float = RHO_INF,
        has_derivatives: bool = True,
    ) -> None:
        """Prepare marches.

        Args:
            dynamics: the equation of motion.
            time_step: longest step [s].
            tolerance: what one step may be off by [m]; None: steps are fixed.
            rho_inf: amplitude left of the fastest vibrations after a step, 0 to 1.
            has_derivatives: tangents or gradients are asked for.
        """
        self._dynamics = dynamics
        self._longest, self._rho_inf = time_step, rho_inf
        self._tolerance = tolerance
        self._system = StepSystem(dynamics, has_derivatives=has_derivatives)
        self._trajectory = Trajectory()
        self._stamps = np.zeros(0)

    @property
    def step_count(self) -> int:
        """Number of steps of the last march."""
        return len(self._trajectory.steps)

    @property
    def halvings(self) -> int:
        """How often a step of the last march had to be halved."""
        return self._trajectory.halvings

    @property
    def rungs(self) -> tuple[int, ...]:
        """How often each step of the last march halves the longest one."""
        return tuple(self._trajectory.rungs)

    @property
    def step_errors(self) -> FloatArray:
        """What each step of the last march is off by, about [m]; empty without a tolerance."""
        return np.array(self._trajectory.errors)

    @property
    def path(self) -> Path | None:
        """Where the last march went; None before the first."""
        return self._trajectory.path if self._trajectory.times else None

    def march(
        self,
        start: FloatArray,
        stamps: FloatArray,
        held_at: HeldAt,
        rungs: Sequence[int] | None = None,
        near: Path | None = None,
    ) -> FrameReader:
        """March; see `Integrator`."""
        dynamics = self._dynamics
        velocities = np.zeros_like(start)
        velocities[dynamics.body.held_nodes] = held_at(0.0).velocities
        dynamics.go_to(0.0)
        accelerations = dynamics.accelerations(start, velocities)
        begin = StepState(start, velocities, accelerations, accelerations)
        self._system.forget()
        self._stamps = stamps
        duration = float(stamps.max(initial=0.0))
        marcher = Marcher(
            dynamics,
            self._system,
            self._longest,
            self._rho_inf,
            held_at,
            is_measured=self._tolerance is not None,
            near=near,
        )
        self._trajectory = marcher.march(begin, duration, self._sizes(rungs))
        reader = self._reader()
        reader.begin(start.shape)
        states = zip(self._trajectory.positions, self._trajectory.velocities, strict=True)
        for index, state in enumerate(states):
            reader.add(index, *state)
        return reader

    def _sizes(self, rungs: Sequence[int] | None) -> StepSizes:
        if rungs:
            return GivenSteps(rungs)
        if self._tolerance is None:
            return FixedSteps()
        rung = max(0, int(np.ceil(np.log2(self._longest / _FIRST_STEP))))
        return ControlledSteps(self._tolerance, rung)

    def tangents(
        self, changes: Sequence[Change], start: FloatArray, held_changes: HeldChanges
    ) -> FloatArray:
        """Return tangents; see `Integrator`."""
        reader, derivatives = self._reader(), self._derivatives()
        if self._dynamics.clamp.gives_way or would_give_way(changes):
            derivatives = self._derivatives(GivingDerivatives)
        derivatives.tangents(changes, start, held_changes, reader)
        return reader.frames.swapaxes(0, 1)

    def gradient(
        self, by_frames: FloatArray, by_held: ByHeld | None
    ) -> tuple[GradientSum, FloatArray]:
        """Return the gradient; see `Integrator`."""
        return self._derivatives().gradient(by_frames, self._reader(), by_held)

    def _reader(self) -> FrameReader:
        return FrameReader(np.array(self._trajectory.times), self._stamps)

    def _derivatives(
        self, kind: type[ImplicitDerivatives] = ImplicitDerivatives
    ) -> ImplicitDerivatives:
        return kind(self._dynamics, self._system, self._rho_inf, self._trajectory)
