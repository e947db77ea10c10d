# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A line every two seconds while a large body takes long: silence looks like a fault."""

from collections.abc import Iterator
from contextlib import contextmanager
import sys
from threading import Event, Thread

from diffcal_ros.cli.say import say

_PERIOD = 2.0


@contextmanager
def solve_progress(period: float = _PERIOD) -> Iterator[None]:
    """Say on standard error what takes longer than a period [s], once a period."""
    has_ended = Event()

    def beat() -> None:
        while not has_ended.wait(period):
            _say_what_runs(period)

    thread = Thread(target=beat, name='diffcal-solve-progress', daemon=True)
    thread.start()
    try:
        yield
    finally:
        has_ended.set()


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
