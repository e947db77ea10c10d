# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Calibrate a modulus that varies over the body from recordings, and write what was found."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from diffcal_ros.calibration.calibrate import Calibration, with_details
from diffcal_ros.calibration.field.fit import check_field, FieldFit, fit_field
from diffcal_ros.calibration.field.layout import FieldKind
from diffcal_ros.calibration.results.outcome import Outcome
from diffcal_ros.calibration.results.result import CalibrationResult, IterationRecord, save_result
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.offline.calibrate_recordings import (
    describe_inputs,
    OfflineInputs,
    run_calibration,
)


def run_field_calibration(
    inputs: OfflineInputs,
    settings: CalibrationSettings,
    out: Path,
    kind: FieldKind | None = None,
    *,
    fraction: float | None = None,
    on_iteration: Callable[[IterationRecord], bool] = lambda _: True,
    report: Callable[[str], None] = lambda _: None,
) -> tuple[Calibration, FieldFit]:
    """Fit without a field and then with one, and keep `out`/result.json complete after every step.

    Args:
        inputs: see `open_inputs`.
        settings: how to fit.
        out: folder of results.
        kind: what the field is made of; default: one modulus a tetrahedron.
        fraction: weight of the field's roughness; None: found automatically.
        on_iteration: told of every step and of every weight; returns False to stop.
        report: called with what is being done.

    Raises:
        InputError: when something given is wrong, `out` cannot be written, or the fit without a
            field leads nowhere.
    """
    check_field(inputs.scene, kind or FieldKind(), fraction)
    calibration, uniform = run_calibration(inputs, settings, out, on_iteration=on_iteration)
    report('fitting the field')
    details = describe_inputs(inputs, settings)

    def keep(record: IterationRecord) -> bool:
        history = (*uniform.history, record)
        unfinished: CalibrationResult = replace(
            calibration.unfinished(history), outcome=Outcome.INTERRUPTED
        )
        save_result(with_details(unfinished, **details), out / 'result.json')
        return on_iteration(record)

    field = fit_field(calibration, uniform, kind, fraction=fraction, on_iteration=keep)
    result = with_details(field.result, **details, field=field.as_dict())
    save_result(result, out / 'result.json')
    return calibration, replace(field, result=result)
