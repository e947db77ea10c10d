# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where a step may end, before it is taken: from the last states, and from a like motion."""

from collections.abc import Callable

from diffcal_ros.fem.motion.path import Path
from diffcal_ros.fem.motion.trajectory import Trajectory
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
# Returns the largest force [N] that a guess of a step's end leaves.
Unbalanced = Callable[[FloatArray], float]

# A polynomial through the last states foretells the next one: by its degree, their weights, the
# last one's first.
_WEIGHTS = ((1.0,), (2.0, -1.0), (3.0, -3.0, 1.0), (4.0, -6.0, 4.0, -1.0))
# Degrees are compared every so many steps.
_HOLDS = 8


class Predictor:
    """Foretells the ends of a march's steps.

    What a release has set ringing no polynomial foretells: the higher its degree, the more of that
    it adds. So the degree is the one that leaves least force. Beside a like motion polynomials
    foretell only the distance from that.
    """

    def __init__(self, near: Path | None) -> None:
        """Prepare a march.

        Args:
            near: a motion that this one is like; None: none is known.
        """
        self._near = near
        self._degree = 2
        self._left = 0

    def guess(self, trajectory: Trajectory, step: float, unbalanced: Unbalanced) -> FloatArray:
        """Return positions at the end of the next step [m], shape (N, 3).

        Args:
            trajectory: so far.
            step: size of the next step [s].
            unbalanced: tells how good a guess is.
        """
        highest = min(_even_steps(trajectory, step), len(_WEIGHTS) - 1)
        times = [*trajectory.times[-highest - 1 :], trajectory.times[-1] + step]
        states = trajectory.positions[-highest - 1 :]
        passed = [] if self._near is None else [self._near.at(time) for time in times]
        others = [state[0] for state in passed if state is not None]
        if len(others) == len(times):
            states = [own - other for own, other in zip(states, others[:-1], strict=True)]
            ahead: FloatArray | float = others[-1]
        else:
            ahead = 0.0
        if self._left and self._degree <= highest:
            self._left -= 1
            return _extended(states, self._degree) + ahead
        guesses = {degree: _extended(states, degree) + ahead for degree in range(highest + 1)}
        self._degree = min(guesses, key=lambda degree: unbalanced(guesses[degree]))
        self._left = _HOLDS if highest == len(_WEIGHTS) - 1 else 0
        return guesses[self._degree]


def _even_steps(trajectory: Trajectory, step: float) -> int:
    """Return how many of the last steps are as long as the next one."""
    count = 0
    while count < len(trajectory.steps) and trajectory.steps[-1 - count] == step:
        count += 1
    return count


def _extended(states: list[FloatArray], degree: int) -> FloatArray:
    """Return the next value of a polynomial through the last states."""
    weights = _WEIGHTS[degree]
    total = weights[0] * states[-1]
    for number, weight in enumerate(weights[1:], start=2):
        total = total + weight * states[-number]
    return total
