# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Processes with bodies of their own, which each of them settles once.

Threads would not do: most of a refit's time goes into sparse solvers, some of which hold Python's
lock.
"""

from collections.abc import Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
import ctypes
import gc
from multiprocessing import get_context, parent_process
import os
from pathlib import Path
import pickle
import signal
from tempfile import TemporaryDirectory
import threading
from typing import Any

from diffcal_ros.calibration.side_by_side import core_count
from diffcal_ros.diagnosis.evidence import Evidence
from diffcal_ros.diagnosis.refit import Refit
from diffcal_ros.diagnosis.tasks import Task

# What a process refits, once it has begun.
_own: dict[str, Any] = {}


class Processes:
    """Processes that know the nominal model."""

    def __init__(self, nominal: Evidence, base: Refit, jobs: int) -> None:
        """Start them.

        Args:
            nominal: evidence of the nominal model.
            base: its fit.
            jobs: how many processes; they share the cores.
        """
        # Not an argument: what is longer than a pipe holds blocks this process for ever where
        # the other one dies before it has read it.
        self._folder = TemporaryDirectory(prefix='diffcal-')
        known = Path(self._folder.name) / 'nominal.pickle'
        known.write_bytes(pickle.dumps((nominal, base)))
        self._pool = ProcessPoolExecutor(
            jobs,
            # A process that is forked would share Warp's threads, and a GPU's context.
            mp_context=get_context('spawn'),
            initializer=_begin,
            initargs=(known, max(core_count() // jobs, 1)),
        )

    def submit(self, task: Task) -> 'Future[Refit | None]':
        """Let one of them refit.

        Raises:
            BrokenProcessPool: one of them died, or cannot be started; what is pending says so,
                too.
        """
        try:
            return self._pool.submit(_fit, task)
        except OSError as error:
            raise BrokenProcessPool(f'a process cannot be started: {error}') from error

    def end(self) -> None:
        """Do what has begun, and end them."""
        self._pool.shutdown(cancel_futures=True)
        self._folder.cleanup()


def fit_here(task: Task, nominal: Evidence, base: Refit) -> Refit | None:
    """Refit in the process that calls."""
    try:
        return task.fit(nominal, base)
    finally:
        _give_back_memory()


def _begin(known: Path, threads: int) -> None:
    """Make bodies of this process's own, and end it as soon as it is of no use."""
    # Who interrupts the first process from a terminal interrupts all of them.
    signal.signal(signal.SIGINT, lambda *_: os._exit(1))
    threading.Thread(target=_end_with_parent, daemon=True).start()
    for name in ('OMP_NUM_THREADS', 'MKL_NUM_THREADS'):
        os.environ[name] = str(threads)
    with _quiet():
        _own['nominal'], _own['base'] = pickle.loads(known.read_bytes())


def _fit(task: Task) -> Refit | None:
    return fit_here(task, _own['nominal'], _own['base'])


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


@contextmanager
def _quiet() -> Iterator[None]:
    """Say nothing of the device, as the first process did: not from native code either."""
    kept = os.dup(2)
    with open(os.devnull, 'w') as nowhere:
        os.dup2(nowhere.fileno(), 2)
    try:
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)


def _give_back_memory() -> None:
    """Return what was freed to the system, which glibc would keep."""
    gc.collect()
    trim = getattr(ctypes.CDLL(None), 'malloc_trim', None)
    if trim is not None:
        trim(0)
