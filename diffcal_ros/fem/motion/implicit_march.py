# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Marching forward by implicit steps; a step that does not converge is taken shorter."""

from dataclasses import dataclass

from diffcal_ros.fem.linear_solvers import NotPositiveDefiniteError
from diffcal_ros.fem.motion.dynamics import Dynamics
from diffcal_ros.fem.motion.generalised_alpha import StepRule, StepState
from diffcal_ros.fem.motion.held_nodes import HeldState
from diffcal_ros.fem.motion.inputs import MotionError
from diffcal_ros.fem.motion.integrator import HeldAt
from diffcal_ros.fem.motion.step_error import step_error
from diffcal_ros.fem.motion.step_sizes import MAX_HALVINGS, StepSizes
from diffcal_ros.fem.motion.step_system import StepSystem
from diffcal_ros.fem.motion.trajectory import Trajectory
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Largest force left on a node, relative to the mean load. A cantilever's path is then met to
# 1e-9 m and the gradient to 2e-8 (1,750 tetrahedra over 0.4 s).
_FORCE_TOLERANCE = 1e-6
_MAX_NEWTON_STEPS = 20
# A factorisation is held while a round leaves no more than this share of the force.
_HELD_CONTRACTION = 0.2
# Forces are compared with masses under this acceleration where gravity is absent [m/s^2].
_LEAST_ACCELERATION = 1.0


class _StepFailedError(Exception):
    """Newton's method did not converge."""


@dataclass(frozen=True)
class Marcher:
    """What all steps of a march share.

    Attributes:
        dynamics: the equation of motion.
        system: of its steps.
        longest: step [s].
        rho_inf: amplitude left of the fastest vibrations after a step.
        held_at: held nodes at a time since the start [s].
        is_measured: whether the error of every step is estimated.
    """

    dynamics: Dynamics
    system: StepSystem
    longest: float
    rho_inf: float
    held_at: HeldAt
    is_measured: bool = False

    def march(self, begin: StepState, duration: float, sizes: StepSizes) -> Trajectory:
        """March until a duration [s] is covered.

        Args:
            begin: state to start from.
            duration: [s].
            sizes: of the steps.

        Raises:
            MotionError: when a step does not converge however short it is.
        """
        trajectory = Trajectory()
        trajectory.append(0.0, begin)
        tolerance = _tolerance(self.dynamics)
        # Times are whole multiples of the shortest step: they carry no sum of roundings.
        tick, ticks, time, state = self.longest / 2**MAX_HALVINGS, 0, 0.0, begin
        while time < duration * (1.0 - 1e-12):
            rung = sizes.rung
            step = self.longest / 2**rung
            rule = trajectory.next_rule(step, self.rho_inf)
            try:
                end, error = self._try(trajectory, rule, time, state, tolerance)
            except _StepFailedError as failure:
                trajectory.halvings += 1
                if rung >= MAX_HALVINGS:
                    raise _given_up(time, step) from failure
                sizes.shorten()
                continue
            if not sizes.accepts(step, error):
                continue
            state, ticks = end, ticks + 2 ** (MAX_HALVINGS - rung)
            time = ticks * tick
            trajectory.steps.append(step)
            trajectory.rungs.append(rung)
            trajectory.append(time, state)
            if self.is_measured:
                trajectory.errors.append(error)
        return trajectory

    def _try(
        self,
        trajectory: Trajectory,
        rule: StepRule,
        time: float,
        begin: StepState,
        tolerance: float,
    ) -> tuple[StepState, float]:
        """Take a step; return its end and how far it is off [m]."""
        held, guess = self.held_at(time + rule.step), _guess(trajectory, rule.step)
        dynamics, system = self.dynamics, self.system
        end = _step(dynamics, system, rule, begin, held, guess, tolerance)
        if not self.is_measured:
            return end, 0.0
        try:
            return end, step_error(dynamics, system, rule, begin, end)
        except NotPositiveDefiniteError as error:
            raise _StepFailedError from error


def _given_up(time: float, step: float) -> MotionError:
    return MotionError(
        f'the motion does not go on {1e3 * time:.1f} ms after its start, not even with a time '
        f"step of {step:.1e} s: the body may be too soft for its load (raise Young's modulus) "
        'or be released from too far off'
    )


def _tolerance(dynamics: Dynamics) -> float:
    loads = np.linalg.norm(dynamics.loads[dynamics.free], axis=1)
    least = _LEAST_ACCELERATION * dynamics.masses[dynamics.free, 0]
    return _FORCE_TOLERANCE * float(np.maximum(loads, least).mean())


def _step(
    dynamics: Dynamics,
    system: StepSystem,
    rule: StepRule,
    begin: StepState,
    held: HeldState,
    guess: FloatArray,
    tolerance: float,
) -> StepState:
    """Take one step by Newton's method with a held factorisation."""
    free, nodes, known = dynamics.free, dynamics.body.held_nodes, rule.known(begin)
    inertia = rule.inertia * dynamics.masses
    constant = dynamics.masses * known.accelerations
    positions = guess
    positions[nodes] = held.positions
    before = np.inf
    for count in range(_MAX_NEWTON_STEPS):
        velocities = known.velocities + rule.rate * positions
        velocities[nodes] = held.velocities
        force = dynamics.forces(positions, velocities)
        force += constant
        force += inertia * positions
        unbalanced = force[free].ravel()
        largest = float(np.abs(unbalanced).max())
        if largest < tolerance:
            return _end(dynamics, rule, known, positions, held)
        if not np.isfinite(largest):
            break
        ratio, before = largest / before, largest
        if ratio > _HELD_CONTRACTION or not system.is_ready(rule):
            try:
                system.factor(rule, positions)
            except NotPositiveDefiniteError:
                break
            ratio = 1.0
        positions[free] -= system.apply(unbalanced)
        if count > 1 and largest * ratio < tolerance:
            # This round leaves less than the last one did.
            return _end(dynamics, rule, known, positions, held)
    raise _StepFailedError


def _guess(trajectory: Trajectory, step: float) -> FloatArray:
    """Return where the next step may end: on a parabola through the last three states."""
    states = trajectory.positions
    if trajectory.steps[-2:] == [step, step]:
        return 3.0 * (states[-1] - states[-2]) + states[-3]
    # Without the acceleration: that of a support just gone would turn elements inside out.
    return states[-1] + step * trajectory.velocities[-1]


def _end(
    dynamics: Dynamics, rule: StepRule, known: StepState, positions: FloatArray, held: HeldState
) -> StepState:
    end, nodes = rule.end(known, positions), dynamics.body.held_nodes
    end.velocities[nodes] = held.velocities
    end.filtered[nodes] = end.accelerations[nodes] = 0.0
    return end
