# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Semi-implicit Euler as in the paper (Arnavaz et al. 2023): velocities first, then positions.

    v' = v - h f(x, v) / M,    x' = x + h v'

First-order, stable only for tiny steps (`stable_step`), and independent of the implicit one: the
cross-check of its derivatives. States are not stored but run again (`checkpoints`).
"""

from collections.abc import Sequence

from diffcal_ros.fem.motion.checkpoints import CheckpointPlan, Checkpoints, State
from diffcal_ros.fem.motion.dynamics import Dynamics
from diffcal_ros.fem.motion.frame_reader import FrameReader
from diffcal_ros.fem.motion.gradient_sum import GradientSum
from diffcal_ros.fem.motion.inputs import MotionError
from diffcal_ros.fem.motion.integrator import ByHeld, HeldAt, HeldChanges
from diffcal_ros.fem.motion.path import Path
from diffcal_ros.fem.motion.stable_step import stable_step
from diffcal_ros.fem.statics.force_changes import Change
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_MAX_HALVINGS = 4


class SemiImplicitIntegrator:
    """Steps as long as they are stable, but no longer than asked for."""

    name = 'semi_implicit'

    def __init__(self, dynamics: Dynamics, time_step: float, checkpoint_bytes: int) -> None:
        """Prepare marches.

        Args:
            dynamics: the equation of motion.
            time_step: longest step [s]; a whole fraction of it is taken.
            checkpoint_bytes: bound on the states held for the gradient.
        """
        self._dynamics = dynamics
        self._time_step = time_step
        self._checkpoint_bytes = checkpoint_bytes
        self._stamps = np.zeros(0)
        self._start: State = (np.zeros((0, 3)), np.zeros((0, 3)))
        self._held_at: HeldAt | None = None
        self._step = time_step
        self._count = 0
        self._halvings = 0
        self.checkpoints = Checkpoints(CheckpointPlan(1, 1))

    @property
    def step_count(self) -> int:
        """Number of steps of the last march."""
        return self._count

    @property
    def halvings(self) -> int:
        """How often the last march was begun anew with half the step."""
        return self._halvings

    @property
    def path(self) -> None:
        """Nothing: states are not kept."""
        return None

    @property
    def rungs(self) -> tuple[int, ...]:
        """Nothing: all steps are alike."""
        return ()

    @property
    def step_errors(self) -> FloatArray:
        """Nothing: they are not known."""
        return np.zeros(0)

    def march(
        self,
        start: FloatArray,
        stamps: FloatArray,
        held_at: HeldAt,
        rungs: Sequence[int] | None = None,
        near: Path | None = None,
    ) -> FrameReader:
        """March with steps of its own; see `Integrator`."""
        dynamics = self._dynamics
        velocities = np.zeros_like(start)
        velocities[dynamics.body.held_nodes] = held_at(0.0).velocities
        self._start, self._stamps, self._held_at = (start, velocities), stamps, held_at
        parts = np.ceil(self._time_step / stable_step(dynamics, start))
        self._step = self._time_step / float(parts)
        for self._halvings in range(_MAX_HALVINGS + 1):
            reader = self._try()
            if reader is not None:
                return reader
            self._step *= 0.5
        raise MotionError(
            f'the motion diverges even with a time step of {2.0 * self._step:.1e} s: the body may '
            'be released from too far off; use the implicit integrator'
        )

    def _try(self) -> FrameReader | None:
        """March with the present step; None where it diverges."""
        start = self._start[0]
        duration = float(self._stamps.max(initial=0.0))
        self._count = int(np.ceil(duration / self._step * (1.0 - 1e-12)))
        plan = CheckpointPlan.within(self._count, 2 * start.nbytes, self._checkpoint_bytes)
        self.checkpoints = Checkpoints(plan)
        reader = self._reader()
        reader.begin(start.shape)
        state = self._start
        reader.add(0, *state)
        for step in range(self._count):
            self.checkpoints.offer(step, state)
            state, _ = self._advance_once(state, step)
            reader.add(step + 1, *state)
            if step % plan.interval == 0 and not np.isfinite(state[0]).all():
                return None
        return reader if np.isfinite(state[0]).all() else None

    def _advance_once(self, state: State, step: int) -> tuple[State, FloatArray]:
        """Return the next state and the accelerations [m/s^2] that led there."""
        self._dynamics.go_to(self._time(step))
        accelerations = self._dynamics.accelerations(*state)
        velocities = state[1] + self._step * accelerations
        positions = state[0] + self._step * velocities
        if self._held_at is not None:
            nodes, held = self._dynamics.body.held_nodes, self._held_at(self._time(step + 1))
            positions[nodes], velocities[nodes] = held.positions, held.velocities
        return (positions, velocities), accelerations

    def _advance(self, state: State, begin: int, end: int) -> State:
        for step in range(begin, end):
            state, _ = self._advance_once(state, step)
        return state

    def _time(self, step: int) -> float:
        return step * self._step

    def _reader(self) -> FrameReader:
        times: FloatArray = self._step * np.arange(self._count + 1, dtype=np.float64)
        return FrameReader(times, self._stamps)

    def tangents(
        self, changes: Sequence[Change], start: FloatArray, held_changes: HeldChanges
    ) -> FloatArray:
        """Return tangents, run beside the motion; see `Integrator`."""
        dynamics, reader = self._dynamics, self._reader()
        state, moved, sped = self._start, start.copy(), np.zeros_like(start)
        self._hold(moved, sped, held_changes, 0)
        reader.begin(start.shape)
        reader.add(0, moved, sped)
        for step in range(self._count):
            after, accelerations = self._advance_once(state, step)
            for number, change in enumerate(changes):
                force = dynamics.residual_change(*state, accelerations, change)
                force += dynamics.force_tangent(*state, moved[number], sped[number])
                sped[number] -= self._step * force / dynamics.masses
            moved = moved + self._step * sped
            self._hold(moved, sped, held_changes, step + 1)
            state = after
            reader.add(step + 1, moved, sped)
        return reader.frames.swapaxes(0, 1)

    def _hold(
        self, moved: FloatArray, sped: FloatArray, held_changes: HeldChanges, step: int
    ) -> None:
        nodes = self._dynamics.body.held_nodes
        for number, held in enumerate(held_changes(self._time(step))):
            moved[number, nodes] = 0.0 if held is None else held.positions
            sped[number, nodes] = 0.0 if held is None else held.velocities

    def gradient(
        self, by_frames: FloatArray, by_held: ByHeld | None
    ) -> tuple[GradientSum, FloatArray]:
        """Return the gradient; see `Integrator`."""
        dynamics, reader, total = self._dynamics, self._reader(), GradientSum(self._dynamics)
        nodes = dynamics.body.held_nodes
        by_place, by_speed = (np.zeros_like(self._start[0]) for _ in range(2))
        for step, state in self.checkpoints.backward(self._count, self._advance):
            reader.add_adjoints(step + 1, by_frames, by_place, by_speed)
            if by_held is not None:
                by_held(self._time(step + 1), by_place[nodes].copy(), by_speed[nodes].copy())
            by_place[nodes] = by_speed[nodes] = 0.0
            by_speed += self._step * by_place
            adjoint = self._step * by_speed / dynamics.masses
            pulled = dynamics.pull_back(*state, adjoint, has_positions=True)
            total.add(*state, dynamics.accelerations(*state), adjoint)
            by_place -= pulled[0]
            by_speed -= pulled[1]
        reader.add_adjoints(0, by_frames, by_place, by_speed)
        if by_held is not None:
            by_held(0.0, np.zeros_like(by_place[nodes]), by_speed[nodes])
        return total, by_place
