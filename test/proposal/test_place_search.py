# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A bent body is found again in a depth image that was drawn of it."""

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth.tracer import DepthTracer
from diffcal_ros.proposal.bent_shape import BentShape
from diffcal_ros.proposal.hold import Hold
from diffcal_ros.proposal.place_search import Candidate, PlaceSearch, turn_onto
from diffcal_ros.proposal.shape_sample import ShapeSampler
from diffcal_ros.registration.image_score import ImageScore
from diffcal_ros.rigid_transform import apply, rotation_matrix, transform
import numpy as np
import pytest

CAMERA = PinholeCamera(320, 240, 290.0, 294.0, 163.5, 116.25)
DOWN = np.array([0.08, 0.99, -0.116])
DOWN /= np.linalg.norm(DOWN)
HOLD = Hold(np.array([1.0, 0.0, 0.0]), 0.07)


@pytest.fixture
def shape(make_beam) -> BentShape:
    """A beam bent along a parabola towards -y, not the same from both sides."""
    mesh = make_beam((16, 2, 3), (0.2, 0.02, 0.035))
    positions = mesh.rest_positions.copy()
    free = np.clip(HOLD.plane - positions[:, 0], 0.0, None)
    positions[:, 1] -= 2.0 * free**2
    positions[:, 0] += 0.8 * free**2
    return BentShape(HOLD, np.array([0.0, -1.0, 0.0]), 1e5, positions)


@pytest.fixture
def mesh(make_beam):
    """The beam at rest."""
    return make_beam((16, 2, 3), (0.2, 0.02, 0.035))


@pytest.fixture
def pose() -> np.ndarray:
    """Where the camera sees it."""
    upright = turn_onto(np.array([0.0, -1.0, 0.0]), DOWN)
    return transform(rotation_matrix(0.7 * DOWN) @ upright, np.array([0.02, -0.03, 0.42]))


@pytest.fixture
def depth(mesh, shape, pose) -> np.ndarray:
    """What it sees: the body, and a plate beside the clamp that hides the held part."""
    points = apply(pose, shape.positions)
    tracer = DepthTracer(mesh.surface_triangles, mesh.vertex_count, CAMERA)
    image = np.array(tracer.trace(points).full_depth(), dtype=np.float32)
    held = CAMERA.project(points[HOLD.vertices(mesh)])
    low, high = held.min(axis=0).astype(int), held.max(axis=0).astype(int)
    image[low[1] - 20 : high[1] + 20, low[0] : high[0] + 25] = 0.36
    return image


def test_the_shortest_turn_takes_one_direction_to_another():
    for target in (np.array([0.6, 0.0, 0.8]), np.array([0.0, 0.0, 1.0]), np.array([0, 0, -1.0])):
        turn = turn_onto(np.array([0.0, 0.0, 1.0]), target)
        assert turn @ [0.0, 0.0, 1.0] == pytest.approx(target, abs=1e-12)
        assert np.linalg.det(turn) == pytest.approx(1.0)


def test_the_true_place_agrees_better_than_places_beside_it(mesh, shape, pose, depth):
    score = ImageScore(depth, CAMERA, 2)
    middle = apply(pose, shape.positions).mean(axis=0)
    sample = ShapeSampler(mesh, shape, 3000).look(
        pose[:3, :3], middle / np.linalg.norm(middle), 200, 150
    )
    there = sample.origin + pose[:3, 3]
    aside = there + 0.03 * np.vstack([np.zeros(3), np.eye(3), -np.eye(3)])
    values = score.at(sample, aside, 0.005)
    # Points within half a coarse pixel of the outline, 1.4 mm of a beam 20 mm wide, may look past
    # it (each costs 2), and the plate hides some of the free part: at most a quarter of them.
    assert values[0] > 0.5
    assert (values[1:] < values[0] - 0.3).all()


def test_a_wall_in_place_of_the_body_is_something_larger(mesh, shape, pose, depth):
    middle = apply(pose, shape.positions).mean(axis=0)
    sample = ShapeSampler(mesh, shape, 3000).look(
        pose[:3, :3], middle / np.linalg.norm(middle), 200, 150
    )
    there = (sample.origin + pose[:3, 3])[None]
    wall = np.full_like(depth, middle[2])
    tolerance = 0.05  # All of the body is this near to the wall.
    assert ImageScore(wall, CAMERA, 2).at(sample, there, tolerance)[0] < 0.0
    assert ImageScore(depth, CAMERA, 2).at(sample, there, tolerance)[0] > 0.5


@pytest.mark.slow
def test_a_body_is_found_anywhere_in_the_image(mesh, shape, pose, depth):
    found = PlaceSearch(mesh, depth, CAMERA, DOWN).candidates([shape])
    true = apply(pose, shape.positions)
    best = found[0]
    assert best.score > 0.8
    assert np.linalg.norm(best.points - true, axis=1).mean() < 0.006


def test_an_image_without_depth_shows_no_body(mesh, shape):
    empty = np.full((240, 320), np.nan, np.float32)
    assert PlaceSearch(mesh, empty, CAMERA, DOWN).candidates([shape]) == []


def test_a_candidate_knows_where_its_vertices_are(shape, pose):
    assert Candidate(shape, pose, 0.0).points == pytest.approx(apply(pose, shape.positions))


def test_a_clamp_beyond_the_reach_of_the_marker_counts_against_a_place(mesh, shape, pose, depth):
    candidate = Candidate(shape, pose, 0.0)
    held = apply(pose, shape.positions[HOLD.vertices(mesh)]).mean(axis=0)
    free = PlaceSearch(mesh, depth, CAMERA, DOWN).score(candidate)
    for away, loss in ((0.05, 0.0), (0.18, 0.1), (0.38, 0.3)):
        marker = held + away * np.array([0.6, 0.0, 0.8])
        score = PlaceSearch(mesh, depth, CAMERA, DOWN, marker).score(candidate)
        assert score == pytest.approx(free - loss, abs=1e-9)
