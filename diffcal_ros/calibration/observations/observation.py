# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What was seen of the body in one posture, or at one instant of its motion, by one camera."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from diffcal_ros.calibration.observations.camera_pose import CameraPose
from diffcal_ros.calibration.observations.frame_noise import frame_noise, FrameNoise
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.errors import RecordingError
from diffcal_ros.scene.model import DepthSensor
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Frames beyond this many say nothing new about a body at rest.
MAX_FUSED_FRAMES = 31
# So many standard deviations from the median a depth is the same surface's.
_NEAR = 4.0
_PIXELS_AT_ONCE = 8192


@dataclass(frozen=True)
class Instant:
    """When a frame of a moving body was taken.

    Attributes:
        time: after the first frame of its recording [s].
        recording: number that the frames of one recording share; they share the camera's pose.
        is_held_out: the frame is kept from the fit, to check it.
    """

    time: float
    recording: int
    is_held_out: bool = False


@dataclass(frozen=True)
class Observation:
    """Depth of a body, and where the camera was.

    Attributes:
        name: for reports.
        setup_index: which posture of the scene it shows.
        depth: z [m], shape (H, W), float32; NaN where invalid.
        camera: intrinsics of the depth image.
        depth_from_world: camera pose, shape (4, 4).
        pose_covariance: of that pose: a shift of `pose_pivot` [m] and a turn about it [rad],
            as vectors in the depth camera's frame, shape (6, 6); None where it is taken as exact.
        pose_pivot: point of the rig whose pose was measured, in the depth camera's frame [m],
            shape (3,); None for the middle of the held part.
        frame_count: frames that `depth` was made from.
        noise: standard deviation of one pixel of `depth` [m], measured from the frames; of a
            motion from those before the release; NaN where there are too few.
        grain: pixels whose average scatters as one does, see `FrameNoise`, measured likewise.
        instant: of a body that moves; None for one at rest.
        left_out: pixels that are not looked at, shape (H, W); None: all are.
        mirrored: another camera pose that a flat marker allows about as well, shape (4, 4), or
            None.
        sensor: the depth camera, as these images need it; None: as the scene says.
    """

    name: str
    setup_index: int
    depth: NDArray[np.float32]
    camera: PinholeCamera
    depth_from_world: FloatArray
    pose_covariance: FloatArray | None = None
    pose_pivot: FloatArray | None = None
    frame_count: int = 1
    noise: float = float('nan')
    grain: float = 1.0
    instant: Instant | None = None
    left_out: NDArray[np.bool_] | None = None
    mirrored: FloatArray | None = None
    sensor: DepthSensor | None = None

    @property
    def is_held_out(self) -> bool:
        """Tell whether it is a frame that is kept from the fit."""
        return self.instant is not None and self.instant.is_held_out

    @property
    def time(self) -> float | None:
        """Return when it was taken after the first frame [s]; None of a body at rest."""
        return None if self.instant is None else self.instant.time


def pose_owners(observations: Sequence[Observation]) -> tuple[int, ...]:
    """Return for each observation the first one that was taken from the same camera pose."""
    first: dict[int, int] = {}
    owners = []
    for number, observation in enumerate(observations):
        instant = observation.instant
        owners.append(number if instant is None else first.setdefault(instant.recording, number))
    return tuple(owners)


def pose_covariances(
    observations: Sequence[Observation], own_offset: FloatArray | None = None
) -> list[FloatArray | None]:
    """Return each pose's covariance, shape (6, 6), once: None where another one owns the pose.

    Args:
        observations: in order.
        own_offset: covariance of an offset that every recording has for itself, which is added;
            None for none.
    """
    found: list[FloatArray | None] = []
    for number, owner in enumerate(pose_owners(observations)):
        known = [
            covariance
            for covariance in (observations[number].pose_covariance, own_offset)
            if covariance is not None
        ]
        found.append(sum(known[1:], known[0]) if known and owner == number else None)
    return found


