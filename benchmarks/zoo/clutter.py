# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What stands around a body and is told to nobody: seen by exact intersection of rays."""

from collections.abc import Sequence
from dataclasses import dataclass
import itertools
from typing import Protocol

from diffcal_ros.rigid_transform import apply, inverse, rotation_matrix, transform
from diffcal_ros.synthetic.scan import Scan, Thing
from diffcal_ros.synthetic.solids import Box, Wall
import numpy as np

from benchmarks.zoo.solids import FloatArray, Solid
from benchmarks.zoo.truth import Truth

KINDS = ('fixture', 'table', 'wall', 'cable', 'hand', 'screen')
_SHARES = (0.75, 0.25, 0.25, 0.3, 0.3, 0.3)
_UP = np.array([0.0, 1.0, 0.0])


class Seen(Protocol):
    """A thing that a camera may see."""

    def scan(self, rays: FloatArray, camera_from_world: FloatArray) -> Scan:
        """See it along rays with z = 1 in the camera's frame, shape (H, W, 3)."""


@dataclass(frozen=True)
class Ball:
    """An ellipsoid.

    Attributes:
        world_from_ball: its pose, shape (4, 4).
        radii: along its own axes [m], shape (3,).
    """

    world_from_ball: FloatArray
    radii: FloatArray

    def scan(self, rays: FloatArray, camera_from_world: FloatArray) -> Scan:
        """See it; see `Seen`."""
        own_from_camera = inverse(camera_from_world @ self.world_from_ball)
        eye = own_from_camera[:3, 3] / self.radii
        ahead = rays @ own_from_camera[:3, :3].T / self.radii
        depth = _nearest_root((ahead**2).sum(axis=-1), ahead @ eye, float(eye @ eye) - 1.0)
        normals = (eye + depth[..., None] * ahead) / self.radii
        return _seen(depth, normals @ own_from_camera[:3, :3], rays)


@dataclass(frozen=True)
class Rod:
    """A cylinder without caps; a ball at each joint closes a row of them.

    Attributes:
        start: one end in the world frame [m], shape (3,).
        end: the other [m], shape (3,).
        radius: [m].
    """

    start: FloatArray
    end: FloatArray
    radius: float

    def scan(self, rays: FloatArray, camera_from_world: FloatArray) -> Scan:
        """See it; see `Seen`."""
        start, end = apply(camera_from_world, np.stack([self.start, self.end]))
        length = float(np.linalg.norm(end - start))
        axis = (end - start) / length
        across = rays - (rays @ axis)[..., None] * axis
        foot = -start + (start @ axis) * axis
        depth = _nearest_root(
            (across**2).sum(axis=-1), across @ foot, float(foot @ foot) - self.radius**2
        )
        points = depth[..., None] * rays - start
        along = points @ axis
        with np.errstate(invalid='ignore'):
            depth = np.where((along >= 0.0) & (along <= length), depth, np.nan)
        return _seen(depth, points - along[..., None] * axis, rays)


def draw_kinds(random: np.random.Generator) -> tuple[str, ...]:
    """Draw which kinds of clutter a view has, at least one; never a table and a wall."""
    while True:
        chosen = [
            kind for kind, share in zip(KINDS, _SHARES, strict=True) if random.random() < share
        ]
        if chosen and not {'table', 'wall'} <= set(chosen):
            return tuple(chosen)


def fixture(truth: Truth, random: np.random.Generator) -> Box:
    """Put a block round the held end, wider than the body."""
    solid = truth.solid
    corners = _held_corners(solid)
    low, high = corners.min(axis=0), corners.max(axis=0)
    low = low - random.uniform([0.020, 0.008, 0.008], [0.045, 0.030, 0.030])
    high = high + random.uniform([0.0, 0.008, 0.008], [0.0, 0.030, 0.030])
    return Box(truth.world_from_object, low, high, Thing.BLOCK)


def table(truth: Truth, random: np.random.Generator) -> Box:
    """Put a table a little below the body."""
    top = float(truth.points[:, 1].min() - random.uniform(0.003, 0.060))
    middle = truth.points.mean(axis=0)
    high = np.array([0.4, top, 0.4]) + middle * [1.0, 0.0, 1.0]
    return Box(np.eye(4), high - [0.8, 0.02, 0.8], high, Thing.WALL)


def wall(truth: Truth, camera_from_world: FloatArray, random: np.random.Generator) -> Wall:
    """Put a wall behind the body, square to the camera but for some degrees."""
    world_from_camera = inverse(camera_from_world)
    ahead = world_from_camera[:3, :3] @ np.array([0.0, 0.0, 1.0])
    tilt = rotation_matrix(np.deg2rad(random.uniform(-20.0, 20.0, size=3)))
    normal = -(tilt @ ahead)
    nearest = float((truth.points @ normal).min() - random.uniform(0.005, 0.150))
    return Wall(nearest * normal, normal)


