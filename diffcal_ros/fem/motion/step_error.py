# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How far a step of the generalised-alpha rule is off, from its own accelerations.

The rule leaves an error of c h^2 (a' - a) in positions, a third power of the step, as for
Newmark's (Zienkiewicz and Xie 1991). Vibrations too fast for the step have huge accelerations and
small errors, which end where the vibration does, while those of slow modes add up to a wrong
phase. So the estimate goes twice through (inertia M + stiffness)^-1 inertia M of the step, which
leaves slow modes as they are and takes fast ones out (once: Shampine's filter for stiff problems,
which still leaves their amplitude).
"""

from diffcal_ros.fem.motion.dynamics import Dynamics
from diffcal_ros.fem.motion.generalised_alpha import StepRule, StepState
from diffcal_ros.fem.motion.step_system import StepSystem
import numpy as np

_FILTERINGS = 2


def step_error(
    dynamics: Dynamics, system: StepSystem, rule: StepRule, begin: StepState, end: StepState
) -> float:
    """Return about how far the worst node is off by one step [m].

    Args:
        dynamics: the equation of motion.
        system: of its steps; its factorisation for steps of this size serves.
        rule: of the step.
        begin: state before it.
        end: state after it.

    Raises:
        NotPositiveDefiniteError: when the matrix of the step is indefinite.
    """
    free = dynamics.free
    change = end.filtered[free] - rule.filtered_at(begin)[free]
    error = rule.error_fraction * rule.step**2 * change
    if not system.is_ready(rule):
        system.factor(rule, end.positions)
    inertia = rule.inertia * dynamics.masses[free]
    for _ in range(_FILTERINGS):
        error = system.apply((inertia * error).ravel())
    return float(np.linalg.norm(error, axis=1).max(initial=0.0))
