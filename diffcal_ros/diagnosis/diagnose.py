# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The procedure: fit, look for a disagreement, screen, refit, select, name or abstain."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
import time

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.diagnosis.answers import Verdict
from diffcal_ros.diagnosis.borders_seen import (
    with_borders_seen,
    with_borders_seen_beside,
    with_none_seen,
)
from diffcal_ros.diagnosis.detection.disagreement import (
    beside_a_model,
    Disagreement,
    measure_disagreement,
)
from diffcal_ros.diagnosis.detection.local_outlier import find_local_outlier, LocalOutlier
from diffcal_ros.diagnosis.detection.material_boundary import (
    with_material_boundary,
)
from diffcal_ros.diagnosis.model_comparison.bodies_of_pairs import bodies_of_pairs
from diffcal_ros.diagnosis.model_comparison.choice import choose
from diffcal_ros.diagnosis.model_comparison.motion_refit import refitted_there
from diffcal_ros.diagnosis.model_comparison.processes import all_set_aside, Processes
from diffcal_ros.diagnosis.model_comparison.refit_pool import processes_begun, RefitPool
from diffcal_ros.diagnosis.model_comparison.selection import begin, Begun, select, Selection
from diffcal_ros.diagnosis.patch_fits.refit import MAX_ITERATIONS, Refit, refit
from diffcal_ros.diagnosis.patches.boundary_strip import knows_boundary
from diffcal_ros.diagnosis.patches.noise_model import noise_of
from diffcal_ros.diagnosis.patches.patch_evaluator import make_patch_evaluator, PatchEvaluator
from diffcal_ros.diagnosis.patches.rigid_reference import with_fixture_offset
from diffcal_ros.diagnosis.patches.whitened import Part, residual_size
from diffcal_ros.diagnosis.screening.candidates import Candidate, candidates
from diffcal_ros.diagnosis.screening.screening import library_groups, Screen, screen
from diffcal_ros.diagnosis.verdict.conclude import conclude
from diffcal_ros.diagnosis.verdict.field_witness import FieldWitness
from diffcal_ros.diagnosis.verdict.form_in_doubt import with_form_in_doubt
from diffcal_ros.diagnosis.verdict.sure_part import with_sure_part
from diffcal_ros.diagnosis.verdict.verdict import Diagnosis
from diffcal_ros.one_blas_thread import blas_on_one_thread
from diffcal_ros.scene.model import Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Progress = Callable[[str], None]

# Steps of a motion's robust fit that lead nowhere before patches are fitted on from there.
_PATIENCE = 3
# Of a body at rest whose patches are fitted on from there: a load that is missing, and many that
# have let go, may lead a robust fit round in circles.
_MOST_ROBUST = 12
# Places that are left out at most.
_MOST_OUTLIERS = 2
# Evaluations of a fit of patches that another one follows: what parameters have yet to do is told
# by their tangents.
_BRIEF = 4


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
class DiagnosisTrace:
    """Everything that a diagnosis went through, for its page.

    Attributes:
        evaluator: of the nominal model.
        nominal: its fit.
        screen: scores of all candidates.
        disagreement: whether there is one.
        selection: refitted models; None where there was nothing to name.
        diagnosis: the verdict.
    """

    evaluator: PatchEvaluator
    nominal: Refit
    screen: Screen
    disagreement: Disagreement
    selection: Selection | None
    diagnosis: Diagnosis

    def described(self, **details: object) -> 'DiagnosisTrace':
        """Return the trace with the scene, and what else is given, in its verdict's details."""
        path = self.evaluator.model.scene.path
        scene = '' if path is None else str(path.resolve())
        known = {**self.diagnosis.details, 'scene': scene, **details}
        return replace(self, diagnosis=replace(self.diagnosis, details=known))


