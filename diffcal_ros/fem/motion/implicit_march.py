# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Marching forward by implicit steps; a step that does not converge is taken shorter."""

from dataclasses import dataclass, field

from diffcal_ros.fem.linear_solvers import NotPositiveDefiniteError
from diffcal_ros.fem.motion.dynamics import Dynamics
from diffcal_ros.fem.motion.generalised_alpha import StepRule, StepState
from diffcal_ros.fem.motion.giving_step import GivingStep, LastResponse
from diffcal_ros.fem.motion.implicit_step import ImplicitStep, StepFailedError
from diffcal_ros.fem.motion.inputs import MotionError
from diffcal_ros.fem.motion.integrator import HeldAt
from diffcal_ros.fem.motion.path import Path
from diffcal_ros.fem.motion.prediction import Predictor
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
# Forces are compared with masses under this acceleration where gravity is absent [m/s^2].
_LEAST_ACCELERATION = 1.0


@dataclass(frozen=True)
class Marcher:
    """What all steps of a march share.

    Attributes:
        dynamics: the equation of motion.
        system: of its steps.
        longest: step [s].
        rho_inf: amplitude left of the fastest vibrations after a step.
        held_at: held nodes at a time since the start [s], with a rigid clamp.
        is_measured: whether the error of every step is estimated.
        near: a motion that this one is like; None: none is known.
    """

    dynamics: Dynamics
    system: StepSystem
    longest: float
    rho_inf: float
    held_at: HeldAt
    is_measured: bool = False
    near: Path | None = None
    _last: LastResponse = field(default_factory=LastResponse)

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
        predictor = Predictor(self.near)
        tolerance = _tolerance(self.dynamics)
        # Times are whole multiples of the shortest step: they carry no sum of roundings.
        tick, ticks, time, state = self.longest / 2**MAX_HALVINGS, 0, 0.0, begin
        while time < duration * (1.0 - 1e-12):
            rung = sizes.rung
            step = self.longest / 2**rung
            rule = trajectory.next_rule(step, self.rho_inf)
            try:
                end, error = self._try(trajectory, rule, predictor, state, tolerance)
            except StepFailedError as failure:
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
        predictor: Predictor,
        begin: StepState,
        tolerance: float,
    ) -> tuple[StepState, float]:
        """Take a step; return its end and how far it is off [m]."""
        dynamics, system = self.dynamics, self.system
        time = trajectory.times[-1] + rule.step
        dynamics.go_to(time)
        held = self.held_at(time)
        step: ImplicitStep | GivingStep
        step = ImplicitStep(dynamics, system, rule, begin, held, tolerance)
        if dynamics.clamp.gives_way:
            step = GivingStep(step, dynamics.clamp, self._last)
        end = step.take(predictor.guess(trajectory, rule.step, step.unbalanced))
        if not self.is_measured:
            return end, 0.0
        try:
            return end, step_error(dynamics, system, rule, begin, end)
        except NotPositiveDefiniteError as error:
            raise StepFailedError from error


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
