# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Going back through a long march with a bounded number of states in memory.

The march keeps a state every so many steps. Going back, each stretch between two of them is run
again: at once where all its states have room, else its later half first and then its earlier one
(as in Griewank 1992, with halves in place of binomial parts).
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
# Positions [m] and velocities [m/s], shape (N, 3) each.
State = tuple[FloatArray, FloatArray]
# Runs from a state at one step to another step.
Advance = Callable[[State, int, int], State]


@dataclass(frozen=True)
class CheckpointPlan:
    """Where states are kept.

    Attributes:
        interval: steps between two of them.
        room: how many successive states may be held besides.
    """

    interval: int
    room: int

    @classmethod
    def within(cls, step_count: int, state_bytes: int, memory: int) -> 'CheckpointPlan':
        """Plan for so many steps.

        Args:
            step_count: of the march.
            state_bytes: of one state.
            memory: bound on all states together [bytes].

        Raises:
            ValueError: when not even the least fits.
        """
        least = 2 + 2 * max(int(np.ceil(np.log2(max(step_count, 2)))), 1)
        states = memory // state_bytes
        if states < least:
            raise ValueError(
                f'{memory / 1e6:.3g} MB are allowed for checkpoints: {step_count} steps of this '
                f'body need {least * state_bytes / 1e6:.3g} MB at least'
            )
        half = states // 2
        return cls(interval=int(np.ceil(max(step_count, 1) / (half // 2 + 1))), room=half - 1)


class Checkpoints:
    """States kept along one march."""

    def __init__(self, plan: CheckpointPlan) -> None:
        self._plan = plan
        self._kept: dict[int, State] = {}
        self.largest_count = 0

    def offer(self, step: int, state: State) -> None:
        """Keep a state if the plan says so."""
        if step % self._plan.interval == 0:
            self._kept[step] = (state[0].copy(), state[1].copy())

    def backward(self, step_count: int, advance: Advance) -> Iterator[tuple[int, State]]:
        """Yield the state before each step, last step first."""
        interval = self._plan.interval
        end = step_count
        for begin in range((step_count - 1) // interval * interval, -1, -interval):
            yield from self._stretch(begin, end, self._kept[begin], advance, 0)
            end = begin

    def _stretch(
        self, begin: int, end: int, state: State, advance: Advance, depth: int
    ) -> Iterator[tuple[int, State]]:
        if end - begin <= max(self._plan.room - depth, 1):
            states = [state]
            for step in range(begin, end - 1):
                states.append(advance(states[-1], step, step + 1))
            self.largest_count = max(self.largest_count, len(states) + depth + len(self._kept))
            for step in range(end - 1, begin - 1, -1):
                yield step, states.pop()
            return
        middle = (begin + end) // 2
        yield from self._stretch(middle, end, advance(state, begin, middle), advance, depth + 1)
        yield from self._stretch(begin, middle, state, advance, depth)
