# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The procedure: fit, look for a disagreement, screen, refit, select, name or abstain."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
import time

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.diagnosis.detection.depth_discontinuity import small_step
from diffcal_ros.diagnosis.detection.disagreement import Disagreement, measure_disagreement
from diffcal_ros.diagnosis.detection.material_boundary import with_border, with_setting
from diffcal_ros.diagnosis.model_comparison.choice import choose
from diffcal_ros.diagnosis.model_comparison.hypothesis import refitted_there
from diffcal_ros.diagnosis.model_comparison.refit import MAX_ITERATIONS, Refit, refit
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.model_comparison.selection import select, Selection
from diffcal_ros.diagnosis.patches.evidence import Evidence, make_evidence
from diffcal_ros.diagnosis.patches.local_outlier import find_local_outlier, LocalOutlier
from diffcal_ros.diagnosis.patches.whitened import Part, residual_size
from diffcal_ros.diagnosis.screening.candidates import Candidate, candidates
from diffcal_ros.diagnosis.screening.screening import library_blocks, Screen, screen
from diffcal_ros.diagnosis.verdict.naming import conclude
from diffcal_ros.diagnosis.verdict.verdict import Diagnosis
from diffcal_ros.scene.model import Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Progress = Callable[[str], None]

# Places that are left out at most.
_MOST_OUTLIERS = 2


@dataclass(frozen=True)
class DiagnosisSettings:
    """Choices of a diagnosis.

    Attributes:
        margin: a gap above the floors that is smaller does not matter [m].
        without: identifiers that are left out of the library.
        fit: names of the nominal parameters; None: as the scene says.
        jobs: processes that refit models at the same time, where that is worth it.
    """

    margin: float = 0.0005
    without: tuple[str, ...] = ()
    fit: tuple[str, ...] | None = None
    jobs: int = 1


@dataclass(frozen=True)
class Course:
    """Everything that a diagnosis went through, for its page.

    Attributes:
        evidence: of the nominal model.
        nominal: its fit.
        screen: scores of all candidates.
        disagreement: whether there is one.
        selection: refitted models; None where there was nothing to name.
        diagnosis: the verdict.
    """

    evidence: Evidence
    nominal: Refit
    screen: Screen
    disagreement: Disagreement
    selection: Selection | None
    diagnosis: Diagnosis

    def described(self, **details: object) -> 'Course':
        """Return the course with the scene, and what else is given, in its verdict's details."""
        path = self.evidence.model.scene.path
        scene = '' if path is None else str(path.resolve())
        known = {**self.diagnosis.details, 'scene': scene, **details}
        return replace(self, diagnosis=replace(self.diagnosis, details=known))


def diagnose(
    scene: Scene,
    observations: Sequence[Observation],
    settings: DiagnosisSettings | None = None,
    *,
    tell: Progress = lambda _: None,
) -> Course:
    """Find out whether a model lacks something, and what.

    Args:
        scene: the model as it is.
        observations: of one or several poses.
        settings: choices.
        tell: told what is being done.

    Raises:
        InputError: when the nominal model cannot be fitted.
    """
    settings = settings or DiagnosisSettings()
    begun = time.perf_counter()
    tell('fitting the model as it is')
    evidence, nominal = fit_nominal(scene, observations, settings.fit)
    listed = candidates(evidence.model.scene, settings.without, settings.fit)
    tell(f'screening {len(listed)} candidates')
    evidence, nominal = with_smooth_error(evidence, nominal)
    judged = _judge(evidence, nominal, listed, settings.margin)
    judged, outliers = _without_local_outliers(judged, listed, settings.margin, tell)
    evidence, nominal = judged.evidence, judged.nominal
    scores, disagreement = judged.scores, judged.disagreement
    selection = choice = None
    if disagreement.is_worth_naming:
        with RefitPool(evidence, nominal, tell, jobs=settings.jobs) as pool:
            selection = select(pool, scores)
        choice = choose(selection, evidence)
    # A load that is held is as good as at rest.
    if choice is not None and not all(evidence.numerics.is_slow):
        tell('finding what mesh and step cost there')
        choice = replace(choice, hypothesis=refitted_there(choice.hypothesis))
    seconds = time.perf_counter() - begun
    diagnosis = conclude(
        evidence, nominal, scores, disagreement, selection, choice, seconds, outliers
    )
    return Course(evidence, nominal, scores, disagreement, selection, diagnosis)


