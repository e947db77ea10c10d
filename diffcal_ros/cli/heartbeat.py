# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A sign of life from phases that take long and say nothing themselves."""

from collections.abc import Callable
from contextlib import ExitStack
import time
from types import TracebackType

from diffcal_ros.cli.repeating import repeating
from diffcal_ros.cli.say import say

# Longer than anybody waits without wondering, and short beside what takes long [s].
_SILENCE = 20.0


class Heartbeat:
    """Says every so often which phase goes on, and for how long; use it in a `with` block."""

    def __init__(
        self, phase: str, *, silence: float = _SILENCE, say: Callable[[str], None] = say
    ) -> None:
        """Start with a phase that is not announced.

        Args:
            phase: what is being done, in words.
            silence: after which it is said, again and again [s].
            say: takes a line.
        """
        self._phase, self._silence, self._say = phase, silence, say
        self._begun, self._is_new = time.monotonic(), False
        self._running = ExitStack()

    def report(self, text: str) -> None:
        """Announce another phase."""
        self._phase, self._begun, self._is_new = text, time.monotonic(), True
        self._say(text)

    def __enter__(self) -> 'Heartbeat':
        self._running.enter_context(repeating(self._silence, self._beat, 'diffcal-heartbeat'))
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._running.close()

    def _beat(self) -> None:
        if self._is_new:  # What was just announced needs no sign of life yet.
            self._is_new = False
            return
        self._say(f'{self._phase}: {time.monotonic() - self._begun:.0f} s so far')
