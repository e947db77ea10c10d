# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A placement that is nearly level is taken to be."""

from diffcal_ros.proposal.level import level_placement, tilt
from diffcal_ros.rigid_transform import apply, rotation_matrix, transform
import numpy as np
import pytest

GRAVITY = np.array([0.0, -9.81, 0.0])
ALONG = np.array([0.0, 0.0, 1.0])
PIVOT = np.array([0.01, -0.02, 0.3])


def placed(turn: tuple[float, float, float], tilted: tuple[float, float, float]) -> np.ndarray:
    rotation = rotation_matrix(np.deg2rad(tilted)) @ rotation_matrix(np.deg2rad(turn))
    return transform(rotation, np.array([0.1, 0.2, -0.3]))


def test_a_slightly_tilted_body_is_level_again_and_its_clamp_stays():
    tilted = placed((0.0, 70.0, 0.0), (4.0, 0.0, -7.0))
    level = level_placement(tilted, ALONG, GRAVITY, PIVOT)
    down = level[:3, :3].T @ (GRAVITY / 9.81)
    assert np.sort(np.abs(down)) == pytest.approx([0.0, 0.0, 1.0], abs=1e-12)
    assert apply(level, PIVOT) == pytest.approx(apply(tilted, PIVOT), abs=1e-12)
    assert np.rad2deg(tilt(tilted, level)) == pytest.approx(np.hypot(4.0, 7.0), abs=0.3)


def test_a_turn_about_the_vertical_is_kept():
    upright = placed((0.0, 33.0, 0.0), (0.0, 0.0, 0.0))
    assert level_placement(upright, ALONG, GRAVITY, PIVOT) == pytest.approx(upright, abs=1e-12)


def test_a_body_on_a_slope_stays_there():
    sloping = placed((0.0, 0.0, 0.0), (30.0, 0.0, 0.0))
    assert np.array_equal(level_placement(sloping, ALONG, GRAVITY, PIVOT), sloping)
