# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Refit models that add effects to one nominal model, several at a time."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import replace
import time

from diffcal_ros.diagnosis.model_comparison.effect_refit import with_effects
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.model_comparison.processes import fit_here, Processes
from diffcal_ros.diagnosis.model_comparison.refit_requests import Continuation, RefitRequest, Task
from diffcal_ros.diagnosis.patch_fits.patch_fit import FROM_A_FIT
from diffcal_ros.diagnosis.patch_fits.refit import MAX_ITERATIONS, Refit, weighed_anew
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.patches.patch_gap import residual_size
from diffcal_ros.diagnosis.patches.whitened import Part
from diffcal_ros.diagnosis.screening.usual_sizes import all_sized
import numpy as np

Progress = Callable[[str], None]

# Processes take two seconds to begin: where refits take less than this in all [s], by those that
# were done and those that are asked for, they are not started.
_WORTH_STARTING = 6.0
# A nominal fit of as many seconds is followed by refits of more, where something is missing.
_LONG_NOMINAL_FIT = 3.0
# More would hardly find work.
_MOST = 8


@contextmanager
def processes_begun(
    nominal: PatchEvaluator, base: Refit, seconds: float, jobs: int
) -> Iterator[Processes | None]:
    """Start processes that will refit models, where that is worth it; None elsewhere.

    Args:
        nominal: evaluates the patches of the nominal model.
        base: its fit: one that leaves no more than noise needs no refits.
        seconds: that it took.
        jobs: processes at most; on a GPU there is only one.
    """
    most = _job_count(nominal, jobs)
    is_worth_it = seconds > _LONG_NOMINAL_FIT and residual_size(base.groups, Part.FIT) > 0.0
    if most < 2 or not is_worth_it:
        yield None
        return
    processes = Processes(most)
    try:
        yield processes
    finally:
        processes.end()


def _job_count(nominal: PatchEvaluator, jobs: int) -> int:
    return min(jobs, _MOST) if nominal.model.device == 'cpu' else 1


