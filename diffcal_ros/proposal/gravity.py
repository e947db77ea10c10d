# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where gravity points in the world: as stated, as an IMU felt it, or as rigs usually stand."""

from dataclasses import dataclass

from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.errors import RecordingError
from diffcal_ros.marker import Marker
from diffcal_ros.proposal.bent_shape import GRAVITY
from diffcal_ros.recording.recording import Recording
from diffcal_ros.recording.topics.imu import read_imus, RestingImu
from diffcal_ros.recording.topics.recorded_frames import read_still_frames
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# An IMU within this of a usual direction is told to agree with it [degrees].
_AGREES = 3.0


@dataclass(frozen=True)
class Gravity:
    """Gravity, and how sure it is.

    Attributes:
        vector: in the world frame [m/s^2], shape (3,).
        doubts: what to check, in sentences without a full stop.
    """

    vector: FloatArray
    doubts: tuple[str, ...]


def gravity_of(
    recording: Recording,
    observation: Observation,
    stated: tuple[float, float, float] | None,
    marker: Marker | None,
    pose_frame: str,
) -> Gravity:
    """Find gravity.

    Args:
        recording: in which an IMU may be.
        observation: gives the camera's pose in the world.
        stated: by a person [m/s^2], or None.
        marker: the world's frame, or None.
        pose_frame: TF's name of the world, or empty.
    """
    if stated is not None:
        return Gravity(np.array(stated), ())
    usual, why = _usual(observation, marker, pose_frame)
    felt, problems = _felt(recording, observation)
    if felt is None:
        return Gravity(GRAVITY * usual, (why, *problems))
    imu, down = felt
    apart = float(np.rad2deg(np.arccos(np.clip(down @ usual, -1.0, 1.0))))
    if apart <= _AGREES:
        return Gravity(GRAVITY * down, ())
    told = (
        f'gravity is what {imu.topic} felt, {apart:.0f} degrees from the direction that a rig '
        'usually has it in; see that the frames of the IMU and of the cameras are right'
    )
    return Gravity(GRAVITY * down, (told,))


def _usual(
    observation: Observation, marker: Marker | None, pose_frame: str
) -> tuple[FloatArray, str]:
    if marker is not None:
        return np.array([0.0, -1.0, 0.0]), (
            "the marker is taken to hang upright, gravity along its frame's -y; no IMU says so"
        )
    if pose_frame:
        return np.array([0.0, 0.0, -1.0]), (
            f'gravity is taken to be along -z of {pose_frame}, as is usual in ROS (REP 103); no '
            'IMU says so'
        )
    # The world is the camera's frame, or that of a fixture in any direction.
    return observation.depth_from_world[:3, :3].T @ np.array([0.0, 1.0, 0.0]), (
        "gravity is not known: it is taken to point down in the depth image, the camera's +y; "
        'measure it, or record an IMU'
    )


def _felt(
    recording: Recording, observation: Observation
) -> tuple[tuple[RestingImu, FloatArray] | None, tuple[str, ...]]:
    """Return the first usable IMU and gravity's direction in the world, or what is wrong."""
    problems = []
    for imu in read_imus(recording.messages, recording.leave_out):
        if not imu.is_plausible:
            felt = float(np.linalg.norm(imu.acceleration))
            problems.append(f'{imu.topic} felt {felt:.1f} m/s^2 and not gravity alone')
            continue
        tree = read_still_frames(recording.messages, recording.leave_out)
        try:
            down = imu.down_in(recording.depth_frame_id, tree)
        except RecordingError as error:
            problems.append(f'{imu.topic} is not used ({error})')
            continue
        if down is None:
            problems.append(
                f'no transform leads from {imu.frame_id}, the frame of {imu.topic}, to the '
                'depth images'
            )
            continue
        return (imu, observation.depth_from_world[:3, :3].T @ down), ()
    return None, tuple(problems)
