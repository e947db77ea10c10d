# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Processes with bodies of their own, which begin where those of the first process are.

Threads would not do: most of a refit's time goes into sparse solvers, some of which hold Python's
lock.
"""

from collections.abc import Iterator
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
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

# What a start raises: where the first process of a pool died its pipes are closed while another
# one begins.
_NOT_STARTED = (OSError, ValueError)
# What a process refits, once it has begun.
_own: dict[str, Any] = {}


class Processes:
    """Processes that come to know the nominal model; they begin while that is still sought."""

    def __init__(self, jobs: int) -> None:
        """Start them; what they need is loaded while the first process goes on.

        Args:
            jobs: how many processes; they share the cores.
        """
        # Not an argument: it is longer than a pipe holds.
        self._folder = TemporaryDirectory(prefix='diffcal-')
        self._known = Path(self._folder.name) / 'nominal.pickle'
        self._pool = process_pool(jobs, threads=max(core_count() // jobs, 1))
        with suppress(*_NOT_STARTED, BrokenProcessPool):  # Whoever hands out work is told.
            for _ in range(jobs):
                self._pool.submit(_begin)

    def teach(self, nominal: PatchEvaluator, base: Refit) -> None:
        """Tell them the nominal model, before the first task.

        Args:
            nominal: evaluates the patches of the nominal model.
            base: its fit.
        """
        self._known.write_bytes(pickle.dumps((nominal, base)))

    def submit(self, task: Task) -> 'Future[Refit | None]':
        """Let one of them refit.

        Raises:
            BrokenProcessPool: one of them died, or cannot be started; what is pending says so,
                too.
        """
        try:
            return self._pool.submit(_fit, self._known, task)
        except _NOT_STARTED as error:
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


@contextmanager
def all_set_aside() -> Iterator[None]:
    """Take what is there for no garbage, so that each refit gives back its own memory at once.

    To look through all that is loaded takes a tenth of a second. A caller who has set things aside
    keeps them there.
    """
    is_ours = gc.get_freeze_count() == 0
    if is_ours:
        gc.freeze()
    try:
        yield
    finally:
        if is_ours:
            gc.unfreeze()


def _begin() -> None:
    """Take down what is there: to find this function a process loads all that refits need."""
    # None of that is ever garbage, see `all_set_aside`.
    gc.freeze()


def _fit(known: Path, task: Task) -> Refit | None:
    if not _own:
        _own['nominal'], _own['base'] = pickle.loads(known.read_bytes())
    return fit_here(task, _own['nominal'], _own['base'])


def _give_back_memory() -> None:
    """Return what was freed to the system, which glibc would keep."""
    gc.collect()
    trim = getattr(ctypes.CDLL(None), 'malloc_trim', None)
    if trim is not None:
        trim(0)
