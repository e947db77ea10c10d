# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Processes that work for this one, and end with it, however it ends."""

from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context, parent_process
import os
import signal
import threading

from diffcal_ros.blas_threads import keep_blas_to_one_thread


def process_pool(jobs: int, *, threads: int | None = None) -> ProcessPoolExecutor:
    """Make a pool of processes.

    Args:
        jobs: how many.
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
        initargs=(threads,),
    )


def _begin(threads: int | None) -> None:
    # Who interrupts the first process from a terminal interrupts all of them, without words.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    if threads is not None:
        for name in ('OMP_NUM_THREADS', 'MKL_NUM_THREADS'):
            os.environ[name] = str(threads)


def _end_with_parent() -> None:
    """Wait for the first process; who is killed ends no pool."""
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
