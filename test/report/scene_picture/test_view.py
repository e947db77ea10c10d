# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Views for drawings: directions on the page, order of painting, and what is hidden."""

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.report.scene_picture.scene_layout import (
    overview,
    side_axes,
    side_view,
    world_triad,
)
from diffcal_ros.report.scene_picture.view import paint, View, visible_vertices
from diffcal_ros.rigid_transform import (
    check_rigid,
    inverse,
    looking_at,
    rotation_matrix,
    transform,
)
import numpy as np
import pytest

# One tetrahedron in front (z = 1) of a larger one behind it (z = 3), seen along +z.
CORNERS = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.2], [0.0, 1.0, 0.2], [0.3, 0.3, 0.5]])
FACES = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])
FRONT, BACK = np.array([0.0, 0.0, 1.0]), np.array([-0.8, -0.8, 3.0])
POINTS = np.vstack([CORNERS + FRONT, 3.0 * CORNERS + BACK])
TRIANGLES = np.vstack([FACES, FACES + 4])
CAMERA = PinholeCamera(width=640, height=480, fx=500.0, fy=520.0, cx=300.0, cy=250.0)
ALONG_Z = View(np.eye(4), CAMERA)


def test_a_perspective_view_is_the_cameras_image():
    depth_from_world = transform(
        rotation_matrix(np.array([0.1, 0.3, -0.2])), np.array([0, 0, 2.0])
    )
    page, depth = View(depth_from_world, CAMERA).project(POINTS)
    in_camera = POINTS @ depth_from_world[:3, :3].T + depth_from_world[:3, 3]
    np.testing.assert_allclose(page, CAMERA.project(in_camera))
    np.testing.assert_allclose(depth, in_camera[:, 2])


def test_points_behind_the_viewer_have_no_place():
    page, _ = ALONG_Z.project(np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]]))
    np.testing.assert_array_equal(np.isnan(page).all(axis=1), [True, False])


def test_faces_are_painted_from_back_to_front_and_only_front_ones():
    painted = paint(ALONG_Z, POINTS, TRIANGLES)
    assert (np.diff(painted.depths) <= 0.0).all()
    normals = np.cross(
        POINTS[TRIANGLES[:, 1]] - POINTS[TRIANGLES[:, 0]],
        POINTS[TRIANGLES[:, 2]] - POINTS[TRIANGLES[:, 0]],
    )
    centers = POINTS[TRIANGLES].mean(axis=1)
    facing = np.flatnonzero((normals * centers).sum(axis=1) < 0.0)
    np.testing.assert_array_equal(np.sort(painted.faces), facing)
    assert ((painted.brightness > 0.4) & (painted.brightness <= 1.0)).all()


def test_a_nearer_face_hides_a_vertex_and_its_own_do_not():
    shown = visible_vertices(ALONG_Z, POINTS, TRIANGLES, np.arange(8))
    # The near face spans pixels from (300, 250); vertex 4 lies left of it and is in the open.
    assert {0, 1, 2, 4} <= set(shown)
    behind = POINTS.copy()
    behind[4:] = 0.3 * CORNERS + [0.5, 0.5, 3.0]
    hidden = set(range(8)) - set(visible_vertices(ALONG_Z, behind, TRIANGLES, np.arange(8)))
    assert {4, 5, 6, 7} <= hidden
    asked = visible_vertices(ALONG_Z, POINTS, TRIANGLES, np.array([1, 4]))
    np.testing.assert_array_equal(asked, [1, 4])


def test_looking_at_puts_the_target_in_the_middle_and_up_up():
    target, direction = np.array([0.3, -0.1, 0.2]), np.array([1.0, 2.0, 0.5])
    up = np.array([0.1, 0.0, 1.0])
    view_from_world = check_rigid('view', looking_at(target, direction, up))
    in_view = view_from_world @ np.append(target, 1.0)
    np.testing.assert_allclose(in_view[:3], [0, 0, np.linalg.norm(direction)], atol=1e-12)
    assert (view_from_world[:3, :3] @ up)[1] < 0.0
    assert (view_from_world[:3, :3] @ up)[0] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize('gravity', [[0, -9.8, 0], [0, 0, -9.8], [0, 9.8, 0], [3.0, -9.0, 1.0]])
def test_the_side_view_has_gravity_down_and_world_coordinates(gravity, beam_mesh):
    down = np.array(gravity) / np.linalg.norm(gravity)
    view = side_view(beam_mesh.rest_positions, np.array(gravity))
    page, _ = view.project(np.vstack([np.zeros(3), down]))
    np.testing.assert_allclose(page, [[0, 0], [0, 1000]], atol=1e-9)
    check_rigid('view', view.view_from_world)


def test_side_axes_are_named_by_the_world(beam_mesh):
    level = side_view(beam_mesh.rest_positions, np.array([0.0, -9.8, 0.0]))
    assert side_axes(level) == ('world x', 'world y')
    turned = side_view(beam_mesh.rest_positions, np.array([0.0, 0.0, 9.8]))
    assert side_axes(turned) == ('world x', 'world -z')
    tilted = side_view(beam_mesh.rest_positions, np.array([0.0, -0.8, 0.6]))
    assert side_axes(tilted)[1] == 'world (-0.00, 0.80, -0.60)'


@pytest.mark.parametrize('has_camera', [True, False])
def test_the_overview_shows_every_point_and_keeps_gravity_down(beam_mesh, has_camera):
    rest = beam_mesh.rest_positions
    gravity = np.array([0.5, -9.7, 0.3])
    world_from_depth = inverse(
        transform(rotation_matrix(np.array([np.pi, 0.1, 0.0])), np.array([0.0, 0.0, 0.4]))
    )
    pose = world_from_depth if has_camera else None
    points = np.vstack([rest, world_from_depth[None, :3, 3]]) if has_camera else rest
    view = overview(points, rest, gravity, pose)
    page, depth = view.project(points)
    assert (depth > 0.0).all()
    middle = points.mean(axis=0)
    fall, _ = view.project(np.stack([middle, middle + 1e-4 * gravity]))
    assert fall[1, 1] > fall[0, 1]
    # Not seen end-on: the beam's length stays well beyond its 42 mm of diagonal thickness.
    ends = page[[rest[:, 0].argmin(), rest[:, 0].argmax()]]
    pixel = depth[: len(rest)].mean() / view.camera.fx
    assert np.linalg.norm(ends[1] - ends[0]) * pixel > 0.1


def test_a_camera_straight_above_has_an_overview(beam_mesh):
    world_from_depth = transform(
        rotation_matrix(np.array([np.pi / 2, 0, 0])), np.array([0, 0.5, 0])
    )
    rest = beam_mesh.rest_positions
    points = np.vstack([rest, world_from_depth[None, :3, 3]])
    view = overview(points, rest, np.array([0.0, -9.8, 0.0]), world_from_depth)
    page, depth = view.project(points)
    assert np.isfinite(page).all()
    assert (depth > 0.0).all()


def test_world_axes_stand_in_the_origin_unless_it_is_far(beam_mesh):
    origin, ends = world_triad(beam_mesh.rest_positions)
    np.testing.assert_array_equal(origin, np.zeros(3))
    np.testing.assert_allclose(ends, 0.05 * np.eye(3))
    far = beam_mesh.rest_positions + np.array([3.0, 0.0, 0.0])
    origin, ends = world_triad(far)
    assert np.linalg.norm(origin - far.mean(axis=0)) < 0.3
    np.testing.assert_allclose(ends - origin, 0.05 * np.eye(3), atol=1e-15)
