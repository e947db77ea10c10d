# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Turns that take a part to itself are listed, and axes of revolution told by the image."""

from diffcal_ros.registration.agreement import merit
from diffcal_ros.registration.rigid_view import RigidImage
from diffcal_ros.registration.rotations import spread_rotations
from diffcal_ros.registration.symmetry import PartAxes
from diffcal_ros.rigid_transform import apply
from diffcal_ros.scene.model import Masks
import numpy as np
import pytest

from .conftest import CAMERA, make_part, NOISE


def test_principal_axes_of_a_block_are_its_own():
    axes = PartAxes(make_part('block'))
    np.testing.assert_allclose(axes.middle, [-0.025, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(np.sort(np.abs(axes.axes), axis=0)[:2], 0.0, atol=1e-9)
    assert np.linalg.det(axes.axes) == pytest.approx(1.0)


def test_the_middle_does_not_depend_on_how_a_surface_is_cut():
    coarse, fine = make_part('clamp'), make_part('clamp')
    corners = fine.positions[fine.triangles]
    middles = corners.mean(axis=1)
    count = len(fine.positions)
    positions = np.vstack([fine.positions, middles])
    center = count + np.arange(len(middles))
    cut = np.concatenate(
        [np.column_stack([fine.triangles[:, [a, b]], center]) for a, b in ((0, 1), (1, 2), (2, 0))]
    )
    finer = type(fine)(positions, cut.astype(np.int32))
    first, second = PartAxes(coarse), PartAxes(finer)
    np.testing.assert_allclose(first.middle, second.middle, atol=1e-12)
    # Axes have no sign.
    np.testing.assert_allclose(np.abs(first.axes.T @ second.axes), np.eye(3), atol=1e-9)


def test_near_symmetric_poses_take_a_block_to_itself_in_three_of_them():
    fixture = make_part('block')
    poses = PartAxes(fixture).near_symmetric(np.eye(4), fixture)
    assert len(poses) == 23
    sorted_corners = np.array(sorted(fixture.positions.round(9).tolist()))
    same = [
        np.allclose(sorted_corners, sorted(apply(own, fixture.positions).round(9).tolist()))
        for own in poses
    ]
    assert sum(same) == 3


@pytest.mark.parametrize(('name', 'count'), [('cylinder', 1), ('block', 0), ('bracket', 0)])
def test_only_a_cylinder_turns_freely(picture, name, count):
    made = picture(name, seed=2, has_body=False)
    image = RigidImage(made.fixture, made.depth, CAMERA, Masks())
    free = PartAxes(made.fixture).free_axes(made.truth, lambda pose: merit(image, pose, NOISE))
    wanted = np.tile([1.0, 0.0, 0.0], (count, 1))
    np.testing.assert_allclose(np.abs(free), wanted, atol=1e-3)


def test_spread_rotations_leave_no_hole():
    rotations = spread_rotations(1500)
    np.testing.assert_allclose(np.linalg.det(rotations), 1.0)
    random = spread_rotations(97)  # Of another spiral.
    traces = np.einsum('aij,bij->ab', random, rotations)
    angles = np.rad2deg(np.arccos(np.clip(0.5 * (traces - 1.0), -1.0, 1.0)))
    assert angles.min(axis=1).max() < 20.0
