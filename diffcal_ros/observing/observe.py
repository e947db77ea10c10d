# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Make observations of what was filmed: depth, fused or frame by frame, with a camera pose."""

from collections.abc import Iterable, Sequence
from typing import NamedTuple, Protocol

from diffcal_ros.calibration.forward.motion_frames import observe_motion
from diffcal_ros.calibration.observations.frame_times import chosen_frames, frame_times
from diffcal_ros.calibration.observations.observation import (
    fuse_frames,
    FusedDepth,
    make_observation,
    Observation,
)
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.errors import RecordingError
from diffcal_ros.observing.pose_sources import PoseSource, Sight
from diffcal_ros.observing.sensor_in_use import sensor_in_use
from diffcal_ros.rigid_transform import apply
from diffcal_ros.scene.model import DepthSensor, MotionSetup, Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# No depth camera sees a soft body from farther than this [m].
_FARTHEST = 50.0


class Film(Protocol):
    """Depth images of one posture or motion, from a bag or live."""

    @property
    def topic(self) -> str:
        """Where they come from."""

    def overview(self) -> Sequence[DepthFrame]:
        """Return those that are fused, at least one."""

    def stamps(self) -> list[int | None]:
        """Return the stamps of all frames [ns], None for an unreadable one."""

    def frames_at(self, indices: Sequence[int]) -> Iterable[DepthFrame | None]:
        """Return the frames at some places; None for one that cannot be read."""


class Take(NamedTuple):
    """What was made of a film.

    Attributes:
        observations: one of a body at rest, one a frame of a motion.
        notes: for a person.
    """

    observations: tuple[Observation, ...]
    notes: tuple[str, ...]


def observe_film(
    scene: Scene,
    setup_index: int,
    film: Film,
    find_pose: PoseSource,
    *,
    name: str,
    camera: PinholeCamera,
) -> Take:
    """Turn a film into observations: one of a body at rest, one a frame of a motion.

    Args:
        scene: the set-up.
        setup_index: which posture of the scene it shows.
        film: the frames.
        find_pose: says where the camera was.
        name: for reports.
        camera: intrinsics of the depth images.

    Raises:
        InputError: when there is no depth, no pose, or no motion to be seen.
    """
    frames = film.overview()
    fused = fuse_frames(frames)
    if fused.depth.shape != (camera.height, camera.width):
        rows, columns = fused.depth.shape
        raise RecordingError(
            f"the scene's camera is {camera.width}x{camera.height} but {film.topic} holds "
            f'{columns}x{rows} images: correct the camera in the scene, or leave it out to use '
            'camera_info'
        )
    _check_unit(fused, film.topic)
    stamps = tuple(frame.stamp_ns for frame in frames)
    pose = find_pose(Sight(fused.depth, camera, frames[0].frame_id, stamps))
    distance = _distance(scene, setup_index, pose.depth_from_world)
    sensor, seen = sensor_in_use(scene.sensor, frames, fused, camera, distance)
    resting = make_observation(name, setup_index, fused, camera, pose, sensor)
    motion = scene.observations[setup_index].motion
    if motion is None:
        return Take((resting,), (*seen, *pose.notes))
    observations, notes = _instants(resting, sensor, motion, film)
    return Take(observations, (*notes, *seen, *pose.notes))


def _distance(scene: Scene, setup_index: int, depth_from_world: FloatArray) -> float:
    """Return how far along the optical axis the middle of the body is at rest [m]."""
    middle = scene.mesh.rest_positions.mean(axis=0)
    placed = apply(scene.observations[setup_index].world_from_object, middle)
    return float(apply(depth_from_world, placed)[2])


def _instants(
    resting: Observation, sensor: DepthSensor, motion: MotionSetup, film: Film
) -> tuple[tuple[Observation, ...], list[str]]:
    times, notes = frame_times(film.stamps(), is_slow=motion.is_slow)
    chosen = chosen_frames(times, motion)
    read = list(film.frames_at([frame.index for frame in chosen]))
    return observe_motion(resting, sensor, motion, chosen, read), notes


def _check_unit(fused: FusedDepth, topic: str) -> None:
    """Refuse millimetres that were published as if they were metres."""
    middle = float(np.nanmedian(fused.depth))
    if middle > _FARTHEST:
        raise RecordingError(
            f'{topic} holds depths of {middle:.4g} m in the middle: 32FC1 is in metres, so '
            'publish millimetres as 16UC1, or divide them by 1000'
        )
