# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""One diagnosis in the background, of what the last fit saw."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
import threading

from diffcal_ros.diagnosis.diagnose import diagnose
from diffcal_ros.diagnosis.settings import DiagnosisSettings
from diffcal_ros.diagnosis.verdict.acceptance import VERDICT_FILE
from diffcal_ros.diagnosis.verdict.verdict import Diagnosis, save_verdict
from diffcal_ros.errors import InputError
from diffcal_ros.live.inputs import Snapshot
from diffcal_ros.live.tasks.background import Post
from diffcal_ros.scene.model import Scene

PAGE = 'diagnosis.html'


@dataclass(frozen=True)
class DiagnosisStep:
    """What a diagnosis is at.

    Attributes:
        words: for a person.
    """

    words: str


@dataclass(frozen=True)
class DiagnosisEnd:
    """A diagnosis that came to its end.

    Attributes:
        diagnosis: the verdict; None when it broke off.
        folder: where it was written.
        stamp_ns: of the newest frame used [ns].
        frame_id: of that frame.
        problem: why it broke off, or None.
    """

    diagnosis: Diagnosis | None
    folder: Path
    stamp_ns: int
    frame_id: str
    problem: str | None = None


class _StoppedError(Exception):
    """The diagnosis was given up."""


def run_diagnosis(
    scene: Scene,
    snapshots: Sequence[Snapshot],
    fit: tuple[str, ...] | None,
    folder: Path,
    post: Post,
    stop: threading.Event,
) -> None:
    """Diagnose, write verdict.json and the page, and post a `DiagnosisEnd`."""
    newest = snapshots[-1].newest

    def report(words: str) -> None:
        if stop.is_set():
            raise _StoppedError
        post(DiagnosisStep(words))

    try:
        observations = [seen for snapshot in snapshots for seen in snapshot.observe(scene)]
        trace = diagnose(scene, observations, DiagnosisSettings(fit=fit), report=report).described(
            recordings=[
                {'name': s.name, 'frames': str(len(s.frames)), 'newest_ns': str(s.newest.stamp_ns)}
                for s in snapshots
            ]
        )
        save_verdict(trace.diagnosis, folder / VERDICT_FILE)
        from diffcal_ros.report.pages.diagnosis_page import write_diagnosis_page

        write_diagnosis_page(folder / PAGE, scene.name, trace)
    except _StoppedError:
        return
    except InputError as error:
        post(DiagnosisEnd(None, folder, newest.stamp_ns, newest.frame_id, str(error)))
        return
    post(DiagnosisEnd(trace.diagnosis, folder, newest.stamp_ns, newest.frame_id))
