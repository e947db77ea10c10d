# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Do a batch: what is done already is left as it is."""

from collections.abc import Callable, Sequence
import os
from pathlib import Path

from diffcal_ros.batch.body_result import BodyResult, read_result
from diffcal_ros.batch.fingerprint import Fingerprints
from diffcal_ros.batch.job import Account, Job, read_account
from diffcal_ros.batch.manifest import Body
from diffcal_ros.errors import InputError
from diffcal_ros.workers.ended import Workers

FOLDER = 'bodies'
# Told how many are over, how many there are, and the one that is over now.
OnEnded = Callable[[int, int, BodyResult], None]


def plan(bodies: Sequence[Body], out: Path) -> list[Job]:
    """Return one job a body.

    Raises:
        InputError: when a scene is no YAML, or a folder of results cannot be made.
    """
    fingerprints = Fingerprints()
    folder = Path(os.path.abspath(out)) / FOLDER
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f'{folder} cannot be made ({error.strerror or error}): give another folder with --out'
        ) from error
    return [
        Job(
            name=body.name,
            arguments=tuple(body.arguments()),
            folder=folder / body.name,
            fingerprint=fingerprints.of(body),
        )
        for body in bodies
    ]


def run_batch(
    bodies: Sequence[Body],
    jobs: Sequence[Job],
    work: Callable[[Job], Account],
    workers: Workers,
    on_ended: OnEnded = lambda *_: None,
) -> list[BodyResult]:
    """Do the jobs that are not done, and read the results of all.

    Args:
        bodies: of the manifest.
        jobs: see `plan`, in the same order.
        work: does one, in another process.
        workers: who do them.
        on_ended: told of every job that is over.

    Raises:
        InputError: when nobody can work.
    """
    results: dict[str, BodyResult] = {}
    owners = {job.name: (body, job) for body, job in zip(bodies, jobs, strict=True)}
    left = []
    for body, job in owners.values():
        account = read_account(job)
        if account is not None and account.is_done:
            results[job.name] = read_result(body, job, account)
        else:
            left.append(job)
    for ended in workers.run(work, left) if left else ():
        body, job = owners[ended.task.name]
        fault = ended.fault
        if ended.result is not None and read_account(job) is None:
            fault = (
                f'{ended.result.process} has done it, and {job.folder} is not there: give --out '
                'on a disk that all workers share'
            )
        results[job.name] = read_result(body, job, ended.result, fault)
        on_ended(len(results), len(jobs), results[job.name])
    return [results[job.name] for job in jobs]
