# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whether a nominal fit disagrees with what is seen, and what scores best beside it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from diffcal_ros.diagnosis.detection.disagreement import Disagreement, measure_disagreement
from diffcal_ros.diagnosis.detection.local_outlier import find_local_outlier, LocalOutlier
from diffcal_ros.diagnosis.nominal_fit import fit_patches, with_smooth_error
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.screening.candidates import Candidate, candidates
from diffcal_ros.diagnosis.screening.screening import Screen, screen
from diffcal_ros.diagnosis.settings import DiagnosisSettings

Progress = Callable[[str], None]

# Places that are left out at most.
_MOST_OUTLIERS = 2


@dataclass(frozen=True)
class Examined:
    """A nominal fit, held against what is seen.

    Attributes:
        evaluator: of the nominal model.
        nominal: its fit.
        scores: of all candidates beside it.
        disagreement: whether there is one.
        outliers: what was left out as not the body's.
    """

    evaluator: PatchEvaluator
    nominal: Refit
    scores: Screen
    disagreement: Disagreement
    outliers: tuple[LocalOutlier, ...] = ()


def examined(
    evaluator: PatchEvaluator, nominal: Refit, settings: DiagnosisSettings, report: Progress
) -> Examined:
    """Score all candidates beside a nominal fit, with the smooth error that the sensor shows.

    Args:
        evaluator: of the nominal model, with a sensor as it is expected beforehand.
        nominal: its fit.
        settings: of the diagnosis.
        report: called with what is being done.
    """
    listed = candidates(evaluator.model.scene, settings.without, settings.fit)
    report(f'screening {len(listed)} candidates')
    evaluator, nominal = with_smooth_error(evaluator, nominal)
    judged = _judge(evaluator, nominal, listed, settings.margin)
    return _without_local_outliers(judged, listed, settings.margin, report)


def _judge(
    evaluator: PatchEvaluator, nominal: Refit, listed: Sequence[Candidate], margin: float
) -> Examined:
    is_moving = any(
        observation.instant is not None for observation in evaluator.model.observations
    )
    scores = screen(evaluator, nominal.coordinates, listed)
    disagreement = measure_disagreement(
        nominal, scores, margin, is_moving=is_moving, is_measured=evaluator.is_measured
    )
    return Examined(evaluator, nominal, scores, disagreement)


def _without_local_outliers(
    judged: Examined, listed: Sequence[Candidate], margin: float, report: Progress
) -> Examined:
    """Leave out what is off in one place only, as long as the rest is said to be off, too."""
    outliers: list[LocalOutlier] = []
    while judged.disagreement.is_worth_naming and len(outliers) < _MOST_OUTLIERS:
        found = find_local_outlier(judged.evaluator, judged.nominal)
        if found is None:
            break
        outliers.append(found)
        report(found.sentence)
        evaluator = judged.evaluator.without(judged.evaluator.left_out | found.patches)
        nominal = fit_patches(evaluator, judged.nominal.coordinates)
        judged = _judge(evaluator, nominal, listed, margin)
    return replace(judged, outliers=tuple(outliers))
