# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A part is found with no start value, or what is wrong is told."""

from diffcal_ros.errors import PoseError
from diffcal_ros.registration.register import register_part
import numpy as np
import pytest

from .conftest import CAMERA, make_part, NOISE, WALL

pytestmark = pytest.mark.slow


def find(made, **changes):
    wanted = {'fixture': made.fixture, 'depth': made.depth, 'camera': CAMERA, 'noise': NOISE}
    return register_part(**{**wanted, **changes})


@pytest.mark.parametrize(('name', 'seed'), [('bracket', 1), ('clamp', 0), ('bracket', 4)])
def test_a_part_without_symmetry_is_found_by_itself(picture, name, seed):
    made = picture(name, seed=seed, has_body=True)
    found = find(made)
    shift, turn = made.error(found.depth_from_object)
    assert shift < 6e-4
    assert turn < np.deg2rad(0.5)
    assert made.squared(found.depth_from_object, found.covariance, found.pivot) < 30.0
    assert found.is_only
    # Where it was before it is found again, and a little elsewhere as well.
    again = find(made, known=found)
    assert made.error(again.depth_from_object)[0] < 6e-4


def test_a_block_is_refused_by_itself(picture):
    made = picture('block', seed=2, has_body=True)
    with pytest.raises(PoseError, match=r'poses of the fixture agree.*no body is known.*marker'):
        find(made)


def test_a_body_that_hangs_decides_between_poses_of_a_block(picture):
    made = picture('block', seed=2, has_body=True)
    found = find(made, body=made.body)
    assert made.error(found.depth_from_object)[0] < 6e-4
    assert 'decides' in ' '.join(found.notes)
    assert not found.is_only


def test_a_body_of_unknown_gravity_does_not_decide(picture):
    """A bar of two planes of symmetry fits turned upside down; only how it hangs tells."""
    made = picture('block', seed=2, has_body=True)
    body = type(made.body)(made.body.positions, made.body.triangles)
    with pytest.raises(PoseError, match='the body does not tell'):
        find(made, body=body)


def test_a_cylinder_is_turned_as_the_body_says_and_not_exactly(picture):
    made = picture('cylinder', seed=3, has_body=True)
    found = find(made, body=made.body)
    assert made.error(found.depth_from_object)[1] < np.deg2rad(6.0)
    axis = found.depth_from_object[:3, 0]
    about = float(np.sqrt(axis @ found.covariance[3:, 3:] @ axis))
    assert np.deg2rad(2.0) <= about < np.deg2rad(15.0)
    assert 'tells the turn' in ' '.join(found.notes)


def test_a_cylinder_without_a_body_is_refused(picture):
    with pytest.raises(PoseError, match='however it is turned'):
        find(picture('cylinder', seed=3, has_body=False))


def test_another_part_than_the_one_in_view_is_refused(picture):
    made = picture('bracket', seed=1, has_body=False)
    with pytest.raises(PoseError, match='nothing in the depth image looks like the fixture'):
        find(made, fixture=make_part('clamp'))


def test_an_empty_image_is_refused():
    wall = np.full((CAMERA.height, CAMERA.width), WALL, dtype=np.float32)
    with pytest.raises(PoseError, match='looks like the fixture of 50 x 80 x 56 mm'):
        register_part(make_part('bracket'), wall, CAMERA)
    with pytest.raises(PoseError, match='nothing in the depth image'):
        register_part(make_part('bracket'), np.full_like(wall, np.nan), CAMERA)
