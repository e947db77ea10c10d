# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which processes there are, on Linux."""

from collections.abc import Iterable
from pathlib import Path
import time

# What a busy machine may take to end a process [s].
_PATIENCE = 30.0


def children_of(process: int) -> list[int]:
    """List what a process has started and that still runs."""
    numbers = [int(path.name) for path in Path('/proc').iterdir() if path.name.isdigit()]
    return [number for number in numbers if _state(number)[1:] == (process,)]


def wait_until_gone(processes: Iterable[int]) -> None:
    """Wait for processes to end, and fail where they do not."""
    begun = time.monotonic()
    left = list(processes)
    while left:
        assert time.monotonic() - begun < _PATIENCE, f'{left} still run'
        time.sleep(0.05)
        left = [number for number in left if _state(number)]


def _state(process: int) -> tuple[str, int] | tuple[()]:
    """Return the state and the parent of a process that has not ended."""
    try:
        text = Path(f'/proc/{process}/stat').read_text()
    except OSError:
        return ()
    state, parent = text.rpartition(')')[2].split()[:2]
    return () if state == 'Z' else (state, int(parent))
