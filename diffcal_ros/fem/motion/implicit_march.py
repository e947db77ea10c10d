# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Marching forward by implicit steps; a step that does not converge is halved."""

from diffcal_ros.fem.motion.dynamics import Dynamics
from diffcal_ros.fem.motion.generalised_alpha import StepRule, StepState
from diffcal_ros.fem.motion.held_nodes import HeldState
from diffcal_ros.fem.motion.inputs import MotionError
from diffcal_ros.fem.motion.integrator import HeldAt
from diffcal_ros.fem.motion.step_system import StepSystem
from diffcal_ros.fem.motion.trajectory import Trajectory
from diffcal_ros.fem.sparse_solver import NotPositiveDefiniteError
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Largest force left on a node, relative to the mean load. A cantilever's path is then met to
# 1e-9 m and the gradient to 2e-8 (1,750 tetrahedra over 0.4 s).
_FORCE_TOLERANCE = 1e-6
_MAX_NEWTON_STEPS = 20
# A factorisation is held while a round leaves no more than this share of the force.
_HELD_CONTRACTION = 0.2
_MAX_HALVINGS = 10
# So many good steps after a halving the step is doubled again.
_GOOD_STEPS = 4
# Forces are compared with masses under this acceleration where gravity is absent [m/s^2].
_LEAST_ACCELERATION = 1.0


class _StepFailedError(Exception):
    """Newton's method did not converge."""


def march(
    dynamics: Dynamics,
    system: StepSystem,
    rule: StepRule,
    begin: StepState,
    duration: float,
    held_at: HeldAt,
) -> Trajectory:
    """March until a duration is covered.

    Args:
        dynamics: the equation of motion.
        system: of its steps.
        rule: whose step is the longest to take.
        begin: state to start from.
        duration: [s].
        held_at: held nodes at a time since the start [s].

    Raises:
        MotionError: when a step does not converge however short it is.
    """
    trajectory = Trajectory()
    trajectory.append(0.0, begin)
    tolerance = _tolerance(dynamics)
    time, state, level, good_steps = 0.0, begin, 0, 0
    while time < duration * (1.0 - 1e-12):
        now = StepRule(rule.step / 2**level, rule.retained)
        try:
            held, guess = held_at(time + now.step), _guess(trajectory, now.step)
            state = _step(dynamics, system, now, state, held, guess, tolerance)
        except _StepFailedError as error:
            level, good_steps = level + 1, 0
            trajectory.halvings += 1
            if level > _MAX_HALVINGS:
                raise MotionError(
                    f'the motion does not go on {1e3 * time:.1f} ms after its start, not even '
                    f'with a time step of {now.step:.1e} s: the body may be too soft for its '
                    "load (raise Young's modulus) or be released from too far off"
                ) from error
            continue
        good_steps += 1
        if level > 0 and good_steps >= _GOOD_STEPS:
            level, good_steps = level - 1, 0
        # Whole steps are counted, so that their times carry no sum of roundings.
        time = time + now.step if trajectory.halvings else (len(trajectory.steps) + 1) * rule.step
        trajectory.steps.append(now.step)
        trajectory.append(time, state)
    return trajectory


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