@dataclass(frozen=True)
class _Judged:
    """A nominal fit with its scores and what they say."""

    evidence: Evidence
    nominal: Refit
    scores: Screen
    disagreement: Disagreement


def _judge(
    evidence: Evidence, nominal: Refit, listed: Sequence[Candidate], margin: float
) -> _Judged:
    is_moving = any(observation.instant is not None for observation in evidence.model.observations)
    scores = screen(evidence, nominal.coordinates, listed)
    disagreement = measure_disagreement(nominal, scores, margin, is_moving=is_moving)
    return _Judged(evidence, nominal, scores, disagreement)


def _without_local_outliers(
    judged: _Judged, listed: Sequence[Candidate], margin: float, tell: Progress
) -> tuple[_Judged, tuple[LocalOutlier, ...]]:
    """Leave out what is off in one place only, as long as the rest is said to be off, too."""
    outliers: list[LocalOutlier] = []
    while judged.disagreement.is_worth_naming and len(outliers) < _MOST_OUTLIERS:
        found = find_local_outlier(judged.evidence.model, judged.nominal)
        if found is None:
            break
        outliers.append(found)
        tell(found.sentence)
        evidence = judged.evidence.without(judged.evidence.left_out | found.patches)
        nominal = _fit_patches(evidence, judged.nominal.coordinates)
        judged = _judge(evidence, nominal, listed, margin)
    return judged, tuple(outliers)


def fit_nominal(
    scene: Scene, observations: Sequence[Observation], fit: Collection[str] | None
) -> tuple[Evidence, Refit]:
    """Fit the model as it is: robustly first, then patch by patch."""
    names = None if fit is None else tuple(fit)
    calibration = Calibration(
        scene, observations, CalibrationSettings(fit=names, with_mesh_error=False)
    )
    calibration.run()
    model = calibration.model_of_all()
    evidence = make_evidence(model, calibration.coordinates)
    readings = (calibration.coordinates, model.parameters.start())
    known = with_border(model.scene, evidence, readings)
    if known is not model.scene:
        model = model.with_parameters(known, model.parameters)
        evidence = make_evidence(model, calibration.coordinates)
    nominal = _fit_patches(evidence, calibration.coordinates)
    at = small_step(evidence, nominal)
    if at is not None:
        # The model stays what it is, and so does its fit: no effect is in it yet.
        model = model.with_parameters(with_setting(model.scene, at), model.parameters)
        evidence = make_evidence(model, nominal.coordinates)
    return evidence, nominal


def with_smooth_error(evidence: Evidence, nominal: Refit) -> tuple[Evidence, Refit]:
    """Return evidence and fit with the smooth error that the sensor shows beside every effect.

    Effects that the library is denied, or that a fit has, are none less likely to be there. Beside
    a gap that is far above the floors it is not seen: of a large effect tangents leave more.
    """
    if evidence.stays_robust or residual_size(nominal.blocks, Part.FIT) > 0.0:
        return evidence, nominal
    _, blocks = library_blocks(evidence, nominal.coordinates, candidates(evidence.model.scene))
    found = evidence.with_smooth_error(blocks)
    return found, nominal if found is evidence else _fit_patches(found, nominal.coordinates)


def _fit_patches(evidence: Evidence, robust: FloatArray) -> Refit:
    """Fit patches from where a robust fit of pixels ended."""
    # What noise to fit them by is a guess where it was not measured: the robust fit stands.
    most = 1 if evidence.stays_robust else MAX_ITERATIONS
    return refit(evidence, robust, max_iterations=most)
