# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Boxes and walls: what is seen lies on them, and the nearest thing is in front."""

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.rigid_transform import apply, inverse, rotation_matrix, transform
from diffcal_ros.synthetic.scan import Scan, Thing
from diffcal_ros.synthetic.solids import Box, Wall
import numpy as np

CAMERA = PinholeCamera(80, 60, 70.0, 74.0, 41.5, 27.0)
POSE = transform(rotation_matrix(np.array([0.3, -0.2, 0.5])), np.array([0.02, -0.03, 0.4]))
WORLD_FROM_BOX = transform(rotation_matrix(np.array([0.4, 0.7, -0.1])), np.array([0.01, 0, 0.02]))
LOW, HIGH = np.array([-0.05, -0.03, -0.02]), np.array([0.06, 0.03, 0.05])
BOX = Box(WORLD_FROM_BOX, LOW, HIGH, Thing.BLOCK)


def points_world(scan: Scan) -> np.ndarray:
    """Everything that is seen [m], shape (n, 3)."""
    lifted = CAMERA.back_project(scan.depth)[~scan.is_empty]
    return apply(inverse(POSE), lifted)


def test_what_is_seen_of_a_box_lies_on_its_faces_towards_the_camera():
    scan = BOX.scan(CAMERA.rays(), POSE)
    assert (scan.things[~scan.is_empty] == Thing.BLOCK).all()
    own = apply(inverse(WORLD_FROM_BOX), points_world(scan))
    assert len(own) > 200
    beyond = np.maximum(own - HIGH, LOW - own)  # Zero on a face, negative inside.
    np.testing.assert_allclose(beyond.max(axis=1), 0.0, atol=1e-12)
    eye = apply(inverse(POSE @ WORLD_FROM_BOX), np.zeros(3))
    face = beyond.argmax(axis=1)
    middle = 0.5 * (LOW + HIGH)
    sides = np.sign(own - middle)[np.arange(len(own)), face]
    limits = np.where(sides > 0, HIGH[face], LOW[face])
    assert (sides * (eye[face] - limits) > 0.0).all()


def test_a_boxs_outline_is_the_hull_of_its_corners():
    """Every pixel's ray that passes inside the projected corners meets the box."""
    scan = BOX.scan(CAMERA.rays(), POSE)
    pixels = CAMERA.project(apply(POSE, BOX.corners()))
    rows, columns = np.nonzero(~scan.is_empty)
    assert columns.min() >= pixels[:, 0].min() - 1e-9
    assert columns.max() <= pixels[:, 0].max() + 1e-9
    assert rows.min() >= pixels[:, 1].min() - 1e-9
    assert rows.max() <= pixels[:, 1].max() + 1e-9
    assert columns.max() - columns.min() > 0.9 * np.ptp(pixels[:, 0]) - 2


def test_slant_is_the_angle_to_the_faces_normal():
    """Seen straight on, the middle of a face has cosine 1 and a pixel aside its view angle's."""
    box = Box(np.eye(4), np.array([-1.0, -1.0, 0.5]), np.array([1.0, 1.0, 0.7]), Thing.BLOCK)
    rays = CAMERA.rays()
    scan = box.scan(rays, np.eye(4))
    np.testing.assert_allclose(scan.depth, 0.5, rtol=1e-12)
    np.testing.assert_allclose(scan.cosine, 1.0 / np.linalg.norm(rays, axis=-1), rtol=1e-12)


def test_a_box_behind_the_camera_is_not_seen():
    behind = transform(np.eye(3), np.array([0.0, 0.0, -2.0]))
    assert BOX.scan(CAMERA.rays(), behind @ POSE).is_empty.all()


def test_what_is_seen_of_a_wall_lies_in_its_plane():
    normal = np.array([0.2, -0.1, -0.97])
    normal /= np.linalg.norm(normal)
    wall = Wall(np.array([0.0, 0.1, 0.6]), normal)
    scan = wall.scan(CAMERA.rays(), POSE)
    assert not scan.is_empty.any()
    np.testing.assert_allclose((points_world(scan) - wall.point) @ normal, 0.0, atol=1e-12)


def test_the_nearer_thing_hides_the_farther_one_unless_painted_over():
    near, far = Scan.empty(2, 2), Scan.empty(2, 2)
    near.depth[0], near.things[0] = 0.3, Thing.BODY
    far.depth[:, 0], far.things[:, 0] = 0.5, Thing.WALL
    for both in (near.in_front_of(far), far.in_front_of(near)):
        np.testing.assert_array_equal(both.depth, [[0.3, 0.3], [0.5, np.nan]])
        np.testing.assert_array_equal(both.things, [[1, 1], [4, 0]])
    over = far.painted_over(near)
    np.testing.assert_array_equal(over.depth, [[0.5, 0.3], [0.5, np.nan]])
    assert over.things[0, 0] == Thing.WALL
