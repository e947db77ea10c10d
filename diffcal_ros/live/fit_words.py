# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How a fit ended, in a sentence for the log and for /diagnostics."""

from diffcal_ros.calibration.results.outcome import Outcome
from diffcal_ros.calibration.results.result import CalibrationResult
from diffcal_ros.live.health import Level
from diffcal_ros.report.naming import shown, title


def fit_level(outcome: Outcome) -> Level:
    """Return how bad an outcome is: an error leaves no numbers to use."""
    if outcome.is_usable:
        return Level.OK
    return Level.WARN if outcome.is_fitted else Level.ERROR


def outcome_words(outcome: Outcome) -> str:
    """Name an outcome and its remedy."""
    return f'{outcome.value.replace("_", " ")}: {outcome.remedy}'


def result_words(result: CalibrationResult) -> str:
    """Say what a fit found: outcome, parameters with their errors, and what is left."""
    found = ', '.join(
        f'{title(p.name)} {shown(p.value, p.std_error, p.unit).text()}'
        for p in result.parameters
        if not p.is_nuisance
    )
    gap = result.gap_end
    return (
        f'{result.outcome.value.replace("_", " ")} after {result.iterations} steps in '
        f'{result.seconds:.1f} s: {found}; median gap {1e3 * gap.median:.3g} mm, coverage '
        f'{100.0 * gap.coverage:.1f} %'
    )
