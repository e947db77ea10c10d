# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""One body's command, done once, its results in a folder that is whole or not there."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from dataclasses import asdict, dataclass
from datetime import datetime, timezone
import json
import os
from pathlib import Path
import platform
import shutil
from threading import Lock
import time
from typing import Any

from diffcal_ros.atomic_file import write_text_atomically
from diffcal_ros.calibration.results.outcome import (
    EXIT_AMBIGUOUS,
    EXIT_MODEL_DISAGREES,
    EXIT_NOT_FITTED,
)
from diffcal_ros.errors import InputError
from diffcal_ros.leftovers import fresh_path, remove_leftovers

MARK, LOG = 'job.json', 'log.txt'
_LOCKS = '.locks'
# What a command exits with that has done what it could.
DONE_CODES = (0, EXIT_NOT_FITTED, EXIT_MODEL_DISAGREES, EXIT_AMBIGUOUS)
# Standard output and the exit code's meaning belong to one command a process.
_ONE_AT_A_TIME = Lock()


@dataclass(frozen=True)
class Job:
    """A body's command and where its results go.

    Attributes:
        name: of the body.
        arguments: after `diffcal`, without `--out` and the folder.
        folder: of the results, the last of its path the body's name.
        fingerprint: of all that the results rest on.
    """

    name: str
    arguments: tuple[str, ...]
    folder: Path
    fingerprint: str


@dataclass(frozen=True)
class Account:
    """What became of a job.

    Attributes:
        name: of the body.
        exit_code: of the command.
        seconds: that it took.
        processor_seconds: of this process in that time.
        process: who did it, machine and number.
        begun: when, UTC.
        arguments: of the command, without `--out`.
        fingerprint: see `Job`.
        words: the last line that a command which could not be done has said.
    """

    name: str
    exit_code: int
    seconds: float
    processor_seconds: float
    process: str
    begun: str
    arguments: tuple[str, ...]
    fingerprint: str
    words: str = ''

    @property
    def is_done(self) -> bool:
        """Tell whether there is a result, whatever it says."""
        return self.exit_code in DONE_CODES


def read_account(job: Job) -> Account | None:
    """Return what became of a job; None where nothing has, or where it was another one."""
    try:
        content: Any = json.loads((job.folder / MARK).read_text(encoding='utf-8'))
        account = Account(**{**content, 'arguments': tuple(content['arguments'])})
    except (OSError, ValueError, KeyError, TypeError):
        return None
    return account if account.fingerprint == job.fingerprint else None


def do_job(job: Job, run: Callable[[Sequence[str]], int]) -> Account:
    """Do a job that is not done yet, and say what became of it.

    Several processes may be given the same one: the first does it, the others wait and find it
    done. The results are written elsewhere and moved to the folder at once, its mark in them.

    Args:
        job: what to do.
        run: runs the command with its arguments, and returns its exit code.

    Raises:
        InputError: when its folder cannot be written.
    """
    with _ONE_AT_A_TIME, _held(job.folder):
        account = read_account(job)
        if account is not None and account.is_done:
            return account
        remove_leftovers(job.folder)
        fresh = fresh_path(job.folder)
        try:
            account = _run_into(fresh, job, run)
            write_text_atomically(fresh / MARK, json.dumps(asdict(account), indent=2) + '\n')
            _put_in_place(fresh, job.folder)
        except OSError as error:
            raise InputError(
                f'{job.folder} cannot be written ({error.strerror or error}): see that it may be '
                'written to and that the disk has room'
            ) from error
        finally:
            shutil.rmtree(fresh, ignore_errors=True)
        return account


def _run_into(fresh: Path, job: Job, run: Callable[[Sequence[str]], int]) -> Account:
    fresh.mkdir(parents=True)
    begun, now = datetime.now(timezone.utc), time.perf_counter()
    processor = time.process_time()
    with (
        (fresh / LOG).open('w', encoding='utf-8', errors='backslashreplace') as log,
        redirect_stdout(log),
        redirect_stderr(log),
    ):
        code = run([*job.arguments, '--out', str(fresh)])
    seconds, processor = time.perf_counter() - now, time.process_time() - processor
    # Whoever reads it finds the files where they are moved to.
    said = (fresh / LOG).read_text(encoding='utf-8').replace(str(fresh), str(job.folder))
    write_text_atomically(fresh / LOG, said)
    return Account(
        name=job.name,
        exit_code=code,
        seconds=seconds,
        processor_seconds=processor,
        process=f'{platform.node()} {os.getpid()}',
        begun=begun.isoformat(timespec='milliseconds'),
        arguments=job.arguments,
        fingerprint=job.fingerprint,
        words='' if code in DONE_CODES else said.strip().rpartition('\n')[2],
    )


def _put_in_place(fresh: Path, folder: Path) -> None:
    """Move a folder to its place; what was there before gives way."""
    if folder.exists():
        old = fresh_path(folder)
        folder.rename(old)
        fresh.rename(folder)
        shutil.rmtree(old, ignore_errors=True)
    else:
        fresh.rename(folder)


@contextmanager
def _held(folder: Path) -> Iterator[None]:
    """Keep other processes from a folder for a while; the system lets go of it when this ends."""
    try:
        import fcntl
    except ImportError:  # Elsewhere two processes with one job would both do it, to one end.
        yield
        return
    path = folder.parent / _LOCKS / folder.name
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open('w') as lock:
        with suppress(OSError):  # Some disks of networks know no locks.
            fcntl.flock(lock, fcntl.LOCK_EX)
        yield
