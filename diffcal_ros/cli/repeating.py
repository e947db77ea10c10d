# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Do something again and again, in a thread of its own, while something else goes on."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Event, Thread


@contextmanager
def repeating(period: float, beat: Callable[[], None], name: str) -> Iterator[None]:
    """Call a function once a period until the `with` block ends.

    Args:
        period: between calls, and before the first one [s].
        beat: what is called.
        name: of the thread.
    """
    has_ended = Event()

    def run() -> None:
        while not has_ended.wait(period):
            beat()

    thread = Thread(target=run, name=name, daemon=True)
    thread.start()
    try:
        yield
    finally:
        has_ended.set()
        thread.join(1.0)  # One that cannot write must not hold up the end.
