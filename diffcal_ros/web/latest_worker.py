# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""One thread that works for a page: of each kind of task it does the latest only."""

from collections.abc import Callable
import threading


class LatestWorker:
    """Does tasks one after the other; a newer one replaces one of its kind that still waits."""

    def __init__(self, on_error: Callable[[Exception], None]) -> None:
        """Start the thread.

        Args:
            on_error: told of what a task raised; the thread goes on.
        """
        self._on_error = on_error
        self._tasks: dict[str, Callable[[], None]] = {}
        self._changed = threading.Condition()
        self._is_busy = self._is_ended = False
        threading.Thread(target=self._run, name='diffcal page', daemon=True).start()

    def ask(self, kind: str, task: Callable[[], None]) -> None:
        """Have a task done, in place of a waiting one of its kind."""
        with self._changed:
            self._tasks[kind] = task
            self._changed.notify_all()

    def is_outdated(self, kind: str) -> bool:
        """Tell whether a newer task of a kind waits, or the page is closed."""
        with self._changed:
            return kind in self._tasks or self._is_ended

    def wait(self, seconds: float) -> bool:
        """Wait until nothing is left to do; tell whether that came about."""
        with self._changed:
            return self._changed.wait_for(
                lambda: not self._tasks and not self._is_busy, timeout=seconds
            )

    def end(self) -> None:
        """Let the thread end after what it is doing."""
        with self._changed:
            self._is_ended = True
            self._tasks.clear()
            self._changed.notify_all()

    def _run(self) -> None:
        while True:
            with self._changed:
                self._is_busy = False
                self._changed.notify_all()
                self._changed.wait_for(lambda: self._tasks or self._is_ended)
                if self._is_ended:
                    return
                task = self._tasks.pop(next(iter(self._tasks)))
                self._is_busy = True
            try:
                task()
            except Exception as error:
                self._on_error(error)
