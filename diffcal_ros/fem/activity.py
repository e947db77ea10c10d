# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What takes long just now, for whoever shows progress: any thread may tell, any may ask."""

from collections.abc import Iterator
from contextlib import contextmanager
from threading import get_ident, Lock
import time

_LOCK = Lock()
_RUNNING: dict[int, list[tuple[str, float]]] = {}
# Fewer take no time that is worth a word.
_TOLD_FROM = 20_000


@contextmanager
def during(work: str, unknowns: int) -> Iterator[None]:
    """Tell that this thread is busy with some work; within other work it is told instead.

    Args:
        work: what it does.
        unknowns: how large that is; small work is not told.
    """
    if unknowns < _TOLD_FROM:
        yield
        return
    with _LOCK:
        _RUNNING.setdefault(get_ident(), []).append((work, time.monotonic()))
    try:
        yield
    finally:
        with _LOCK:
            told = _RUNNING[get_ident()]
            told.pop()
            if not told:
                del _RUNNING[get_ident()]


def busy_with(least: float = 0.0) -> tuple[str, float] | None:
    """Return what has been running for longest and for how long [s]; None: nothing long.

    Args:
        least: what is within other work and runs for a shorter time [s] is passed over for it.
    """
    latest = time.monotonic() - least
    with _LOCK:
        long = [[one for one in works if one[1] <= latest] for works in _RUNNING.values()]
    told = [works[-1] for works in long if works]
    if not told:
        return None
    work, begun = min(told, key=lambda one: one[1])
    return work, time.monotonic() - begun
