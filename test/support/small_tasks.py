# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Tasks for processes of any kind; some of them do not end well."""

import os
from pathlib import Path
import signal


def number(task: int) -> tuple[int, int]:
    """Return a number, and who says it."""
    return task, os.getpid()


def fail_at_three(task: int) -> int:
    """Raise where the number is three."""
    if task == 3:
        raise ValueError('three is too many')
    return task


def fall_once(task: tuple[int, str]) -> int:
    """Fell the process of number two once; a file says whether that has been."""
    place, file = task
    if place == 2 and not Path(file).exists():
        Path(file).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return place


def always_fall(task: int) -> int:
    """Fell the process of number two every time."""
    if task == 2:
        os.kill(os.getpid(), signal.SIGKILL)
    return task
