# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Compile every kernel that a fit of a scene needs, before the first frame is there."""

from dataclasses import dataclass, replace
import threading
import time

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.observation import Observation
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.live.background import Post
from diffcal_ros.rigid_transform import transform
from diffcal_ros.scene.model import Scene
from diffcal_ros.scene.posing import world_positions
import numpy as np

# Fine enough that pixels are left within the bands around the outline that are not compared.
_WIDTH, _HEIGHT = 320, 240
_FAR = 3.0  # Distance in sizes of the body.
_FOCAL = 2.0 * _WIDTH  # Two thirds of the width for a body that is as wide as large [px].
_SHIFT = 0.001  # So that there is something to fit [m].


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
    brief = replace(settings, max_iterations=1)
    unseen = Calibration(scene, [_made_up_view(scene)], brief)
    if stop.is_set():
        return
    calibration = Calibration(scene, [_seen(unseen)], brief)
    calibration.run(lambda record: record.number < 1 and not stop.is_set())
    post(Ready(time.perf_counter() - begun))


def _made_up_view(scene: Scene) -> Observation:
    """Look at the body from a few of its sizes away, and see nothing yet."""
    points = world_positions(scene.mesh, scene.observations[0])
    low, high = points.min(axis=0), points.max(axis=0)
    middle, distance = 0.5 * (low + high), _FAR * float(np.linalg.norm(high - low))
    facing = np.diag([1.0, -1.0, -1.0])
    depth_from_world = transform(facing, np.array([0.0, 0.0, distance]) - facing @ middle)
    return Observation(
        name='warm-up',
        setup_index=0,
        depth=np.full((_HEIGHT, _WIDTH), np.nan, dtype=np.float32),
        camera=PinholeCamera(_WIDTH, _HEIGHT, _FOCAL, _FOCAL, _WIDTH / 2.0, _HEIGHT / 2.0),
        depth_from_world=depth_from_world,
        pose_covariance=np.diag([1e-6] * 6),
    )


def _seen(calibration: Calibration) -> Observation:
    """See the body where the start values put it, a little farther away, before a wall."""
    (observation,) = calibration.model.observations
    (view,) = calibration.model.views(calibration.coordinates)
    rendered = view.trace.full_depth()
    wall = 2.0 * float(np.nanmax(rendered))
    depth = np.where(np.isfinite(rendered), rendered + _SHIFT, wall)
    return replace(observation, depth=depth.astype(np.float32))