@blas_on_one_thread()
def diagnose(
    scene: Scene,
    observations: Sequence[Observation],
    settings: DiagnosisSettings | None = None,
    *,
    report: Progress = lambda _: None,
) -> DiagnosisTrace:
    """Find out whether a model lacks something, and what.

    Args:
        scene: the model as it is.
        observations: of one or several poses.
        settings: choices.
        report: called with what is being done.

    Raises:
        InputError: when the nominal model cannot be fitted.
    """
    settings = settings or DiagnosisSettings()
    begun = time.perf_counter()
    report('fitting the model as it is')
    evaluator, nominal = fit_nominal(scene, observations, settings.fit)
    seconds = time.perf_counter() - begun
    # They begin while this process looks at what is off.
    begun_beside = processes_begun(evaluator, nominal, seconds, settings.jobs)
    with begun_beside as processes, all_set_aside():
        judged = _examined(evaluator, nominal, settings, report)
        selection = choice = None
        if judged.disagreement.is_worth_naming:
            judged, selection = _selected(scene, judged, settings, report, processes)
        evaluator, nominal = judged.evaluator, judged.nominal
        witness = FieldWitness(evaluator, nominal)
        if selection is not None:
            choice = choose(selection, evaluator, nominal)
            if choice is not None:
                choice = with_sure_part(choice, selection, nominal, witness)
                choice = with_form_in_doubt(choice, nominal, witness)
    scores, disagreement = judged.scores, judged.disagreement
    if choice is not None:
        disagreement = beside_a_model(disagreement, choice.hypothesis.fit)
    # A load that is held is as good as at rest.
    if choice is not None and not all(evaluator.discretisation_error.is_slow):
        report('finding what mesh and time step cost there')
        choice = replace(choice, hypothesis=refitted_there(choice.hypothesis))
    seconds = time.perf_counter() - begun
    diagnosis = conclude(
        evaluator,
        nominal,
        scores,
        disagreement,
        selection,
        choice,
        seconds,
        judged.outliers,
        witness,
    )
    return DiagnosisTrace(evaluator, nominal, scores, disagreement, selection, diagnosis)


@dataclass(frozen=True)
class _Judged:
    """A nominal fit with its scores, what they say, and what was left out as the body's."""

    evaluator: PatchEvaluator
    nominal: Refit
    scores: Screen
    disagreement: Disagreement
    outliers: tuple[LocalOutlier, ...] = ()


def _examined(
    evaluator: PatchEvaluator, nominal: Refit, settings: DiagnosisSettings, report: Progress
) -> _Judged:
    """Score all candidates beside a nominal fit, with the smooth error that the sensor shows."""
    listed = candidates(evaluator.model.scene, settings.without, settings.fit)
    report(f'screening {len(listed)} candidates')
    evaluator, nominal = with_smooth_error(evaluator, nominal)
    judged = _judge(evaluator, nominal, listed, settings.margin)
    return _without_local_outliers(judged, listed, settings.margin, report)


def _judge(
    evaluator: PatchEvaluator, nominal: Refit, listed: Sequence[Candidate], margin: float
) -> _Judged:
    is_moving = any(
        observation.instant is not None for observation in evaluator.model.observations
    )
    scores = screen(evaluator, nominal.coordinates, listed)
    disagreement = measure_disagreement(
        nominal, scores, margin, is_moving=is_moving, is_measured=evaluator.is_measured
    )
    return _Judged(evaluator, nominal, scores, disagreement)


def _without_local_outliers(
    judged: _Judged, listed: Sequence[Candidate], margin: float, report: Progress
) -> _Judged:
    """Leave out what is off in one place only, as long as the rest is said to be off, too."""
    outliers: list[LocalOutlier] = []
    while judged.disagreement.is_worth_naming and len(outliers) < _MOST_OUTLIERS:
        found = find_local_outlier(judged.evaluator, judged.nominal)
        if found is None:
            break
        outliers.append(found)
        report(found.sentence)
        evaluator = judged.evaluator.without(judged.evaluator.left_out | found.patches)
        nominal = _fit_patches(evaluator, judged.nominal.coordinates)
        judged = _judge(evaluator, nominal, listed, margin)
    return replace(judged, outliers=tuple(outliers))


def _selected(
    stated: Scene,
    judged: _Judged,
    settings: DiagnosisSettings,
    report: Progress,
    processes: Processes | None,
) -> tuple[_Judged, Selection]:
    """Refit models; once more, where a border shows beside half of the best two effects.

    What showed beside the body as it was given may be somewhere else on that one.
    """
    found = _selected_at_first(judged, settings, report, processes)
    if not found[1].pairs:
        return found
    evaluator, nominal = with_none_seen(stated, judged.evaluator, judged.nominal)
    bodies = bodies_of_pairs(evaluator, nominal, found[1].pairs)
    known = with_borders_seen_beside(bodies, evaluator, nominal)
    if known is None or known[0].model.scene.effects == found[0].evaluator.model.scene.effects:
        return found
    return min(found, _selected_anew(known, settings, report), key=_left_by_best)


