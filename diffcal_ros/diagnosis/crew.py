# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Refit models that add effects to one nominal model, several at a time.

Every process has bodies of its own, which it settles once. Threads would not do: most of the time
goes into sparse solvers, some of which hold Python's lock.
"""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
import ctypes
from dataclasses import dataclass, replace
import gc
from multiprocessing import get_context, parent_process
import os
import pickle
import signal
import threading
import time
from typing import Any, Protocol

from diffcal_ros.calibration.side_by_side import core_count
from diffcal_ros.diagnosis.candidates import Candidate
from diffcal_ros.diagnosis.evidence import Evidence
from diffcal_ros.diagnosis.hypothesis import Hypothesis, try_effects, with_effects
from diffcal_ros.diagnosis.refit import MAX_ITERATIONS, Refit, refit, UNFIT
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Progress = Callable[[str], None]

# Processes take some seconds to begin: with less than this left to do [s] they are not started.
_WORTH_STARTING = 15.0
# More would hardly find work.
_MOST = 8

# What a process refits, once it has begun.
_own: dict[str, Any] = {}


class Task(Protocol):
    """A refit that any process can do."""

    @property
    def max_iterations(self) -> int:
        """Evaluations of the model at most."""

    @property
    def words(self) -> str:
        """What is being done, for a person."""

    def fit(self, nominal: Evidence, base: Refit) -> Refit | None:
        """Refit; None where the model cannot be simulated."""


@dataclass(frozen=True)
class Look:
    """A model that is refitted from the nominal fit.

    Attributes:
        added: effects.
        starts: where amplitudes start, SI units by name; others at zero.
        max_iterations: evaluations of the model at most.
        least_evidence: logarithm of the evidence below which the model is of no use.
    """

    added: tuple[Candidate, ...]
    starts: dict[str, float]
    max_iterations: int
    least_evidence: float = -np.inf

    @property
    def words(self) -> str:
        """What is being done, for a person."""
        return f'refitting with {" and ".join(candidate.identifier for candidate in self.added)}'

    def fit(self, nominal: Evidence, base: Refit) -> Refit | None:
        """Refit; None where the model cannot be simulated."""
        found = try_effects(
            nominal,
            base,
            self.added,
            self.starts,
            max_iterations=self.max_iterations,
            least_evidence=self.least_evidence,
        )
        return None if found is None else found.fit


@dataclass(frozen=True)
class Continuation:
    """A model that is fitted on from where it stands, to the end.

    Attributes:
        added: effects.
        coordinates: where it stands, shape (k,).
        least_evidence: logarithm of the evidence below which the model is of no use.
        max_iterations: evaluations of the model at most.
    """

    added: tuple[Candidate, ...]
    coordinates: FloatArray
    least_evidence: float
    max_iterations: int = MAX_ITERATIONS

    @property
    def words(self) -> str:
        """What is being done, for a person."""
        names = sorted(candidate.identifier for candidate in self.added)
        return f'refitting with {" and ".join(names)} to the end'

    def fit(self, nominal: Evidence, base: Refit) -> Refit | None:
        """Refit; None where the model cannot be simulated."""
        _, evidence = with_effects(nominal, base, self.added)
        with suppress(*UNFIT):
            return refit(
                evidence,
                self.coordinates,
                max_iterations=self.max_iterations,
                least_evidence=self.least_evidence,
            )
        return None


class Crew:
    """Those who refit; a context that ends their processes.

    Attributes:
        nominal: evidence of the nominal model.
        base: its fit.
    """

    def __init__(
        self,
        nominal: Evidence,
        base: Refit,
        tell: Progress = lambda _: None,
        *,
        jobs: int = 1,
    ) -> None:
        """Begin nothing yet.

        Args:
            nominal: evidence of the nominal model.
            base: its fit.
            tell: told what is being done.
            jobs: processes at most; on a GPU there is only one.
        """
        self.nominal, self.base = nominal, base
        self._tell = tell
        self._jobs = min(jobs, _MOST) if nominal.model.device == 'cpu' else 1
        self._pool: ProcessPoolExecutor | None = None

    def __enter__(self) -> 'Crew':
        return self

    def __exit__(self, *_: object) -> None:
        if self._pool is not None:
            self._pool.shutdown(cancel_futures=True)
            self._pool = None

    def look(self, looks: Sequence[Look]) -> list[Hypothesis]:
        """Refit models; return those that can be simulated, in the same order."""
        return [
            self._hypothesis(look.added, fit)
            for look, fit in zip(looks, self._fits(looks), strict=True)
            if fit is not None
        ]

    def finish(self, hypotheses: Sequence[Hypothesis], least: Sequence[float]) -> list[Hypothesis]:
        """Fit models to the end; one that cannot be simulated again stays what it is.

        A state that was reached by small steps is not always found from another one.

        Args:
            hypotheses: models.
            least: logarithm of the evidence below which each is of no use.
        """
        tasks = [
            Continuation(h.added, h.fit.coordinates, evidence)
            for h, evidence in zip(hypotheses, least, strict=True)
        ]
        return [
            hypothesis if fit is None else replace(hypothesis, fit=fit)
            for hypothesis, fit in zip(hypotheses, self._fits(tasks), strict=True)
        ]

    def _hypothesis(self, added: tuple[Candidate, ...], fit: Refit) -> Hypothesis:
        scene, evidence = with_effects(self.nominal, self.base, added)
        return Hypothesis(added, scene, evidence, fit)

    def _fits(self, tasks: Sequence[Task]) -> list[Refit | None]:
        found: list[Refit | None] = []
        while len(found) < len(tasks):
            left = tasks[len(found) :]
            if self._pool is not None:
                found.extend(self._fits_in_pool(self._pool, left))
                continue
            begun = time.perf_counter()
            self._tell(left[0].words)
            found.append(_done(left[0], self.nominal, self.base))
            seconds = time.perf_counter() - begun
            if self._jobs > 1 and seconds * (len(left) - 1) > _WORTH_STARTING:
                self._pool = _start(self.nominal, self.base, self._jobs)
        return found

    def _fits_in_pool(
        self, pool: ProcessPoolExecutor, tasks: Sequence[Task]
    ) -> Iterator[Refit | None]:
        """Yield fits in order; fewer where a process has died, and then there is no pool."""
        try:
            # The longest first: none is left alone at the end.
            longest = sorted(range(len(tasks)), key=lambda place: -tasks[place].max_iterations)
            pending = {place: pool.submit(_fit, tasks[place]) for place in longest}
            for place, task in enumerate(tasks):
                self._tell(task.words)
                yield pending[place].result()
        except BrokenProcessPool:
            self._tell('a process died (was there memory enough?): going on in one')
            self.__exit__()
            self._jobs = 1


def _start(nominal: Evidence, base: Refit, jobs: int) -> ProcessPoolExecutor:
    """Start processes that know the nominal model."""
    threads = max(core_count() // jobs, 1)
    return ProcessPoolExecutor(
        jobs,
        # A process that is forked would share Warp's threads, and a GPU's context.
        mp_context=get_context('spawn'),
        initializer=_begin,
        initargs=(pickle.dumps((nominal, base)), threads),
    )


def _begin(known: bytes, threads: int) -> None:
    """Make bodies of this process's own, and end it as soon as it is of no use."""
    # Who interrupts the first process from a terminal interrupts all of them.
    signal.signal(signal.SIGINT, lambda *_: os._exit(1))
    threading.Thread(target=_end_with_parent, daemon=True).start()
    for name in ('OMP_NUM_THREADS', 'MKL_NUM_THREADS'):
        os.environ[name] = str(threads)
    with _quiet():
        _own['nominal'], _own['base'] = pickle.loads(known)


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


def _fit(task: Task) -> Refit | None:
    return _done(task, _own['nominal'], _own['base'])


def _done(task: Task, nominal: Evidence, base: Refit) -> Refit | None:
    try:
        return task.fit(nominal, base)
    finally:
        _give_back_memory()


def _give_back_memory() -> None:
    """Return what was freed to the system, which glibc would keep."""
    gc.collect()
    trim = getattr(ctypes.CDLL(None), 'malloc_trim', None)
    if trim is not None:
        trim(0)
