# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which step comes next: fixed ones, given ones, or as long as an error allows.

Every step is the longest one, halved a number of times: its *rung* on a ladder of powers of two.
Steps change seldom, so that a factorisation serves several of them, and times are whole multiples
of one tick.
"""

from collections.abc import Sequence
from typing import Protocol

from diffcal_ros.fem.motion.inputs import MotionError

MAX_HALVINGS = 10
# So many good steps after a shorter one the step is doubled again.
_GOOD_STEPS = 4
# A step twice as long errs eight times as much; half of what is allowed is left as a margin.
_GOOD_FRACTION = 1.0 / 16.0


class StepSizes(Protocol):
    """What a march asks before and after every step."""

    @property
    def rung(self) -> int:
        """How often the next step halves the longest one."""

    def shorten(self) -> None:
        """Go on with a shorter step: the last one did not converge."""

    def accepts(self, step: float, error: float) -> bool:
        """Tell whether a step [s] stands with its error [m], and choose the next one."""


class _Ladder:
    """Goes down a rung at once, and up again after some good steps."""

    def __init__(self, rung: int = 0) -> None:
        self._rung = rung
        self._good_steps = 0

    @property
    def rung(self) -> int:
        """Rung of the next step."""
        return self._rung

    def shorten(self) -> None:
        """Halve the step; see `StepSizes`."""
        self._rung, self._good_steps = self._rung + 1, 0

    def _count(self, *, is_good: bool) -> None:
        """Count good steps on end, and double the step where there are enough."""
        self._good_steps = self._good_steps + 1 if is_good else 0
        if self._rung > 0 and self._good_steps >= _GOOD_STEPS:
            self._rung, self._good_steps = self._rung - 1, 0


class FixedSteps(_Ladder):
    """The longest step, halved where it does not converge."""

    def accepts(self, step: float, error: float) -> bool:
        """Take every step; see `StepSizes`."""
        self._count(is_good=True)
        return True


class GivenSteps:
    """The steps of an earlier march; the last one is repeated where they end."""

    def __init__(self, rungs: Sequence[int]) -> None:
        """Take rungs, one at least."""
        self._left = list(reversed(rungs))

    @property
    def rung(self) -> int:
        """Rung of the next step."""
        return self._left[-1]

    def shorten(self) -> None:
        """Take the step in two; see `StepSizes`."""
        self._left[-1:] = [self.rung + 1] * 2

    def accepts(self, step: float, error: float) -> bool:
        """Take every step; see `StepSizes`."""
        if len(self._left) > 1:
            self._left.pop()
        return True


class ControlledSteps(_Ladder):
    """Steps as long as each of them errs no more than a tolerance.

    The tolerance is that of one step, not its share of the time: fast vibrations after a release
    err by their amplitude once, however many steps that takes, and a share of the time would chase
    them with ever shorter steps.
    """

    def __init__(self, tolerance: float, rung: int) -> None:
        """Take what a step may err by [m], and the rung of the first step that is tried."""
        super().__init__(rung)
        self._tolerance = tolerance

    def accepts(self, step: float, error: float) -> bool:
        """Refuse a step that errs too much; see `StepSizes`.

        Raises:
            MotionError: when the shortest step errs too much.
        """
        if error > self._tolerance:
            if self._rung >= MAX_HALVINGS:
                raise MotionError(
                    f'a tolerance of {self._tolerance:.2g} m in a step would need time steps '
                    f'below {step:.1e} s: raise `motion.tolerance`'
                )
            self.shorten()
            return False
        self._count(is_good=error < _GOOD_FRACTION * self._tolerance)
        return True
