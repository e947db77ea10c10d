# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Write what a live fit found, as the command line does."""

from dataclasses import dataclass
import os
from pathlib import Path
import threading

from diffcal_ros.calibration.calibrate import with_details
from diffcal_ros.calibration.results.provenance import describe_fit
from diffcal_ros.calibration.results.result import save_result
from diffcal_ros.errors import InputError
from diffcal_ros.live.inputs import Snapshot
from diffcal_ros.live.tasks.background import Post
from diffcal_ros.live.tasks.fit_task import FitEnd
from diffcal_ros.scene.save import save_fitted_scene

RESULT, FITTED_SCENE, REPORT = 'result.json', 'fitted_scene.yaml', 'report.html'


@dataclass(frozen=True)
class ReportWritten:
    """The report was written, or could not be.

    Attributes:
        path: of the file.
        problem: why it was not written, or None.
    """

    path: Path
    problem: str | None = None


def save_numbers(end: FitEnd, folder: Path) -> tuple[Path, ...]:
    """Write result.json and, where there is a fit to use, the scene with fitted values.

    Raises:
        InputError: when the folder cannot be written to or the disk is full.
    """
    notes = end.result.details.get('notes', [])
    details = {
        **describe_fit(end.request.scene, end.request.settings),
        'recordings': [_described(snapshot) for snapshot in end.request.snapshots],
        'notes': notes,
    }
    written = [folder / RESULT]
    save_result(with_details(end.result, **details), folder / RESULT)
    if end.result.outcome.is_fitted:
        save_fitted_scene(end.request.scene, folder / FITTED_SCENE, end.result.values())
        written.append(folder / FITTED_SCENE)
    return tuple(written)


def check_folder(folder: Path) -> None:
    """Look whether a folder is there to be written to, or can be made.

    Raises:
        InputError: when it cannot.
    """
    there = folder
    while not there.exists() and there != there.parent:
        there = there.parent
    if not there.is_dir():
        raise InputError(f'{folder} cannot be made, {there} is no folder: choose another one')
    if not os.access(there, os.W_OK | os.X_OK):
        raise InputError(f'{folder}: nothing may be written to {there}: choose another folder')


def make_folder(folder: Path) -> None:
    """Make a folder that is written to later.

    Raises:
        InputError: when that cannot be done.
    """
    check_folder(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f'{folder} cannot be made ({error.strerror or error}): choose another folder'
        ) from error


def save_report(end: FitEnd, folder: Path, post: Post, stop: threading.Event) -> None:
    """Write the report, which takes seconds, and post `ReportWritten`."""
    path = folder / REPORT
    try:
        from diffcal_ros.report.pages.fit_page import write_report

        write_report(path, end.calibration or end.request.calibration(), end.result)
    except Exception as error:  # A report that fails must not cost the fit.
        post(ReportWritten(path, f'{path} was not written: {error}'))
        return
    post(ReportWritten(path))


def _described(snapshot: Snapshot) -> dict[str, object]:
    first, last = snapshot.frames[0], snapshot.frames[-1]
    return {
        'name': snapshot.name,
        'frames': len(snapshot.frames),
        'first_stamp_ns': first.stamp_ns,
        'last_stamp_ns': last.stamp_ns,
        'frame_id': last.frame_id,
    }
