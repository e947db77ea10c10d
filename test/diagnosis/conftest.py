# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fits of a beam whose gravity is tilted, and of one that is seen too far away."""

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.diagnosis.model_comparison.form_basis import FormBasis
from diffcal_ros.diagnosis.nominal_fit import fit_nominal
from diffcal_ros.diagnosis.patch_fits.refit import refit
from diffcal_ros.diagnosis.patches.make_evaluator import make_patch_evaluator
from diffcal_ros.diagnosis.screening.candidates import candidates
from diffcal_ros.diagnosis.screening.screening import screen
import pytest
from support.scenes import beam_scene
from support.watched import watched


@pytest.fixture(scope='session')
def screened():
    return _screened(0.06)


@pytest.fixture(scope='session')
def basis(screened) -> FormBasis:
    """What effects in other forms may do to the patches of that fit."""
    evaluator, nominal, _ = screened
    return FormBasis.of(evaluator, nominal, nominal)


@pytest.fixture(scope='session')
def clearly_screened():
    """A tilt that closes more of the gap than a name asks for, whatever the last digits are."""
    return _screened(0.09)


@pytest.fixture(scope='session')
def too_far():
    """A fit of a beam before a camera that reads too far everywhere."""
    return fit_nominal(beam_scene((6, 2, 2)), [watched(seed=1, bias=0.002)], None)


@pytest.fixture(scope='session')
def scores(too_far):
    """Scores of that bias and of a tilt."""
    evaluator, nominal = too_far
    wanted = ('depth_affine', 'gravity_tilt')
    listed = [c for c in candidates(evaluator.model.scene) if c.identifier in wanted]
    return screen(evaluator, nominal.coordinates, listed)


def _screened(tilt: float):
    scene, seen = beam_scene((6, 2, 2)), watched(seed=3, tilt=tilt)
    settings = CalibrationSettings(with_mesh_error=False)
    calibration = Calibration(scene, [seen], settings)
    calibration.run()
    evaluator = make_patch_evaluator(calibration.model, calibration.coordinates)
    fit = refit(evaluator, calibration.coordinates)
    return evaluator, fit, screen(evaluator, fit.coordinates, candidates(scene))
