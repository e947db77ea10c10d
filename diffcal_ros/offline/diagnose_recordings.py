# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Diagnose from recordings and write the verdict."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from diffcal_ros import __version__
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.diagnosis.diagnose import diagnose, DiagnosisTrace
from diffcal_ros.diagnosis.settings import DiagnosisSettings
from diffcal_ros.diagnosis.verdict.acceptance import VERDICT_FILE
from diffcal_ros.diagnosis.verdict.verdict import save_verdict
from diffcal_ros.offline.calibrate_recordings import describe_inputs, OfflineInputs


def run_diagnosis(
    inputs: OfflineInputs,
    settings: DiagnosisSettings,
    out: Path,
    *,
    report: Callable[[str], None] = lambda _: None,
) -> DiagnosisTrace:
    """Diagnose, and write `out`/verdict.json.

    Args:
        inputs: see `open_inputs`.
        settings: choices.
        out: folder of results.
        report: called with what is being done.

    Raises:
        InputError: when something given is wrong, or `out` cannot be written.
    """
    trace = diagnose(inputs.scene, inputs.observations, settings, report=report)
    damage = tuple(note for one in inputs.recordings for note in one.messages.notes)
    notes = (*trace.diagnosis.notes, *damage)
    trace = replace(trace, diagnosis=replace(trace.diagnosis, notes=notes))
    described = describe_inputs(inputs, CalibrationSettings(fit=settings.fit))
    trace = trace.described(
        version=__version__,
        recordings=described['recordings'],
        margin_mm=1e3 * settings.margin,
        without=list(settings.without),
    )
    save_verdict(trace.diagnosis, out / VERDICT_FILE)
    return trace
