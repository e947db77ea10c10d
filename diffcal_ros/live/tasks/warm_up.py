# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Compile every kernel that a fit of a scene needs, before the first frame is there."""

from dataclasses import dataclass, replace
import threading
import time

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.observations.observation import Instant, Observation
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.live.tasks.background import Post
from diffcal_ros.rigid_transform import transform
from diffcal_ros.scene.model import Scene
from diffcal_ros.scene.posing import world_positions
import numpy as np

# Fine enough that pixels are left within the bands around the outline that are not compared.
_WIDTH, _HEIGHT = 320, 240
_FAR = 3.0  # Distance in sizes of the body.
_FOCAL = 2.0 * _WIDTH  # Two thirds of the width for a body that is as wide as large [px].
_SHIFT = 0.001  # So that there is something to fit [m].
_FALL = 0.02  # For so long a body that is let go is followed [s].


@dataclass(frozen=True)
class Ready:
    """The kernels are compiled.

    Attributes:
        seconds: that it took.
    """

    seconds: float


def warm_up(
    scene: Scene, settings: CalibrationSettings, post: Post, stop: threading.Event
) -> None:
    """Take one step of a fit to a made-up view of the body itself, and post `Ready`.

    Raises:
        InputError: when the start values cannot be simulated.
    """
    begun = time.perf_counter()
    brief = replace(settings, max_iterations=1, search=False)
    unseen = Calibration(scene, _made_up_views(scene), brief)
    if stop.is_set():
        return
    calibration = Calibration(scene, _seen(unseen), brief)
    calibration.run(lambda record: record.number < 1 and not stop.is_set())
    post(Ready(time.perf_counter() - begun))


def _made_up_views(scene: Scene) -> list[Observation]:
    """Look at the body from a few of its sizes away, and see nothing yet; at a motion twice."""
    moving = [i for i, setup in enumerate(scene.observations) if setup.motion is not None]
    view = _made_up_view(scene, moving[0] if moving else 0)
    motion = scene.observations[view.setup_index].motion
    if motion is None:
        return [view]
    times = (0.0, motion.release_time.start + _FALL)
    return [replace(view, instant=Instant(time, 0)) for time in times]


def _made_up_view(scene: Scene, index: int) -> Observation:
    points = world_positions(scene.mesh, scene.observations[index])
    low, high = points.min(axis=0), points.max(axis=0)
    middle, distance = 0.5 * (low + high), _FAR * float(np.linalg.norm(high - low))
    facing = np.diag([1.0, -1.0, -1.0])
    depth_from_world = transform(facing, np.array([0.0, 0.0, distance]) - facing @ middle)
    return Observation(
        name='warm-up',
        setup_index=index,
        depth=np.full((_HEIGHT, _WIDTH), np.nan, dtype=np.float32),
        camera=PinholeCamera(_WIDTH, _HEIGHT, _FOCAL, _FOCAL, _WIDTH / 2.0, _HEIGHT / 2.0),
        depth_from_world=depth_from_world,
        pose_covariance=np.diag([1e-6] * 6),
    )


def _seen(calibration: Calibration) -> list[Observation]:
    """See the body where the start values put it, a little farther away, before a wall."""
    seen = []
    views = calibration.model.views(calibration.coordinates)
    for view, observation in zip(views, calibration.model.observations, strict=True):
        rendered = view.trace.full_depth()
        wall = 2.0 * float(np.nanmax(rendered))
        depth = np.where(np.isfinite(rendered), rendered + _SHIFT, wall)
        seen.append(replace(observation, depth=depth.astype(np.float32)))
    return seen
