# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Tasks done by the workers of a Dask scheduler."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import Any, TypeVar
from uuid import uuid4

from diffcal_ros.errors import InputError
from diffcal_ros.workers.ended import Ended

Task = TypeVar('Task')
Result = TypeVar('Result')

# How long a scheduler may take to answer [s].
_PATIENCE = 10.0


class DaskCluster:
    """The workers of a scheduler, which sees to it that the tasks of a dead one are done again.

    Attributes:
        address: of the scheduler, such as `tcp://head:8786`.
    """

    def __init__(
        self,
        address: str,
        tell: Callable[[str], None] = lambda _: None,
        *,
        patience: float = _PATIENCE,
    ) -> None:
        """Connect to nobody yet.

        Args:
            address: of the scheduler.
            tell: told what a person should know.
            patience: how long the scheduler may take to answer [s].
        """
        self.address = address
        self._tell, self._patience = tell, patience

    def run(
        self, work: Callable[[Task], Result], tasks: Sequence[Task]
    ) -> Iterator[Ended[Task, Result]]:
        """Do tasks; see `Workers.run`."""
        from distributed import as_completed

        with self._client() as client:
            workers = client.scheduler_info()['workers'].values()
            if not workers:
                self._tell(f'{self.address} has no workers yet: waiting for the first one')
            if any(worker['nthreads'] > 1 for worker in workers):
                self._tell(
                    'note: workers with several threads still do one task at a time: start them '
                    'with --nthreads 1, and several on a machine'
                )
            run = uuid4().hex[:8]
            # One that is sent again under the same name would be taken for done.
            futures = {
                client.submit(work, task, key=f'diffcal-{run}-{number}', pure=False): task
                for number, task in enumerate(tasks)
            }
            try:
                for future in as_completed(futures, loop=client.loop):
                    yield _ended(futures[future], future)
                    future.release()
            except BaseException:
                with suppress(Exception):
                    client.cancel(list(futures))
                raise

    @contextmanager
    def _client(self) -> Iterator[Any]:
        try:
            from distributed import Client
        except ImportError as error:
            raise InputError(
                "a cluster needs Dask: pip install 'diffcal_ros[cluster]', or leave --cluster out"
            ) from error
        try:
            client = Client(self.address, timeout=self._patience, set_as_default=False)
        except (OSError, ValueError) as error:
            raise InputError(
                f'no Dask scheduler answers at {self.address!r} ({error}): give the address that '
                '`dask scheduler` prints, such as tcp://head:8786'
            ) from error
        try:
            yield client
        finally:
            client.close()


def _ended(task: Task, future: Any) -> Ended[Task, Any]:
    from distributed import CancelledError, KilledWorker

    try:
        return Ended(task, future.result())
    except KilledWorker as error:
        count = error.allowed_failures + 1
        words = f'its process died {count} times (is there memory enough?)'
    except CancelledError:
        words = 'the scheduler gave it up: see whether it still runs, and run this again'
    except Exception as error:  # One that fails must not end the others.
        words = f'{type(error).__name__}: {error}'
    return Ended(task, None, words)
