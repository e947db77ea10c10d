# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a fit found where it ended: the same for one body, several, and a field."""

from collections.abc import Sequence

from diffcal_ros.calibration.parameters.parameters import ParameterSet
from diffcal_ros.calibration.residuals.gap import Gap
from diffcal_ros.calibration.results.fitted_parameters import fitted_parameters
from diffcal_ros.calibration.results.outcome_rules import judge, warn
from diffcal_ros.calibration.results.result import CalibrationResult, IterationRecord
from diffcal_ros.calibration.uncertainty.prior_chance import placement_chance
from diffcal_ros.calibration.uncertainty.uncertainty import Uncertainty
from diffcal_ros.least_squares.levenberg_marquardt import Minimum


def result_at(
    minimum: Minimum,
    parameters: ParameterSet,
    uncertainty: Uncertainty,
    gaps: tuple[Gap, Gap],
    history: Sequence[IterationRecord],
    *,
    loss: str,
    seconds: float,
    is_ambiguous: bool = False,
) -> CalibrationResult:
    """Return values, errors, outcome and warnings at the end of a fit.

    Args:
        minimum: where the optimiser stopped.
        parameters: of the fit.
        uncertainty: of them there.
        gaps: at the start and at the end.
        history: states after the accepted steps.
        loss: name of it.
        seconds: that the fit took.
        is_ambiguous: another minimum explains the data about as well.
    """
    gap_start, gap = gaps
    fitted = fitted_parameters(parameters, minimum.coordinates, uncertainty)
    placement = placement_chance(parameters, minimum.coordinates)
    return CalibrationResult(
        outcome=judge(
            minimum, gap, fitted, uncertainty, is_ambiguous=is_ambiguous, placement=placement
        ),
        parameters=fitted,
        gap_start=gap_start,
        gap_end=gap,
        loss=loss,
        history=tuple(history),
        correlation=uncertainty.correlation,
        warnings=tuple(warn(gap, fitted, uncertainty, placement=placement)),
        seconds=seconds,
    )