def hand(truth: Truth, random: np.random.Generator) -> tuple[Ball, ...]:
    """Let a lump of a hand's size touch the free part of the body."""
    point, normal = _spot(truth, random)
    turn = rotation_matrix(random.standard_normal(3))
    radii = random.uniform(0.020, 0.042, size=3)
    spread = turn @ np.diag(radii**2) @ turn.T
    reach = spread @ normal / np.sqrt(normal @ spread @ normal)
    return (Ball(transform(turn, point + reach - 0.001 * normal), radii),)


def cable(truth: Truth, random: np.random.Generator) -> tuple[Seen, ...]:
    """Hang a cable from above the clamp past the body, near it or touching it."""
    radius = float(random.uniform(0.0015, 0.0035))
    point, normal = _spot(truth, random)
    passing = point + (radius + random.uniform(0.0, 0.008)) * normal
    start = truth.held_middle + 0.05 * _UP + random.uniform(-0.02, 0.02, size=3)
    end = passing + random.uniform(-0.05, 0.05, size=3) - 0.08 * _UP
    control = 2.0 * passing - 0.5 * (start + end)
    share = np.linspace(0.0, 1.0, 11)[:, None]
    way = (1 - share) ** 2 * start + 2 * share * (1 - share) * control + share**2 * end
    rods = [Rod(a, b, radius) for a, b in itertools.pairwise(way)]
    joints = [Ball(transform(np.eye(3), joint), np.full(3, radius)) for joint in way]
    return (*rods, *joints)


def screen(
    body: Scan, rays: FloatArray, camera_from_world: FloatArray, random: np.random.Generator
) -> Box:
    """Put a board between camera and body that hides about a third of it.

    Args:
        body: what the camera sees of it.
        rays: of the camera, shape (H, W, 3).
        camera_from_world: its pose, shape (4, 4).
        random: source.
    """
    turn = rotation_matrix(np.array([0.0, 0.0, random.uniform(0.0, 2.0 * np.pi)]))
    across = (rays[~body.is_empty] @ turn)[:, 0]
    distance = float(random.uniform(0.6, 0.85) * np.nanmin(body.depth))
    edge = float(np.quantile(across, random.uniform(0.25, 0.40))) * distance
    low = np.array([float(across.min()) * distance - 0.04, -0.15, distance])
    high = np.array([edge, 0.15, distance + 0.004])
    return Box(inverse(camera_from_world) @ transform(turn, np.zeros(3)), low, high, Thing.PLATE)


def composed(
    body: Scan, things: Sequence[Seen], rays: FloatArray, camera_from_world: FloatArray
) -> Scan:
    """Return body and things in one view; what is nearer hides what is farther."""
    view = body
    for thing in things:
        view = thing.scan(rays, camera_from_world).in_front_of(view)
    return view


def _held_corners(solid: Solid) -> FloatArray:
    places = np.stack(
        np.meshgrid([0.0], np.arange(solid.y.shape[1]), np.arange(solid.z.shape[1])), axis=-1
    ).reshape(-1, 3)
    is_used = np.pad(solid.filled[0], 1)
    used = is_used[1:, 1:] | is_used[:-1, 1:] | is_used[1:, :-1] | is_used[:-1, :-1]
    rows = places[:, 1:].astype(int)
    corners = solid.place(places.astype(np.float64))[used[rows[:, 0], rows[:, 1]]]
    ends = corners.copy()
    ends[:, 0] = solid.clamp
    return np.concatenate([corners, ends])


def _spot(truth: Truth, random: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Draw a point of the free surface [m] and the normal out of it, world frame."""
    corners = truth.points[truth.triangles]
    middles = corners.mean(axis=1)
    away = np.linalg.norm(middles - truth.held_middle, axis=1)
    chosen = int(random.choice(np.flatnonzero(away > 0.5 * away.max())))
    a, b, c = corners[chosen]
    normal = np.cross(b - a, c - a)
    return middles[chosen], normal / np.linalg.norm(normal)


def _nearest_root(square: FloatArray, half: FloatArray, constant: float) -> FloatArray:
    """Return the smaller root of square t^2 + 2 half t + constant; NaN where it is not ahead."""
    inside = half**2 - square * constant
    with np.errstate(invalid='ignore', divide='ignore'):
        root = (-half - np.sqrt(inside)) / square
        return np.where(root > 0.0, root, np.nan)


def _seen(depth: FloatArray, normals: FloatArray, rays: FloatArray) -> Scan:
    """Return a view from depth and normals of any length in the camera's frame."""
    size = np.linalg.norm(normals, axis=-1) * np.linalg.norm(rays, axis=-1)
    is_hit = np.isfinite(depth)
    with np.errstate(invalid='ignore', divide='ignore'):
        cosine = np.abs((normals * rays).sum(axis=-1)) / size
    things = np.where(is_hit, int(Thing.BLOCK), int(Thing.NOTHING)).astype(np.int32)
    return Scan(depth, np.where(is_hit, cosine, 1.0), things)
