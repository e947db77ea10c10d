# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The model as it is, fitted: robustly first, then patch by patch."""

from collections.abc import Collection, Sequence

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.diagnosis.borders_seen import with_borders_seen
from diffcal_ros.diagnosis.detection.material_boundary import with_material_boundary
from diffcal_ros.diagnosis.patch_fits.refit import MAX_ITERATIONS, Refit, refit
from diffcal_ros.diagnosis.patches.boundary_strip import knows_boundary
from diffcal_ros.diagnosis.patches.make_evaluator import make_patch_evaluator
from diffcal_ros.diagnosis.patches.noise_model import noise_of
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.patches.patch_gap import residual_size
from diffcal_ros.diagnosis.patches.rigid_reference import with_fixture_offset
from diffcal_ros.diagnosis.patches.whitened import Part
from diffcal_ros.diagnosis.screening.candidates import candidates
from diffcal_ros.diagnosis.screening.screening import library_groups
from diffcal_ros.scene.model import Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Steps of a motion's robust fit that lead nowhere before patches are fitted on from there.
_PATIENCE = 3
# Of a body at rest whose patches are fitted on from there: a load that is missing, and many that
# have let go, may lead a robust fit round in circles.
_MOST_ROBUST = 12
# Evaluations of a fit of patches that another one follows: what parameters have yet to do is told
# by their tangents.
_BRIEF = 4


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
    nominal = fit_patches(evaluator, robust, _BRIEF if is_brief else MAX_ITERATIONS)
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
    found = evaluator.with_smooth_error(groups, is_hidden=hides_errors(nominal))
    return found, nominal if found is evaluator else fit_patches(found, nominal.coordinates)


def hides_errors(fit: Refit) -> bool:
    """Tell whether a model leaves a gap that is far above the floors, which hides the sensor's."""
    return residual_size(fit.groups, Part.FIT) > 0.0


def fit_patches(
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
