# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The drawing of a scene holds what it should, told by colours that only one thing has."""

import dataclasses
from pathlib import Path
import shutil

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.errors import InputError
from diffcal_ros.marker import Board, Marker
from diffcal_ros.report.scene_picture.scene_drawing import draw_scene
from diffcal_ros.report.scene_picture.scene_layout import (
    camera_lines,
    gravity_arrow,
    marker_squares,
    surface_regions,
    turn_arc,
)
from diffcal_ros.report.scene_picture.scene_legend import CAMERA_COLOR, GRAVITY_COLOR, TURNED_COLOR
from diffcal_ros.rigid_transform import rotation_matrix, transform
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.model import Turn
from matplotlib.colors import to_rgb
from matplotlib.image import imread
import numpy as np
import pytest

EXAMPLE = Path(__file__).resolve().parents[3] / 'config' / 'example_scene.yaml'


@pytest.fixture
def example(tmp_path, beam_mesh, write_tet):
    write_tet(tmp_path / 'beam.tet', beam_mesh)
    shutil.copy(EXAMPLE, tmp_path / 'scene.yaml')
    return load_scene(tmp_path / 'scene.yaml')


def _count(image, color):
    """Count pixels of one colour outside the legend at the bottom."""
    drawing = image[: int(0.85 * len(image)), :, :3]
    return int((np.abs(drawing - to_rgb(color)) < 0.02).all(axis=-1).sum())


def _drawn(scene, tmp_path, **options):
    draw_scene(scene, tmp_path / 'scene.png', **options)
    return imread(tmp_path / 'scene.png')


def _without_pose(scene):
    setups = tuple(
        dataclasses.replace(setup, stored_depth_from_world=None) for setup in scene.observations
    )
    return dataclasses.replace(scene, observations=setups)


def test_a_png_of_a_readable_size_is_drawn_and_nothing_else_is_left(example, tmp_path):
    before = set(tmp_path.iterdir())
    image = _drawn(example, tmp_path)
    assert image.shape[:2] == (770, 1540)
    assert set(tmp_path.iterdir()) - before == {tmp_path / 'scene.png'}


@pytest.mark.slow
def test_the_camera_is_drawn_where_its_pose_is_known(example, tmp_path):
    assert _count(_drawn(example, tmp_path), CAMERA_COLOR) > 100
    bare = _without_pose(example)
    assert _count(_drawn(bare, tmp_path), CAMERA_COLOR) == 0
    pose = example.observations[0].stored_depth_from_world
    given = _drawn(bare, tmp_path, depth_from_world=pose)
    np.testing.assert_array_equal(given, _drawn(example, tmp_path))


def test_a_pose_without_intrinsics_still_shows_the_camera(example, tmp_path):
    unknown = dataclasses.replace(example, depth_camera=None)
    image = _drawn(unknown, tmp_path)
    assert _count(image, CAMERA_COLOR) > 100
    known = _drawn(unknown, tmp_path, depth_camera=example.depth_camera)
    np.testing.assert_array_equal(known, _drawn(example, tmp_path))


def test_gravity_is_drawn_where_there_is_any(example, tmp_path):
    assert _count(_drawn(example, tmp_path), GRAVITY_COLOR) > 100
    weightless = tuple(
        dataclasses.replace(setup, gravity=np.zeros(3)) for setup in example.observations
    )
    floating = dataclasses.replace(example, observations=weightless)
    assert _count(_drawn(floating, tmp_path), GRAVITY_COLOR) == 0


def test_a_turn_is_drawn_in_its_own_colour(example, tmp_path):
    bare = _without_pose(example)
    assert _count(_drawn(bare, tmp_path), TURNED_COLOR) == 0
    twisted = dataclasses.replace(bare, observations=bare.observations[1:])
    assert _count(_drawn(twisted, tmp_path), TURNED_COLOR) > 50


def test_a_body_behind_the_camera_is_no_crash(example, tmp_path):
    behind = transform(np.eye(3), np.array([0.0, 0.0, -1.0]))
    assert _drawn(example, tmp_path, depth_from_world=behind).std() > 0.01


