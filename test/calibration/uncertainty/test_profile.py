# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Profile likelihood beside Laplace: equal for small errors, open where data say nothing."""

from dataclasses import replace

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.profile_search import check_profiles, profile
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.depth.tracer import OutOfViewError
from diffcal_ros.errors import InputError
from diffcal_ros.scene.model import Quantity
import numpy as np
import pytest
from support.fingers import cable, filmed, finger_scene, via_points
from support.scenes import beam_scene, MODULUS, noisy, observation, true_depth

_SETTINGS = CalibrationSettings(with_mesh_error=False)
# What the integrated slope and the curvature may differ by for small errors.
AGREE = 0.15


@pytest.fixture(scope='module')
def depth() -> np.ndarray:
    return noisy(true_depth(counts=(8, 2, 2)), np.random.default_rng(2))


def test_small_errors_have_the_laplace_interval(depth) -> None:
    fit = Calibration(beam_scene(modulus=1.2 * MODULUS), [observation(depth)], _SETTINGS)
    result = fit.run()
    found = profile(fit, 'youngs_modulus')
    low, high = found.laplace
    width = high - low
    assert found.low == pytest.approx(low, abs=AGREE * width)
    assert found.high == pytest.approx(high, abs=AGREE * width)
    assert found.low < result['youngs_modulus'].value < found.high
    assert (np.diff(found.values) > 0.0).all()
    assert found.rises.min() > -0.02


@pytest.mark.slow
def test_others_are_fitted_again_as_one_is_held(depth) -> None:
    """With the placement free the modulus may go farther: the profile widens like its error."""
    scene = beam_scene(modulus=1.2 * MODULUS)
    widths, errors = [], []
    for names in (('youngs_modulus',), ('youngs_modulus', 'rigid_offset')):
        fit = Calibration(scene, [observation(depth)], replace(_SETTINGS, fit=names))
        errors.append(fit.run()['youngs_modulus'].std_error)
        found = profile(fit, 'youngs_modulus')
        widths.append(found.high - found.low)
    assert errors[1] > 1.3 * errors[0]
    assert widths[1] / widths[0] == pytest.approx(errors[1] / errors[0], rel=0.3)


def test_strong_prior_is_the_profile(depth) -> None:
    """Density beside the modulus: data see their ratio, so density follows its own prior."""
    scene = beam_scene()
    (region,) = scene.regions
    known = Quantity(1080.0, 100.0, 1e4, 1080.0, 40.0)
    scene = replace(scene, regions=(replace(region, density=known),))
    fit = Calibration(
        scene, [observation(depth)], replace(_SETTINGS, fit=('youngs_modulus', 'density'))
    )
    fit.run()
    found = profile(fit, 'density')
    assert found.low == pytest.approx(1080.0 * np.exp(-1.96 * 40.0 / 1080.0), rel=0.02)
    assert found.high == pytest.approx(1080.0 * np.exp(1.96 * 40.0 / 1080.0), rel=0.02)


@pytest.mark.slow
def test_slack_cable_has_an_open_end() -> None:
    """Any rest length from just taut on explains a slack cable: bounded below, open above."""
    loose = filmed(cable('tendon', -0.01, via_points()))
    fit = Calibration(finger_scene(cable('tendon', 0.004, via_points())), [loose], _SETTINGS)
    fit.run()
    found = profile(fit, 'rest_length')
    assert found.high == np.inf
    assert found.as_dict()['interval_95'][1] == np.inf


def test_end_is_open_where_the_body_is_lost_before_the_threshold(depth, monkeypatch) -> None:
    fit = Calibration(beam_scene(modulus=1.2 * MODULUS), [observation(depth)], _SETTINGS)
    error = fit.run()['youngs_modulus'].std_error / MODULUS
    linearise, best = fit.objective.linearise, fit.coordinates.copy()

    def lost(coordinates: np.ndarray) -> object:
        if (coordinates > best + error).any():
            raise OutOfViewError('the body has left the image')
        return linearise(coordinates)

    monkeypatch.setattr(fit.objective, 'linearise', lost)
    found = profile(fit, 'youngs_modulus')
    assert found.high == np.inf
    assert found.low == pytest.approx(found.laplace[0], rel=0.02)


def test_unknown_names_and_whole_image_losses_are_refused(depth) -> None:
    fit = Calibration(beam_scene(), [observation(depth)], _SETTINGS)
    with pytest.raises(InputError, match="cannot profile 'density': fitted are youngs_modulus"):
        check_profiles(fit, ('density',))
    image = Calibration(beam_scene(), [observation(depth)], CalibrationSettings(loss='paper'))
    with pytest.raises(InputError, match='whole-image loss has no likelihood'):
        check_profiles(image, ('youngs_modulus',))
