# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Run a program, look at what it said, at the files that it left, and at who still runs."""

from dataclasses import dataclass
import json
import os
from pathlib import Path
import signal
import subprocess
import sys
import time
from typing import Any

from mcap.reader import make_reader
import yaml

# What `diffcal` may exit with; a signal that is not caught is minus its number.
CODES = (0, 2, 3, 4, 5, 74, 130)
_DIFFCAL = 'import sys; from diffcal_ros.cli.program import main; sys.exit(main())'
# Longest that an undisturbed command may take on a busy machine [s].
LIMIT = 180.0
_TICK = 0.02  # [s]


@dataclass
class Running:
    """A program and all that it starts, in a session of their own."""

    process: subprocess.Popen[bytes]
    log: Path

    @property
    def said(self) -> str:
        """What it has written so far."""
        return self.log.read_text(errors='replace')

    def kill(self, number: int = signal.SIGKILL) -> None:
        """Send the program alone a signal."""
        self.process.send_signal(number)

    def ends_within(self, seconds: float) -> bool:
        """Wait for its end."""
        try:
            self.process.wait(seconds)
        except subprocess.TimeoutExpired:
            return False
        return True

    def left_running(self, patience: float = 10.0) -> list[int]:
        """Return who of its session still runs some time after its end."""
        end = time.monotonic() + patience
        while (left := _of_session(self.process.pid)) and time.monotonic() < end:
            time.sleep(_TICK)
        return left

    def end(self) -> None:
        """Leave nothing behind."""
        for number in {self.process.pid, *_of_session(self.process.pid)}:
            try:
                os.kill(number, signal.SIGKILL)
            except ProcessLookupError:
                continue
        self.process.wait()


def start(arguments: list[str], log: Path, *, program: str = _DIFFCAL, **options: Any) -> Running:
    """Start a program of this package; its output goes to a file unless `options` say else."""
    options.setdefault('stdin', subprocess.DEVNULL)
    with log.open('wb') as stream:
        options.setdefault('stdout', stream)
        options.setdefault('stderr', stream)
        process = subprocess.Popen(
            [sys.executable, '-c', program, *arguments], start_new_session=True, **options
        )
    return Running(process, log)


def damaged_files(folder: Path) -> list[str]:
    """Name the files of a folder that are not whole; hidden ones are nobody's results."""
    found = []
    for path in sorted(folder.rglob('*')) if folder.is_dir() else []:
        hidden = any(part.startswith('.') for part in path.relative_to(folder).parts)
        if path.is_file() and not hidden and not _is_whole(path):
            found.append(str(path.relative_to(folder)))
    return found


def _is_whole(path: Path) -> bool:
    """Tell whether a file ends as its kind must, by other readers than the package's own."""
    try:
        if path.suffix == '.json':
            json.loads(path.read_text())
        elif path.suffix == '.yaml':
            return yaml.safe_load(path.read_text()) is not None
        elif path.suffix == '.html':
            return path.read_text().rstrip().endswith('</html>')
        elif path.suffix == '.mcap':
            with path.open('rb') as stream:
                return any(True for _ in make_reader(stream, validate_crcs=True).iter_messages())
        return path.stat().st_size > 0
    except Exception:  # However its reader says so: it is not whole.
        return False


def _of_session(number: int) -> list[int]:
    """List the processes of a session that run; one that nobody waited for does not."""
    found = []
    for entry in Path('/proc').iterdir():
        if not entry.name.isdigit():
            continue
        try:
            fields = (entry / 'stat').read_text().rpartition(')')[2].split()
        except OSError:
            continue
        state, session = fields[0], int(fields[3])
        if session == number and state not in 'ZX':
            found.append(int(entry.name))
    return found
