# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Make observations of the frames of a motion, by their own stamps."""

from collections.abc import Sequence
from dataclasses import replace

from diffcal_ros.calibration.forward.motion_check import check_motion
from diffcal_ros.calibration.observations.frame_noise import noise_at_rest
from diffcal_ros.calibration.observations.frame_times import FEWEST_FRAMES, FrameTime
from diffcal_ros.calibration.observations.observation import (
    Instant,
    measured_depth,
    Observation,
)
from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.errors import RecordingError
from diffcal_ros.scene.model import DepthSensor, MotionSetup


def observe_motion(
    resting: Observation,
    sensor: DepthSensor,
    motion: MotionSetup,
    chosen: Sequence[FrameTime],
    read: Sequence[DepthFrame | None],
) -> tuple[Observation, ...]:
    """Make an observation of each frame that is used; all else is as in one at rest.

    Args:
        resting: gives camera and pose.
        sensor: the depth camera, as these images need it.
        motion: what the scene says of it.
        chosen: frames that are used, see `chosen_frames`.
        read: their images; None where one cannot be read.

    Raises:
        RecordingError: when they do not show a body at rest that is let go.
    """
    good = [(when, frame) for when, frame in zip(chosen, read, strict=True) if frame is not None]
    if len(good) < FEWEST_FRAMES:
        raise RecordingError(
            f'{len(good)} of {len(chosen)} depth frames can be read: a motion needs at least '
            f'{FEWEST_FRAMES}'
        )
    check_motion([frame for _, frame in good], [when.time for when, _ in good], motion)
    before = [frame for when, frame in good if when.time < motion.release_time.start]
    noise = noise_at_rest(before)
    return tuple(
        replace(
            resting,
            name=f'{resting.name}, {when.time:.3f} s',
            depth=measured_depth(frame.depth, sensor),
            frame_count=1,
            noise=noise.pixel,
            grain=noise.grain,
            instant=Instant(when.time, resting.setup_index, when.is_held_out),
        )
        for when, frame in good
    )
