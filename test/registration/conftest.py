# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Rigid parts that hold a bent bar, as a camera sees them."""

from dataclasses import dataclass
from itertools import pairwise

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth.tracer import DepthTracer
from diffcal_ros.registration.held_body import BodyAtRest
from diffcal_ros.rigid_transform import apply, inverse, rotation_vector, transform
from diffcal_ros.scene.model import Fixture
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks import rigid_parts

CAMERA = PinholeCamera(320, 240, 300.0, 302.0, 158.0, 121.0)
WALL, NOISE = 0.7, 2e-4
HALF = np.array([0.02, 0.028])


@dataclass(frozen=True)
class Picture:
    """What a camera sees of a part, and maybe of the bar in it.

    Attributes:
        fixture: in the object frame.
        body: the bar at rest, gravity along -y.
        truth: depth_from_object, shape (4, 4).
        depth: z [m], with noise.
    """

    fixture: Fixture
    body: BodyAtRest
    truth: np.ndarray
    depth: np.ndarray

    def error(self, pose: np.ndarray) -> tuple[float, float]:
        """Return how far a pose is off, the part's corners at most [m], and its turn [rad]."""
        corners = self.fixture.positions
        apart = np.linalg.norm(apply(pose, corners) - apply(self.truth, corners), axis=1)
        turn = rotation_vector(pose[:3, :3] @ self.truth[:3, :3].T)
        return float(apart.max()), float(np.linalg.norm(turn))

    def squared(self, pose: np.ndarray, covariance: np.ndarray, pivot: np.ndarray) -> float:
        """Return the squared error of a pose in units of its covariance."""
        shift = apply(self.truth, apply(inverse(pose), pivot)) - pivot
        turn = rotation_vector(self.truth[:3, :3] @ pose[:3, :3].T)
        error = np.concatenate([shift, turn])
        return float(error @ np.linalg.solve(covariance, error))


def make_part(name: str) -> Fixture:
    """Return a part by its name."""
    if name == 'cylinder':
        return rigid_parts.cylinder(0.024, 0.05)
    if name == 'clamp':
        return rigid_parts.clamp(HALF, 0.06, 0.009)
    return getattr(rigid_parts, name)(HALF, 0.05)


def make_picture(name: str, *, seed: int, has_body: bool) -> Picture:
    """Render a part in some pose 0.36 m away, before a wall."""
    fixture = make_part(name)
    ends = np.linspace(-0.02, 0.12, 15)
    bar = rigid_parts.blocks(
        [((low, high), (-0.009, 0.009), (-0.012, 0.012)) for low, high in pairwise(ends)]
    )
    turn = Rotation.random(random_state=seed).as_matrix()
    middle = fixture.positions.mean(axis=0)
    truth = transform(turn, np.array([0.01, -0.02, 0.36]) - turn @ middle)
    parts = [(fixture.positions, fixture.triangles)]
    if has_body:
        hanging = bar.positions.copy()
        hanging[:, 1] -= 2.0 * np.maximum(hanging[:, 0], 0.0) ** 2
        parts.append((hanging, bar.triangles))
    depth = np.full((CAMERA.height, CAMERA.width), WALL)
    for positions, triangles in parts:
        seen = DepthTracer(triangles, len(positions), CAMERA).trace(apply(truth, positions))
        depth = np.fmin(depth, seen.full_depth())
    depth = depth + np.random.default_rng(seed).normal(0.0, NOISE, depth.shape)
    body = BodyAtRest(bar.positions, bar.triangles, np.array([0.0, -1.0, 0.0]))
    return Picture(fixture, body, truth, depth.astype(np.float32))


@pytest.fixture
def picture():
    """Make pictures: `picture(name, seed=.., has_body=..)`."""
    return make_picture
