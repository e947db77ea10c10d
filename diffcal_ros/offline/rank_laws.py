# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Rank energy laws from recordings and write what each of them gave."""

from collections.abc import Callable
import json
from pathlib import Path

from diffcal_ros.atomic_file import write_text_atomically
from diffcal_ros.calibration.calibrate import with_details
from diffcal_ros.calibration.law_ranking import LawFit, rank_laws
from diffcal_ros.calibration.results.result import save_result
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.offline.calibrate_recordings import describe_inputs, OfflineInputs

RANKING_FILE = 'laws.json'


def run_law_ranking(
    inputs: OfflineInputs,
    settings: CalibrationSettings,
    out: Path,
    *,
    report: Callable[[str], None] = lambda _: None,
) -> tuple[LawFit, ...]:
    """Rank all laws; write `out`/laws.json, and `out`/<law>/result.json for each that fits.

    Args:
        inputs: see `open_inputs`.
        settings: how to fit.
        out: folder of results.
        report: called with what is being done.

    Raises:
        InputError: when something given is wrong, or `out` cannot be written.
    """
    ranking = rank_laws(inputs.scene, inputs.observations, settings, report=report)
    details = describe_inputs(inputs, settings)
    for fit in ranking:
        if fit.result is not None and fit.calibration is not None:
            scene = {**dict(details['scene']), 'law': fit.law}  # type: ignore[call-overload]
            result = with_details(fit.result, **{**details, 'scene': scene})
            save_result(result, out / fit.law / 'result.json')
    document = {'format': 1, 'ranked': [_entry(fit) for fit in ranking]}
    write_text_atomically(out / RANKING_FILE, json.dumps(document, indent=2) + '\n')
    return ranking


def _entry(fit: LawFit) -> dict[str, object]:
    if fit.result is None or fit.held_out is None:
        return {'law': fit.law, 'failure': fit.failure}
    return {
        'law': fit.law,
        'outcome': fit.result.outcome.value,
        'parameters': fit.result.values(),
        'gap': fit.result.gap_end.as_dict(),
        'held_out_gap': fit.held_out.as_dict(),
    }
