# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A picture that is another one: what a lens does, and its derivatives by finite differences."""

from diffcal_ros.calibration.parameters.lens import lens_moves, lens_slopes, through_lens
from diffcal_ros.effects.camera_offset import LENS_MODES
import numpy as np
import pytest


@pytest.fixture
def points(random) -> np.ndarray:
    found: np.ndarray = random.normal(size=(50, 3)) * 0.1 + np.array([0.02, -0.05, 0.6])
    return found


@pytest.fixture
def amounts(random) -> np.ndarray:
    found: np.ndarray = 0.1 * random.normal(size=len(LENS_MODES))
    return found


def _only(**wanted: float) -> np.ndarray:
    return np.array([wanted.get(name, 0.0) for name in LENS_MODES])


def test_a_longer_lens_shows_all_as_much_farther_from_the_middle(points):
    seen = through_lens(points, _only(focal=0.03))
    np.testing.assert_allclose(seen[:, :2], 1.03 * points[:, :2])
    np.testing.assert_array_equal(seen[:, 2], points[:, 2])


def test_radial_distortion_grows_with_the_cube_of_the_place(points):
    seen, place = through_lens(points, _only(radial=0.2)), points[:, :2] / points[:, 2:]
    square = (place**2).sum(axis=1, keepdims=True)
    np.testing.assert_allclose(seen[:, :2] / seen[:, 2:], place * (1.0 + 0.2 * square))


def test_derivatives_by_the_points(points, amounts):
    slopes = lens_slopes(points, amounts)
    errors = []
    for step in (1e-2, 1e-3, 1e-4):
        sides = [
            [through_lens(points + sign * step * axis, amounts) for axis in np.eye(3)]
            for sign in (1.0, -1.0)
        ]
        difference = np.moveaxis(np.subtract(*sides), 0, -1) / (2.0 * step)
        errors.append(np.abs(difference - slopes).max())
    # Central differences: a tenth of the step is a hundredth of the error.
    assert errors[1] < 0.02 * errors[0], errors
    assert errors[2] < 0.02 * errors[1], errors


def test_derivatives_by_the_amounts(points, amounts):
    for step in np.eye(len(LENS_MODES)):
        moves = lens_moves(points, step)
        ahead = through_lens(points, amounts + 0.3 * step) - through_lens(points, amounts)
        np.testing.assert_allclose(ahead, 0.3 * moves, atol=1e-14)
        assert np.abs(moves).max() > 0.0