@dataclass(frozen=True)
class FusedDepth:
    """Frames of a scene at rest made into one.

    Attributes:
        depth: mean over frames near their median [m], shape (H, W), NaN where most saw nothing.
        frame_count: frames used.
        noise: standard deviation of one pixel of `depth` over time [m]; NaN from one frame.
        grain: pixels whose average scatters as one does, see `FrameNoise`.
    """

    depth: NDArray[np.float32]
    frame_count: int
    noise: float
    grain: float = 1.0


def fuse_frames(frames: Iterable[DepthFrame]) -> FusedDepth:
    """Take the mean over frames of a body at rest, of what lies near their median.

    A pixel counts where at least half of the frames saw something: flying pixels come and go. The
    median leaves them out; but of depths in steps it is a step itself, however many frames there
    are, and the mean is not: noise carries it over the steps.

    Raises:
        RecordingError: without frames, or when every pixel of every frame is invalid.
    """
    stack: list[NDArray[np.float32]] = []
    for frame in frames:
        stack.append(frame.depth)
        if len(stack) == MAX_FUSED_FRAMES:
            break
    if not stack:
        raise RecordingError('there is no depth frame: a calibration needs at least one')
    if len(stack) == 1:
        fused, noise = stack[0], FrameNoise()
    else:
        images = np.stack(stack)
        seen = np.isfinite(images).sum(axis=0)
        fused = np.full(images.shape[1:], np.nan, dtype=np.float32)
        enough = 2 * seen >= len(stack)
        single = frame_noise(images)
        fused[enough] = _mean_near_median(images[:, enough], _NEAR * single.pixel)
        noise = replace(single, pixel=single.pixel / float(np.sqrt(len(stack))))
    if not np.isfinite(fused).any():
        raise RecordingError(
            'every depth pixel is invalid: check the distance to the body, the depth unit '
            '(32FC1 is metres, 16UC1 millimetres) and the sensor'
        )
    return FusedDepth(fused, len(stack), noise.pixel, noise.grain)


def make_observation(
    name: str,
    setup_index: int,
    fused: FusedDepth,
    camera: PinholeCamera,
    pose: CameraPose,
    sensor: DepthSensor,
) -> Observation:
    """Put together what was seen and from where, without the bias of a sensor that truncates.

    Args:
        name: for reports.
        setup_index: which posture of the scene it shows.
        fused: depth as it came.
        camera: intrinsics of the depth images.
        pose: where the camera was.
        sensor: the depth camera, as these images need it.
    """
    return Observation(
        name=name,
        setup_index=setup_index,
        depth=measured_depth(fused.depth, sensor),
        camera=camera,
        depth_from_world=pose.depth_from_world,
        pose_covariance=pose.covariance,
        pose_pivot=pose.pivot,
        frame_count=fused.frame_count,
        noise=fused.noise,
        grain=fused.grain,
        mirrored=pose.mirrored,
        sensor=sensor,
    )


def measured_depth(depth: NDArray[np.float32], sensor: DepthSensor) -> NDArray[np.float32]:
    """Return what a camera measured of what it tells [m], shape (H, W).

    What it cannot have measured is NaN, and what a sensor that truncates takes off on average is
    put back.
    """
    if sensor.nearest > 0.0 or np.isfinite(sensor.farthest):
        in_range = (depth >= sensor.nearest) & (depth <= sensor.farthest)
        depth = np.where(in_range, depth, np.float32(np.nan))
    if sensor.quantization_mode != 'truncate':
        return depth
    return depth + np.float32(0.5 * sensor.quantization)


def _mean_near_median(samples: NDArray[np.float32], reach: float) -> NDArray[np.float32]:
    """Return the mean of what is no farther from the median than that [m], (frames, pixels)."""
    found = np.empty(samples.shape[1], dtype=np.float32)
    # What is at hand stays in the processor's cache.
    for first in range(0, len(found), _PIXELS_AT_ONCE):
        some = samples[:, first : first + _PIXELS_AT_ONCE]
        middle = np.nanmedian(some, axis=0)
        apart = some - middle
        near = np.abs(apart) <= reach
        # The median of an even number may have none of them near.
        count = np.maximum(np.count_nonzero(near, axis=0), 1)
        mean = middle + np.where(near, apart, 0.0).sum(axis=0) / count
        found[first : first + _PIXELS_AT_ONCE] = mean
    return found
