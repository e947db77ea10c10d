# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Processes with bodies of their own, which each of them settles once.

Threads would not do: most of a refit's time goes into sparse solvers, some of which hold Python's
lock.
"""

from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
import ctypes
import gc
from pathlib import Path
import pickle
from tempfile import TemporaryDirectory
from typing import Any

from diffcal_ros.calibration.forward.side_by_side import core_count
from diffcal_ros.diagnosis.model_comparison.refit_requests import Task
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.process_pool import process_pool

# What a process refits, once it has begun.
_own: dict[str, Any] = {}


class Processes:
    """Processes that know the nominal model."""

    def __init__(self, nominal: PatchEvaluator, base: Refit, jobs: int) -> None:
        """Start them.

        Args:
            nominal: evaluates the patches of the nominal model.
            base: its fit.
            jobs: how many processes; they share the cores.
        """
        # Not an argument: it is longer than a pipe holds.
        self._folder = TemporaryDirectory(prefix='diffcal-')
        known = Path(self._folder.name) / 'nominal.pickle'
        known.write_bytes(pickle.dumps((nominal, base)))
        self._pool = process_pool(jobs, _read_model, known, threads=max(core_count() // jobs, 1))

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


def fit_here(task: Task, nominal: PatchEvaluator, base: Refit) -> Refit | None:
    """Refit in the process that calls."""
    try:
        return task.fit(nominal, base)
    finally:
        _give_back_memory()


def _read_model(known: Path) -> None:
    """Make bodies of this process's own."""
    _own['nominal'], _own['base'] = pickle.loads(known.read_bytes())


def _fit(task: Task) -> Refit | None:
    return fit_here(task, _own['nominal'], _own['base'])


def _give_back_memory() -> None:
    """Return what was freed to the system, which glibc would keep."""
    gc.collect()
    trim = getattr(ctypes.CDLL(None), 'malloc_trim', None)
    if trim is not None:
        trim(0)
