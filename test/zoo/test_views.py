# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What clutter hides, what a stated pose means, and that a seed gives one case."""

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.rigid_motion import moved
from diffcal_ros.rigid_transform import apply, inverse, rotation_matrix, transform
from diffcal_ros.synthetic.lidar import LidarModel
from diffcal_ros.synthetic.scan import Scan, Thing
import numpy as np
import pytest

from benchmarks.zoo import clutter
from benchmarks.zoo.bodies import BODIES
from benchmarks.zoo.meshes import true_mesh
from benchmarks.zoo.truth import body_surface, Truth
from benchmarks.zoo.views import draw_view, free_body, measure, stated_pose

CAMERA = PinholeCamera(80, 60, 75.0, 77.0, 38.5, 31.25)
TILTED = transform(rotation_matrix(np.array([0.3, -0.2, 0.1])), np.array([0.02, -0.01, 0.4]))


@pytest.fixture(scope='module')
def unbent() -> Truth:
    """A dragon that no weight bends: its view costs no simulation."""
    solid = BODIES['dragon']()
    mesh = true_mesh(solid)
    points, triangles = body_surface(mesh, mesh.nodes)
    return Truth(solid, np.eye(4), 1e6, 0.47, points, triangles, 0.0)


def _wall(depth: float) -> Scan:
    shape = (CAMERA.height, CAMERA.width)
    return Scan(np.full(shape, depth), np.ones(shape), np.full(shape, int(Thing.BODY), np.int32))


def test_a_ball_in_front_hides_and_one_behind_does_not() -> None:
    world_from_camera = inverse(TILTED)
    for distance, is_hidden in ((0.3, True), (0.6, False)):
        centre = apply(world_from_camera, np.array([0.0, 0.0, distance]))
        ball = clutter.Ball(transform(np.eye(3), centre), np.array([0.05, 0.04, 0.03]))
        view = clutter.composed(_wall(0.45), [ball], CAMERA.rays(), TILTED)
        row, column = round(CAMERA.cy), round(CAMERA.cx)
        assert (view.things[row, column] != Thing.BODY) == is_hidden


def test_a_sphere_and_a_rod_are_as_far_as_their_radius_says() -> None:
    rays, pose = CAMERA.rays(), np.eye(4)
    ball = clutter.Ball(transform(np.eye(3), np.array([0.0, 0.0, 0.4])), np.full(3, 0.05))
    rod = clutter.Rod(np.array([-0.3, 0.0, 0.4]), np.array([0.3, 0.0, 0.4]), 0.05)
    for thing in (ball, rod):
        scan = thing.scan(rays, pose)
        assert np.nanmin(scan.depth) == pytest.approx(0.35, abs=2e-4)
        assert scan.cosine.max() <= 1.0 + 1e-12
    seen = ball.scan(rays, pose).depth[..., None] * rays
    away = np.linalg.norm(seen - [0.0, 0.0, 0.4], axis=-1)
    assert np.nanmax(np.abs(away - 0.05)) < 1e-9


def test_a_screen_hides_about_a_third(unbent: Truth) -> None:
    clean = draw_view(unbent, (), np.random.default_rng(3))
    body = free_body(clean.scan)
    for seed in range(4):
        board = clutter.screen(
            body, clean.camera.rays(), clean.camera_from_world, np.random.default_rng(seed)
        )
        view = clutter.composed(body, [board], clean.camera.rays(), clean.camera_from_world)
        left = (view.things == Thing.BODY).sum() / (body.things == Thing.BODY).sum()
        assert 0.55 < left < 0.8


def test_a_hand_touches_the_body(unbent: Truth) -> None:
    (ball,) = clutter.hand(unbent, np.random.default_rng(5))
    own = apply(inverse(ball.world_from_ball), unbent.points[unbent.triangles].mean(axis=1))
    # 1 on the ellipsoid; the point that it touches is a millimetre inside.
    inside = np.linalg.norm(own / ball.radii, axis=1)
    assert 0.8 < inside.min() < 1.0


def test_a_fixture_is_wider_than_the_body(unbent: Truth) -> None:
    box = clutter.fixture(unbent, np.random.default_rng(6))
    held = unbent.points[unbent.points[:, 0] <= unbent.solid.clamp]
    assert (box.low < held.min(axis=0)).all()
    assert (box.high[1:] > held.max(axis=0)[1:]).all()
    assert box.high[0] == pytest.approx(unbent.solid.clamp)


def test_the_offset_takes_the_stated_pose_to_the_true_one() -> None:
    pivot, offset = np.array([0.03, -0.02, 0.05]), np.array([0.01, -0.02, 0.015, 0.1, -0.05, 0.12])
    points = np.random.default_rng(2).standard_normal((5, 3))
    stated = stated_pose(TILTED, pivot, offset)
    back = moved(apply(stated, points), offset, apply(stated, pivot))
    assert back == pytest.approx(apply(TILTED, points), abs=1e-12)


def test_a_seed_gives_one_view_and_one_frame(unbent: Truth) -> None:
    frames = []
    for _ in range(2):
        random = np.random.default_rng(8)
        view = draw_view(unbent, ('fixture', 'hand'), random)
        frames.append(measure(view, LidarModel(bias=0.0002), random))
    np.testing.assert_array_equal(frames[0], frames[1])
    assert view.seen_share > 0.45
