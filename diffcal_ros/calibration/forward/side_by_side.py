# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The same work for several bodies at once: sparse solvers let other threads run meanwhile."""

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
import os
from typing import TypeVar

Key = TypeVar('Key')
Result = TypeVar('Result')


def side_by_side(
    work: Callable[[Key], Result], keys: Iterable[Key], device: str
) -> dict[Key, Result]:
    """Do the work for every key, on as many threads as there are cores for it.

    On a GPU the bodies take turns: its launches wait for one another anyway.

    Args:
        work: touches nothing that another key's does.
        keys: in the order of the results.
        device: Warp device on which the work runs.

    Returns:
        Results by key.

    Raises:
        Exception: the first that any work raised, by the order of keys, when all have ended.
    """
    listed = tuple(keys)
    workers = min(len(listed), core_count()) if device == 'cpu' else 1
    if workers < 2:
        return {key: work(key) for key in listed}
    with ThreadPoolExecutor(workers) as pool:
        return dict(zip(listed, pool.map(work, listed), strict=True))


def core_count() -> int:
    """Return how many cores this process may keep busy; OMP_NUM_THREADS limits them."""
    given = os.environ.get('OMP_NUM_THREADS', '')
    if given.isdigit() and int(given) > 0:
        return int(given)
    return len(os.sched_getaffinity(0))
