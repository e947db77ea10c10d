# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How a task ended, and who does tasks."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

Task = TypeVar('Task')
Result = TypeVar('Result')

# A task whose process died so often is not tried again in this run.
MOST_DEATHS = 3


@dataclass(frozen=True)
class Ended(Generic[Task, Result]):
    """A task that is over.

    Attributes:
        task: as it was given.
        result: what the work returned; None where it could not be done.
        fault: why there is no result; empty where there is one.
    """

    task: Task
    result: Result | None
    fault: str = ''


class Workers(Protocol):
    """Who does tasks."""

    def run(
        self, work: Callable[[Task], Result], tasks: Sequence[Task]
    ) -> Iterator[Ended[Task, Result]]:
        """Do tasks side by side; yield each when it is over, in whatever order.

        A task whose process dies is done again, and so may be begun more than once.

        Args:
            work: a function that other processes can import; what it raises is a fault.
            tasks: what can be sent to other processes.

        Raises:
            InputError: when nobody can work at all.
        """