def _selected_at_first(
    judged: _Judged,
    settings: DiagnosisSettings,
    report: Progress,
    processes: Processes | None,
) -> tuple[_Judged, Selection]:
    """Refit models; once more, where a border shows beside one of a single effect."""
    with RefitPool(
        judged.evaluator, judged.nominal, report, jobs=settings.jobs, processes=processes
    ) as pool:
        begun = begin(pool, judged.scores, in_any_form=judged.disagreement.may_matter)
        known = with_borders_seen_beside(begun.singles, judged.evaluator, judged.nominal)
        if known is None:
            return judged, _select(pool, judged, begun)
    return _selected_anew(known, settings, report)


def _selected_anew(
    known: tuple[PatchEvaluator, Refit], settings: DiagnosisSettings, report: Progress
) -> tuple[_Judged, Selection]:
    """Screen and refit models of a scene that knows where what a camera reads ends."""
    report('parts of the surface are read otherwise: once more, with those known')
    judged = _examined(*known, settings, report)
    with RefitPool(judged.evaluator, judged.nominal, report, jobs=settings.jobs) as pool:
        return judged, _select(pool, judged)


def _left_by_best(found: tuple[_Judged, Selection]) -> float:
    """Return chi-square per patch of the best of the models that were selected."""
    best = found[1].best
    return np.inf if best is None else best.chi_square_per_patch


def _select(pool: RefitPool, judged: _Judged, begun: Begun | None = None) -> Selection:
    """Select models; a gap that does not matter has no name, and no second one."""
    return select(
        pool,
        judged.scores,
        begun,
        with_pairs=judged.disagreement.verdict is Verdict.DISAGREE,
        in_any_form=judged.disagreement.may_matter,
    )


def fit_nominal(
    scene: Scene, observations: Sequence[Observation], fit: Collection[str] | None
) -> tuple[PatchEvaluator, Refit]:
    """Fit the model as it is: robustly first, then patch by patch."""
    names = None if fit is None else tuple(fit)
    # What is missing from the model is for the diagnosis to say.
    settings = CalibrationSettings(
        fit=names,
        with_mesh_error=False,
        looks_farther=False,
        patience=_PATIENCE,
        max_iterations=_MOST_ROBUST if _are_watched(scene, observations) else None,
    )
    calibration = Calibration(scene, observations, settings)
    calibration.go_to_best()
    model, robust = with_fixture_offset(calibration.model_of_all(), calibration.coordinates)
    evaluator = make_patch_evaluator(model, robust)
    known = with_material_boundary(model.scene, evaluator, (robust, model.parameters.start()))
    if known is not model.scene:
        model = model.with_parameters(known, model.parameters)
        evaluator = make_patch_evaluator(model, robust)
    # Of several poses patches are fitted anew once it is known what to fit them by.
    is_brief = evaluator.tells_smooth_error
    nominal = _fit_patches(evaluator, robust, _BRIEF if is_brief else MAX_ITERATIONS)
    if knows_boundary(scene):
        return evaluator, nominal
    return with_borders_seen(evaluator, nominal)


def _are_watched(scene: Scene, observations: Sequence[Observation]) -> bool:
    """Tell whether all that is seen is at rest, in repeated frames: patches are fitted on."""
    return all(
        seen.instant is None and noise_of(seen, seen.sensor or scene.sensor).is_measured
        for seen in observations
    )


def with_smooth_error(evaluator: PatchEvaluator, nominal: Refit) -> tuple[PatchEvaluator, Refit]:
    """Return evaluator and fit with the smooth error that the sensor shows beside every effect.

    Effects that the library is denied, or that a fit has, are none less likely to be there. Beside
    a gap that is far above the floors it is hidden: of a large effect tangents leave more.
    """
    if evaluator.stays_robust or not evaluator.tells_smooth_error:
        return evaluator, nominal
    _, groups = library_groups(evaluator, nominal.coordinates, candidates(evaluator.model.scene))
    is_hidden = residual_size(nominal.groups, Part.FIT) > 0.0
    found = evaluator.with_smooth_error(groups, is_hidden=is_hidden)
    return found, nominal if found is evaluator else _fit_patches(found, nominal.coordinates)


def _fit_patches(
    evaluator: PatchEvaluator, robust: FloatArray, most: int = MAX_ITERATIONS
) -> Refit:
    """Fit patches from where a robust fit of pixels ended.

    Args:
        evaluator: of the nominal model.
        robust: coordinates, shape (k,).
        most: evaluations of the model at most.
    """
    # What noise to fit them by is a guess where it was not measured: the robust fit stands.
    most = 1 if evaluator.stays_robust else most
    return refit(evaluator, robust, max_iterations=most)
