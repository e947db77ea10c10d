# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A line every two seconds while a large body takes long: silence looks like a fault."""

from contextlib import AbstractContextManager
import sys

from diffcal_ros.cli.repeating import repeating
from diffcal_ros.cli.say import say

_PERIOD = 2.0


def solve_progress(period: float = _PERIOD) -> AbstractContextManager[None]:
    """Say on standard error what takes longer than half a period [s], once a period."""
    # Asked twice as often: work that begins just after a question waits for the next but one.
    half = 0.5 * period
    return repeating(half, _Teller(half).tell, 'diffcal-solve-progress')


class _Teller:
    """Says what takes long, unless it did so when it was last asked."""

    def __init__(self, least: float) -> None:
        self._least, self._has_just_said = least, False

    def tell(self) -> None:
        if self._has_just_said:
            self._has_just_said = False
            return
        # Commands that simulate nothing need not wait for the simulation to be imported.
        activity = sys.modules.get('diffcal_ros.fem.activity')
        running = activity.busy_with(self._least) if activity else None
        if running is not None:
            _say_line(running)
            self._has_just_said = True


def _say_line(running: tuple[str, float]) -> None:
    line = f'{running[0]}: {running[1]:.0f} s so far'
    bars = sys.modules.get('tqdm')
    if bars is not None and sys.stderr.isatty():
        bars.tqdm.write(line, file=sys.stderr)
    else:
        say(line)
