# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Processes that work for this one, and end with it, however it ends."""

from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context, parent_process
import os
import signal
import threading
from typing import Any

from diffcal_ros.blas_threads import keep_blas_to_one_thread


def process_pool(
    jobs: int,
    prepare: Callable[..., None] | None = None,
    *arguments: Any,
    threads: int | None = None,
) -> ProcessPoolExecutor:
    """Make a pool of processes.

    Args:
        jobs: how many.
        prepare: what each does first.
        arguments: of that; small, for what is longer than a pipe holds blocks this process for
            ever where the other one dies before it has read it.
        threads: that each may use; None: as this process.
    """
    # They inherit it before they load NumPy: threads of several pools that spin for the same cores
    # take up to six times as long as one.
    keep_blas_to_one_thread()
    return ProcessPoolExecutor(
        jobs,
        # A process that is forked would share Warp's threads, and a GPU's context.
        mp_context=get_context('spawn'),
        initializer=_begin,
        initargs=(threads, prepare, arguments),
    )


def _begin(
    threads: int | None, prepare: Callable[..., None] | None, arguments: tuple[Any, ...]
) -> None:
    # Who interrupts the first process from a terminal interrupts all of them, without words.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    if threads is not None:
        for name in ('OMP_NUM_THREADS', 'MKL_NUM_THREADS'):
            os.environ[name] = str(threads)
    if prepare is not None:
        prepare(*arguments)


def _end_with_parent() -> None:
    """Wait for the first process; who is killed ends no pool."""
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