class RefitPool:
    """Those who refit; a context that ends their processes.

    Attributes:
        nominal: evaluates the patches of the nominal model.
        base: its fit.
    """

    def __init__(
        self,
        nominal: PatchEvaluator,
        base: Refit,
        report: Progress = lambda _: None,
        *,
        jobs: int = 1,
        processes: Processes | None = None,
    ) -> None:
        """Begin nothing yet.

        Args:
            nominal: evaluates the patches of the nominal model.
            base: its fit.
            report: called with what is being done.
            jobs: processes at most; on a GPU there is only one.
            processes: that have begun; None: they are started where that is worth it.
        """
        self.nominal, self.base = nominal, base
        self._report = report
        self._jobs = _job_count(nominal, jobs)
        self._processes, self._spent = processes, 0.0
        # What was freed and no better so may be asked for as a rival of the best, too.
        self._done: list[tuple[Task, Refit | None]] = []
        if processes is not None:
            processes.teach(nominal, base)

    def __enter__(self) -> 'RefitPool':
        return self

    def __exit__(self, *_: object) -> None:
        if self._processes is not None:
            self._processes.end()
            self._processes = None

    def refit_all(self, requests: Sequence[RefitRequest]) -> list[Hypothesis]:
        """Refit models; return those that can be simulated, in the same order."""
        return self.finish_beside(requests, (), ())[0]

    def look(self, hypotheses: Sequence[Hypothesis]) -> list[Hypothesis | None]:
        """Evaluate models where they are said to stand; None of those that cannot be simulated."""
        tasks = [
            Continuation(h.added, h.fit.coordinates, None, -np.inf, h.freed, 1, FROM_A_FIT)
            for h in hypotheses
        ]
        return [
            None if fit is None else replace(hypothesis, fit=replace(fit, is_converged=False))
            for hypothesis, fit in zip(hypotheses, self._fits(tasks), strict=True)
        ]

    def finish(
        self,
        hypotheses: Sequence[Hypothesis],
        least: Sequence[float],
        max_iterations: int = MAX_ITERATIONS,
    ) -> list[Hypothesis]:
        """Fit models to the end; one that cannot be simulated again stays what it is.

        A state that was reached by small load steps is not always found from another one.

        Args:
            hypotheses: models.
            least: log evidence below which each is of no use.
            max_iterations: evaluations of each model at most.
        """
        return self.finish_beside((), hypotheses, least, max_iterations=max_iterations)[1]

    def finish_beside(
        self,
        requests: Sequence[RefitRequest],
        hypotheses: Sequence[Hypothesis],
        least: Sequence[float],
        max_iterations: int = MAX_ITERATIONS,
    ) -> tuple[list[Hypothesis], list[Hypothesis]]:
        """Do as `refit_all` and `finish` do, at the same time; return what both would.

        Args:
            requests: models to refit.
            hypotheses: models to fit to the end.
            least: log evidence below which each of these is of no use.
            max_iterations: evaluations of each of these at most.
        """
        tasks = [
            Continuation(
                h.added,
                h.fit.coordinates,
                h.fit.groups,
                log_evidence,
                h.freed,
                max_iterations,
                h.fit.pace,
            )
            for h, log_evidence in zip(hypotheses, least, strict=True)
        ]
        sized_requests = [
            replace(
                request, added=all_sized(request.added, {**request.starts, **request.expected})
            )
            for request in requests
        ]
        fits = self._fits([*sized_requests, *tasks])
        begun = [
            self._hypothesis(request, fit)
            for request, fit in zip(sized_requests, fits, strict=False)
            if fit is not None
        ]
        ended = [
            hypothesis if fit is None else replace(hypothesis, fit=fit)
            for hypothesis, fit in zip(hypotheses, fits[len(requests) :], strict=True)
        ]
        return begun, ended

    def _hypothesis(self, request: RefitRequest, fit: Refit) -> Hypothesis:
        added = request.added
        likely = all_sized(added, fit.values_by_name())
        scene, evaluator = with_effects(self.nominal, self.base, likely, request.freed)
        if [own.size for own in likely] != [own.size for own in added]:
            fit = weighed_anew(fit, evaluator)
        return Hypothesis(likely, scene, evaluator, fit)

    def _fits(self, tasks: Sequence[Task]) -> list[Refit | None]:
        """Return fits of tasks, those that were done before as they ended; None of failed ones."""
        done = [self._found_before(task) for task in tasks]
        new = [task for task, before in zip(tasks, done, strict=True) if before is None]
        fits = self._fits_anew(new)
        self._done += zip(new, fits, strict=True)
        found = iter(fits)
        return [next(found) if before is None else before[1] for before in done]

    def _found_before(self, task: Task) -> tuple[Task, Refit | None] | None:
        return next((done for done in self._done if task.is_same(done[0])), None)

    def _fits_anew(self, tasks: Sequence[Task]) -> list[Refit | None]:
        found: list[Refit | None] = []
        while len(found) < len(tasks):
            left = tasks[len(found) :]
            # A single one takes less time here, on all cores and from where bodies are.
            if self._processes is not None and len(tasks) > 1:
                found.extend(self._fits_in_processes(self._processes, left))
                continue
            begun = time.perf_counter()
            self._report(left[0].words)
            found.append(fit_here(left[0], self.nominal, self.base))
            seconds = time.perf_counter() - begun
            self._spent += seconds
            if self._jobs > 1 and self._spent + seconds * (len(left) - 1) > _WORTH_STARTING:
                self._processes = Processes(self._jobs)
                self._processes.teach(self.nominal, self.base)
        return found

    def _fits_in_processes(
        self, processes: Processes, tasks: Sequence[Task]
    ) -> Iterator[Refit | None]:
        """Yield fits in order; fewer where a process has died, and then there is no pool."""
        try:
            # The longest first: none is left alone at the end.
            longest = sorted(range(len(tasks)), key=lambda index: -tasks[index].max_iterations)
            pending = {index: processes.submit(tasks[index]) for index in longest}
            for index, task in enumerate(tasks):
                self._report(task.words)
                yield pending[index].result()
        except BrokenProcessPool:
            self._report('a process died (was there memory enough?): going on in one')
            self.__exit__()
            self._jobs = 1
