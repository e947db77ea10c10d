# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where the camera stands, what it sees and what its sensor makes of that."""

from collections.abc import Callable
from dataclasses import dataclass

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth.tracer import OutOfViewError
from diffcal_ros.rigid_transform import apply, looking_at, rotation_matrix, transform
from diffcal_ros.scene.model import DepthSensor
from diffcal_ros.synthetic.lidar import LidarModel
from diffcal_ros.synthetic.posed_body import PosedBody
from diffcal_ros.synthetic.scan import Scan, Thing
from diffcal_ros.synthetic.stage import scan_body
from diffcal_ros.synthetic.viewpoint import sees
import numpy as np

from benchmarks.zoo import clutter
from benchmarks.zoo.solids import FloatArray
from benchmarks.zoo.truth import Truth

_NEAR, _FAR = 0.35, 0.60  # Of the camera from the body's middle [m].
_LEAST_PIXELS = 2500  # A person needs to see something.
_LEAST_SEEN = 0.45  # Of what is in view without clutter.
_MOST_DRAWS = 300
_HIGHEST = np.deg2rad(65.0)


@dataclass(frozen=True)
class View:
    """What one camera sees.

    Attributes:
        camera: its intrinsics.
        camera_from_world: where it is, shape (4, 4).
        scan: what it would see without errors.
        seen_share: of the body's pixels that clutter leaves.
    """

    camera: PinholeCamera
    camera_from_world: FloatArray
    scan: Scan
    seen_share: float


def draw_view(truth: Truth, kinds: tuple[str, ...], random: np.random.Generator) -> View:
    """Draw camera and clutter until enough of the body is seen.

    Raises:
        RuntimeError: when no draw shows enough.
    """
    for _ in range(_MOST_DRAWS):
        view = _try_view(truth, kinds, random)
        if view is not None:
            return view
    raise RuntimeError(f'no view of the {truth.solid.name} with {kinds} shows enough of it')


def draw_sensor(random: np.random.Generator) -> tuple[DepthSensor, LidarModel]:
    """Draw a sensor like the L515 or like the D435: what is told of it, and what it does."""
    noise, step = (0.00014, 0.00025) if random.random() < 0.5 else (0.0003, 0.001)
    bias = float(random.uniform(0.0001, 0.0003))
    return DepthSensor(noise, step), LidarModel(noise=noise, step=step, bias=bias)


def measure(view: View, lidar: LidarModel, random: np.random.Generator) -> FloatArray:
    """Return one frame of a sensor [m], shape (H, W), NaN where it sees nothing."""
    bias = lidar.bias_field(view.scan.depth.shape, random)
    return lidar.measure(view.scan, bias, random)


def stated_pose(
    camera_from_world: FloatArray, pivot_world: FloatArray, offset: FloatArray
) -> FloatArray:
    """Return the pose that an offset moves to the true one, shape (4, 4).

    Args:
        camera_from_world: the true one, shape (4, 4).
        pivot_world: point about which the offset turns [m], shape (3,).
        offset: shift [m] and turn [rad] of what the stated camera sees, shape (6,).
    """
    rotation = rotation_matrix(offset[3:]).T @ camera_from_world[:3, :3]
    pivot = apply(camera_from_world, pivot_world) - offset[:3]
    return transform(rotation, pivot - rotation @ pivot_world)


def _try_view(truth: Truth, kinds: tuple[str, ...], random: np.random.Generator) -> View | None:
    camera = _draw_camera(random)
    pose = _draw_pose(truth, random, is_above='table' in kinds)
    if not sees(camera, pose, truth.points):
        return None
    body = PosedBody(truth.points, truth.points, truth.triangles, np.zeros(0, dtype=np.int32))
    try:
        alone = scan_body(body, camera, pose)
    except OutOfViewError:
        return None
    if (~alone.is_empty).sum() < _LEAST_PIXELS:
        return None
    rays = camera.rays()
    held = clutter.fixture(truth, random)
    free = held.scan(rays, pose).in_front_of(alone)
    before = int((free.things == Thing.BODY).sum())
    if before < _LEAST_PIXELS:
        return None
    makers: dict[str, Callable[[], tuple[clutter.Seen, ...]]] = {
        'fixture': lambda: (held,),
        'table': lambda: (clutter.table(truth, random),),
        'wall': lambda: (clutter.wall(truth, pose, random),),
        'cable': lambda: clutter.cable(truth, random),
        'hand': lambda: clutter.hand(truth, random),
        'screen': lambda: (clutter.screen(free_body(free), rays, pose, random),),
    }
    things = [thing for kind in kinds for thing in makers[kind]()]
    scan = clutter.composed(alone, things, rays, pose)
    # Without a block in view the held part shows, too: it counts on neither side.
    is_free = free.things == Thing.BODY
    share = float((scan.things[is_free] == Thing.BODY).mean())
    return View(camera, pose, scan, share) if share >= _LEAST_SEEN else None


def free_body(scan: Scan) -> Scan:
    """Return only what shows the body."""
    is_body = scan.things == Thing.BODY
    return Scan(
        np.where(is_body, scan.depth, np.nan),
        np.where(is_body, scan.cosine, 1.0),
        np.where(is_body, scan.things, int(Thing.NOTHING)).astype(np.int32),
    )


def _draw_camera(random: np.random.Generator) -> PinholeCamera:
    fx = float(random.uniform(560.0, 640.0))
    fy = fx * float(random.uniform(0.985, 1.015))
    cx, cy = random.uniform([305.0, 225.0], [335.0, 255.0])
    return PinholeCamera(640, 480, fx, fy, float(cx), float(cy))


def _draw_pose(truth: Truth, random: np.random.Generator, *, is_above: bool) -> FloatArray:
    """Draw a direction on the sphere, a distance and how the camera is rolled."""
    low, high = truth.points.min(axis=0), truth.points.max(axis=0)
    lowest = np.sin(np.deg2rad(12.0)) if is_above else -np.sin(_HIGHEST)
    rise = np.arcsin(random.uniform(lowest, np.sin(_HIGHEST)))
    around = random.uniform(0.0, 2.0 * np.pi)
    ahead = np.cos(rise) * np.array([np.cos(around), 0.0, np.sin(around)])
    direction = ahead + np.sin(rise) * np.array([0.0, 1.0, 0.0])
    distance = float(random.uniform(_NEAR, _FAR))
    level = looking_at(0.5 * (low + high), distance * direction, np.array([0.0, 1.0, 0.0]))
    roll = rotation_matrix(np.array([0.0, 0.0, np.deg2rad(random.uniform(-25.0, 25.0))]))
    return transform(roll, np.zeros(3)) @ level
