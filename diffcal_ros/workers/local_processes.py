# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Tasks in processes of this machine, which joblib starts and joblib starts again."""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
import os
from pathlib import Path
import signal
import tempfile
import threading
import time
from typing import TypeVar

from diffcal_ros.errors import InputError
from diffcal_ros.workers.ended import Ended, MOST_DEATHS

Task = TypeVar('Task')
Result = TypeVar('Result')

# How often a process looks whether the first one is still there [s].
_LOOK = 0.5
_is_watching = threading.Event()


class LocalProcesses:
    """Processes that end with this one; where one dies, the others' tasks go on."""

    def __init__(self, jobs: int, threads: int) -> None:
        """Begin nothing yet.

        Args:
            jobs: processes.
            threads: that each may use.
        """
        self._jobs, self._threads = jobs, threads

    def run(
        self, work: Callable[[Task], Result], tasks: Sequence[Task]
    ) -> Iterator[Ended[Task, Result]]:
        """Do tasks; see `Workers.run`."""
        left, deaths = dict(enumerate(tasks)), Counter[int]()
        vain = 0
        with tempfile.TemporaryDirectory(prefix='diffcal-') as marks:
            while left:
                # A task that fells processes is kept for the end, and falls alone.
                numbers = [n for n in left if deaths[n] < MOST_DEATHS - 1]
                jobs = self._jobs if numbers else 1
                has_worked = False
                try:
                    some = self._some(work, left, numbers or [*left], jobs, marks)
                    for number, fault, result in some:
                        has_worked = True
                        yield Ended(left.pop(number), result, fault)
                    continue
                except BrokenProcessPool:
                    fell = [int(path.name) for path in Path(marks).iterdir()]
                for number in fell:
                    (Path(marks) / str(number)).unlink()
                    deaths[number] += number in left
                    if deaths[number] >= MOST_DEATHS and number in left:
                        yield Ended(left.pop(number), None, _death_words(deaths[number]))
                vain = 0 if has_worked or fell else vain + 1
                if vain == MOST_DEATHS:
                    raise InputError(
                        'processes die before they begin (is there memory enough?): give --jobs 1'
                    )

    def _some(
        self,
        work: Callable[[Task], Result],
        tasks: dict[int, Task],
        numbers: Sequence[int],
        jobs: int,
        marks: str,
    ) -> Iterator[tuple[int, str, Result | None]]:
        import joblib

        # joblib does the tasks of a single process in this one, which must not die: it is given
        # two, of which one never gets a task.
        processes = max(min(jobs, len(numbers)), 2)
        begun = 1 if jobs == 1 else 2 * processes
        threads = {'inner_max_num_threads': self._threads}
        with _deaf_to_interrupts(), joblib.parallel_config('loky', n_jobs=processes, **threads):
            parallel = joblib.Parallel(
                return_as='generator_unordered', batch_size=1, pre_dispatch=begun
            )
            yield from parallel(
                joblib.delayed(_do)(work, tasks[number], number, marks, os.getpid())
                for number in numbers
            )


def _do(
    work: Callable[[Task], Result], task: Task, number: int, marks: str, first: int
) -> tuple[int, str, Result | None]:
    """Do a task in another process; what it leaves in `marks` when it dies tells that it did."""
    if not _is_watching.is_set():
        _is_watching.set()
        threading.Thread(target=_end_with, args=(first,), daemon=True).start()
    mark = Path(marks) / str(number)
    mark.touch()
    try:
        return number, '', work(task)
    except Exception as error:
        return number, f'{type(error).__name__}: {error}', None
    finally:
        mark.unlink(missing_ok=True)


def _end_with(first: int) -> None:
    """Wait for the first process; who is killed ends nobody."""
    while os.getppid() == first:
        time.sleep(_LOOK)
    os._exit(1)


@contextmanager
def _deaf_to_interrupts() -> Iterator[None]:
    """Let processes that this thread starts hear no SIGINT.

    Who interrupts the first process from a terminal interrupts all of them: it is the first one
    that says so, and ends the others.
    """
    if not hasattr(signal, 'pthread_sigmask'):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _death_words(count: int) -> str:
    return f'its process died {count} times (is there memory enough?)'
