# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A view that is held says of a frame what a new objective would."""

from dataclasses import replace

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.calibration.tracking.linearised_view import LinearisedView
import numpy as np
import pytest
from support.followed import exact
from support.scenes import beam_scene, MODULUS, noisy, observation

# Sums over pixels in another order: rounding.
ROUNDING = 1e-9
FIT = ('youngs_modulus', 'rigid_offset', 'depth_affine')


def _objective(depth):
    scene = beam_scene((8, 2, 2), modulus=1.1 * MODULUS, fit=FIT)
    seen = replace(observation(depth), pose_covariance=np.diag([1e-6] * 3 + [1e-5] * 3))
    made = Calibration(scene, [seen], CalibrationSettings(with_mesh_error=False))
    # Off in every coordinate, so that no two terms are alike.
    start = made.coordinates + np.linspace(1e-3, 2e-3, len(made.coordinates))
    return made.objective, start


def test_a_frame_says_what_a_new_objective_says():
    random = np.random.default_rng(4)
    first, second = noisy(exact(), random), noisy(exact(1.3), random)
    second[40:80, 100:140] = np.nan
    objective, there = _objective(first)
    held = LinearisedView(objective, there)
    fresh, _ = _objective(second)
    expected = fresh.linearise(there)
    mean, precision = fresh.model.parameters.prior()
    told = held.look(second).equations
    pull = precision @ (there - mean)
    np.testing.assert_allclose(
        told.negative_gradient,
        expected.negative_gradient + pull,
        rtol=ROUNDING,
        atol=ROUNDING * np.abs(pull).max(),
    )
    scale = np.sqrt(np.outer(np.diag(told.curvature), np.diag(told.curvature)))
    curved = expected.curvature - precision
    np.testing.assert_allclose(told.curvature / scale, curved / scale, atol=ROUNDING)
    informed = held.inform(second)
    np.testing.assert_allclose(
        informed.information / scale, expected.information / scale, atol=ROUNDING
    )
    np.testing.assert_allclose(
        informed.gradient_covariance / scale, expected.gradient_covariance / scale, atol=ROUNDING
    )
    prior_cost = 0.5 * float((there - mean) @ pull)
    assert told.cost == pytest.approx(expected.cost - prior_cost, rel=ROUNDING)
    assert held.gap(second) == fresh.gap(there)


def test_it_says_the_same_after_its_tracer_has_seen_another_view():
    random = np.random.default_rng(5)
    frame = noisy(exact(), random)
    objective, there = _objective(frame)
    held = LinearisedView(objective, there)
    before = held.look(frame).equations
    objective.cost(there + 0.02)
    after = held.look(frame).equations
    np.testing.assert_array_equal(before.negative_gradient, after.negative_gradient)
    assert before.cost == after.cost


def test_coverage_is_the_share_of_the_body_that_is_seen():
    frame = exact().astype(np.float32)
    objective, there = _objective(frame)
    held = LinearisedView(objective, there)
    assert held.look(frame).coverage > 0.9
    assert held.look(np.full_like(frame, np.nan)).coverage == 0.0
