# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A line every two seconds while a large body takes long: silence looks like a fault."""

from contextlib import AbstractContextManager
from functools import partial
import sys

from diffcal_ros.cli.repeating import repeating
from diffcal_ros.cli.say import say

_PERIOD = 2.0


def solve_progress(period: float = _PERIOD) -> AbstractContextManager[None]:
    """Say on standard error what takes longer than a period [s], once a period."""
    return repeating(period, partial(_say_what_runs, period), 'diffcal-solve-progress')


def _say_what_runs(period: float) -> None:
    # Commands that simulate nothing need not wait for the simulation to be imported.
    activity = sys.modules.get('diffcal_ros.fem.activity')
    running = activity.busy_with() if activity else None
    if running is None or running[1] < period:
        return
    line = f'{running[0]}: {running[1]:.0f} s so far'
    bars = sys.modules.get('tqdm')
    if bars is not None and sys.stderr.isatty():
        bars.tqdm.write(line, file=sys.stderr)
    else:
        say(line)
