# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The unit of a mesh by the size that a camera sees."""

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.proposal.mesh_unit import fitting_units, sizes
import numpy as np
import pytest

CAMERA = PinholeCamera(400, 300, 290.0, 294.0, 203.5, 146.25)


def seen_at(distance: float) -> np.ndarray:
    depth = np.full((300, 400), np.nan, np.float32)
    depth[100:200, 50:350] = distance
    return depth


@pytest.mark.parametrize(('size', 'unit'), [(0.2, 'm'), (20.0, 'cm'), (200.0, 'mm')])
def test_a_hand_long_body_has_one_unit(size, unit):
    assert fitting_units(size, seen_at(0.4), CAMERA) == (unit,)


@pytest.mark.parametrize('size', [20000.0, 0.0002])
def test_a_body_that_is_metres_or_less_than_a_millimetre_long_has_none(size):
    assert fitting_units(size, seen_at(0.4), CAMERA) == ()


def test_two_units_are_left_where_both_sizes_fit_into_the_image():
    assert fitting_units(5.0, seen_at(0.12), CAMERA) == ('cm',)
    both = seen_at(0.12)
    both[:, 200:] = 1.5
    assert fitting_units(0.6, both, CAMERA) == ('m',)
    assert fitting_units(40.0, both, CAMERA) == ('cm', 'mm')


def test_the_sizes_are_told_in_every_unit():
    assert sizes(200.0) == 'in m 200 m, in cm 2 m, in mm 0.2 m'
