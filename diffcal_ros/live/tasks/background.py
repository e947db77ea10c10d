# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""One thread for long work; what it finds comes back through a mailbox."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
import threading
from typing import Any

Post = Callable[[Any], None]
Task = Callable[[Post, threading.Event], None]


@dataclass(frozen=True)
class TaskFailed:
    """A task ended with an error.

    Attributes:
        error: what it raised.
    """

    error: Exception


class Background:
    """Runs tasks one after the other in a thread of its own.

    A task gets a function that posts an event, and an event that is set when it should stop.
    What it raises is posted as `TaskFailed`. Of a task that was told to stop nothing comes back.
    """

    def __init__(self, wake: Callable[[], None]) -> None:
        """Start the thread.

        Args:
            wake: called from the thread after every event posted.
        """
        self._wake = wake
        self._tasks: deque[tuple[Task, threading.Event]] = deque()
        self._events: deque[tuple[Any, threading.Event]] = deque()
        self._changed = threading.Condition()
        self._current: threading.Event | None = None
        self._is_closed = False
        # A compiler that runs cannot be stopped: it must not keep the process alive.
        self._thread = threading.Thread(target=self._work, name='background', daemon=True)
        self._thread.start()

    def submit(self, task: Task) -> threading.Event:
        """Run a task after those that wait; return the event that stops it."""
        stop = threading.Event()
        with self._changed:
            self._tasks.append((task, stop))
            self._changed.notify()
        return stop

    def events(self) -> list[Any]:
        """Take the events posted so far."""
        with self._changed:
            taken = list(self._events)
            self._events.clear()
        return [event for event, stop in taken if not stop.is_set()]

    def close(self, patience: float = 2.0) -> bool:
        """End the thread.

        Args:
            patience: how long to wait for it [s].

        Returns:
            False when it is still at work, in code that cannot be interrupted.
        """
        with self._changed:
            self._is_closed = True
            self._tasks.clear()
            if self._current is not None:
                self._current.set()
            self._changed.notify()
        self._thread.join(patience)
        return not self._thread.is_alive()

    def _work(self) -> None:
        while True:
            with self._changed:
                self._current = None
                while not self._tasks and not self._is_closed:
                    self._changed.wait()
                if self._is_closed:
                    return
                task, stop = self._tasks.popleft()
                self._current = stop
            if not stop.is_set():
                self._run(task, stop)

    def _run(self, task: Task, stop: threading.Event) -> None:
        def post(event: Any) -> None:
            with self._changed:
                if self._is_closed:
                    return
                self._events.append((event, stop))
            self._wake()

        try:
            task(post, stop)
        except Exception as error:  # Whatever it is, the thread must live on and tell.
            post(TaskFailed(error))