def test_surface_regions_are_those_of_the_tetrahedra_below(example):
    mesh = example.mesh
    centers = mesh.rest_positions[mesh.surface_triangles].mean(axis=1)
    regions = surface_regions(example)
    # Cells are 25 mm long, so that only faces of the two middle layers could be unclear.
    assert (regions[centers[:, 0] < -0.026] == 0).all()
    assert (regions[centers[:, 0] > 0.026] == 1).all()
    assert {0, 1} == set(regions)


def test_the_gravity_arrow_points_down_and_ends_above_the_body(beam_mesh):
    gravity = np.array([1.0, -9.0, 2.0])
    start, end = gravity_arrow(beam_mesh.rest_positions, gravity)
    direction = (end - start) / np.linalg.norm(end - start)
    np.testing.assert_allclose(direction, gravity / np.linalg.norm(gravity), atol=1e-12)
    assert (beam_mesh.rest_positions @ gravity > end @ gravity).all()


def test_a_turns_arc_runs_around_its_axis_by_its_angle(beam_mesh):
    rest = beam_mesh.rest_positions
    turn = Turn(np.array([1.0, 0.0, 0.0]), np.deg2rad(120.0), center=np.array([0.3, 0.1, 0.0]))
    arc = turn_arc(turn, rest)
    assert np.ptp(arc[:, 0]) < 1e-12
    spokes = arc[:, 1:] - turn.center[1:]
    np.testing.assert_allclose(np.linalg.norm(spokes, axis=1), np.linalg.norm(spokes[0]))
    cosine = spokes[0] @ spokes[-1] / (spokes[0] @ spokes[0])
    assert cosine == pytest.approx(np.cos(np.deg2rad(120.0)))
    assert np.linalg.norm(spokes[0]) > 0.11


def test_the_marker_square_has_its_side_and_pose():
    world_from_marker = transform(
        rotation_matrix(np.array([0.0, 0.4, 0.1])), np.array([0, 1, 2.0])
    )
    paper, (black,) = marker_squares(Marker('DICT_6X6_250', 0, 0.02, world_from_marker))
    sides = np.linalg.norm(np.roll(black, -1, axis=0) - black, axis=1)
    np.testing.assert_allclose(sides, 0.02)
    np.testing.assert_allclose(black.mean(axis=0), [0, 1, 2], atol=1e-12)
    np.testing.assert_allclose(
        (paper - paper.mean(axis=0)) @ world_from_marker[:3, 2], 0, atol=1e-12
    )


def test_a_board_has_its_black_squares_on_its_paper():
    board = Marker('DICT_4X4_50', 0, 0.022, board=Board(5, 7, 0.03))
    paper, black = marker_squares(board)
    assert black.shape == (18, 4, 3)
    np.testing.assert_allclose(np.ptp(black[..., :2], axis=(0, 1)), [0.15, 0.21])
    assert (np.ptp(paper[:, :2], axis=0) > [0.15, 0.21]).all()
    # The top left square is black.
    np.testing.assert_allclose(black[0].mean(axis=0), [-0.06, 0.09, 0.0], atol=1e-12)


def test_the_frustum_passes_through_the_images_corners(beam_mesh):
    camera = PinholeCamera(width=640, height=480, fx=500.0, fy=520.0, cx=300.0, cy=250.0)
    world_from_depth = transform(rotation_matrix(np.array([0.2, 3.0, 0.1])), np.array([0, 0, 0.5]))
    *edges, rectangle, axis = camera_lines(world_from_depth, camera, beam_mesh.rest_positions)
    depth_from_world = np.linalg.inv(world_from_depth)
    ends = np.stack([edge[1] for edge in edges])
    pixels = camera.project(ends @ depth_from_world[:3, :3].T + depth_from_world[:3, 3])
    np.testing.assert_allclose(pixels, [[0, 0], [639, 0], [639, 479], [0, 479]], atol=1e-9)
    np.testing.assert_array_equal(rectangle[:4], ends)
    assert np.linalg.norm(axis[1] - axis[0]) == pytest.approx(0.5, abs=0.01)


def test_a_drawing_that_cannot_be_written_says_so(example, tmp_path):
    (tmp_path / 'file').write_text('in the way')
    with pytest.raises(InputError, match=r'file/scene\.png cannot be written'):
        draw_scene(example, tmp_path / 'file' / 'scene.png')
