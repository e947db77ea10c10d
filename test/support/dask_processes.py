# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A real Dask scheduler and its workers, each a process of its own, on the loopback."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
import os
from pathlib import Path
import re
import subprocess
import sys
import time

# What a busy machine may take to start a process [s].
_PATIENCE = 120.0
_PLAIN = ('--no-dashboard',)


@dataclass
class DaskProcesses:
    """Where the scheduler listens, and who works."""

    address: str
    workers: list[subprocess.Popen]


@contextmanager
def dask_processes(folder: Path, workers: int) -> Iterator[DaskProcesses]:
    """Start them, and end them."""
    started: list[subprocess.Popen] = []
    try:
        log = folder / 'scheduler.log'
        scheduler = ('dask_scheduler', '--host', '127.0.0.1', '--port', '0', *_PLAIN)
        started.append(_start(scheduler, log))
        address = _wait_for(log, r'Scheduler at:\s+(tcp://[\d.]+:\d+)')
        own = ('dask_worker', address, '--nthreads', '1', '--no-nanny', *_PLAIN)
        logs = [folder / f'worker_{number}.log' for number in range(workers)]
        started += [_start(own, one) for one in logs]
        for one in logs:
            _wait_for(one, r'Registered to:\s+(tcp)')
        yield DaskProcesses(address, started[1:])
    finally:
        for process in started:
            process.kill()
            process.wait()


def _start(words: tuple[str, ...], log: Path) -> subprocess.Popen:
    module, *rest = words
    # A worker must find the tasks of the tests, and this checkout.
    paths = [os.getcwd(), str(Path(__file__).parents[1]), os.environ.get('PYTHONPATH', '')]
    environment = {**os.environ, 'PYTHONPATH': os.pathsep.join(filter(None, paths))}
    with log.open('w') as file:
        return subprocess.Popen(
            [sys.executable, '-m', f'distributed.cli.{module}', *rest],
            stdout=file,
            stderr=subprocess.STDOUT,
            env=environment,
            cwd=log.parent,
        )


def _wait_for(log: Path, pattern: str) -> str:
    begun = time.monotonic()
    while (found := re.search(pattern, log.read_text())) is None:
        assert time.monotonic() - begun < _PATIENCE, log.read_text()
        time.sleep(0.1)
    return found[1]
