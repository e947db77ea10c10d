# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Follow the marker's pose from frame to frame, and say what is wrong when there is none."""

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.errors import PoseError
from diffcal_ros.live.health import Health, Level
from diffcal_ros.pose.detection import CornerRefinement, Detection
from diffcal_ros.pose.detectors import make_detector
from diffcal_ros.pose.marker_depth import DepthEvidence
from diffcal_ros.pose.rig_pose import RigPose
from diffcal_ros.pose.running_pose import RunningPose
from diffcal_ros.pose.target import Target
import numpy as np
from numpy.typing import NDArray

_JUMP = 100_000_000  # [ns]


class MarkerTracker:
    """Fuses colour frames into one pose; starts anew when stamps jump back."""

    def __init__(self, target: Target, *, window: int, refinement: CornerRefinement) -> None:
        """Start without camera and frames.

        Args:
            target: what is looked for.
            window: frames that are fused.
            refinement: how corners are located.
        """
        self.target = target
        self.problem: str | None = None
        self._window = window
        self._refinement = refinement
        self._running: RunningPose | None = None
        self._has_depth = False
        self._stamp_ns = 0
        self._seen_count = 0
        self._frame_count = 0

    @property
    def pose(self) -> RigPose | None:
        """The pose so far; None before the marker was seen, or when its size is wrong."""
        pose = None if self._running is None else self._running.pose
        return None if pose is None or _size_problem(pose) else pose

    @property
    def detection(self) -> Detection | None:
        """What the last frame shows."""
        return None if self._running is None else self._running.detection

    def set_camera(self, camera: PinholeCamera) -> None:
        """Take the colour camera's intrinsics; other ones start anew."""
        if self._running is None or self._running.detector.camera != camera:
            detector = make_detector(self.target, camera, self._refinement)
            self._running = RunningPose(detector, window=self._window)

    def add(
        self, image: NDArray[np.uint8], stamp_ns: int, depth: DepthEvidence | None = None
    ) -> RigPose | None:
        """Take a colour image.

        Args:
            image: BGR, shape (H, W, 3).
            stamp_ns: of the image [ns].
            depth: a depth image of about the same time, or None.

        Returns:
            The pose, when this image shows the marker.
        """
        if self._running is None:
            return None
        if stamp_ns < self._stamp_ns - _JUMP:
            self._running.reset()
            self._seen_count = self._frame_count = 0
        self._stamp_ns = stamp_ns
        self._has_depth = depth is not None
        try:
            self._running.add(image, depth=depth)
        except PoseError as error:
            self.problem = str(error)
            return None
        self.problem = self._running.problem
        self._frame_count += 1
        self._seen_count += self.problem is None
        return self.pose if self.problem is None else None

    def health(self) -> Health:
        """Return how the pose stands."""
        pose = None if self._running is None else self._running.pose
        values = {
            'frames': str(self._frame_count),
            'frames with the marker': str(self._seen_count),
            'depth is used': str(self._has_depth).lower(),
        }
        if self._running is None:
            return Health(Level.WARN, 'waiting for color/camera_info', values)
        if pose is None:
            if self.problem is not None:
                return Health(Level.ERROR, self.problem, values)
            return Health(Level.WARN, 'waiting for color/image_raw', values)
        values.update(_figures(pose))
        size_problem = _size_problem(pose)
        if size_problem is not None:
            return Health(Level.ERROR, size_problem, values)
        if self.problem is not None:
            return Health(Level.WARN, f'the last frame did not help: {self.problem}', values)
        if not pose.is_settled:
            return Health(
                Level.WARN,
                'the marker is seen so flatly that its pose may be the mirrored one: turn the '
                'camera or use a larger marker',
                values,
            )
        return Health(Level.OK, f'pose from {pose.frame_count} frames', values)


def _size_problem(pose: RigPose) -> str | None:
    return None if pose.distance_check is None else pose.distance_check.problem


def _figures(pose: RigPose) -> dict[str, str]:
    spread = np.sqrt(np.diag(pose.covariance))
    distance = float(np.linalg.norm(pose.camera_from_marker[:3, 3]))
    return {
        'distance [mm]': f'{1e3 * distance:.1f}',
        'position error [mm]': f'{1e3 * float(np.linalg.norm(spread[:3])):.2f}',
        'turn error [deg]': f'{np.degrees(float(np.linalg.norm(spread[3:]))):.2f}',
        'reprojection error [px]': f'{pose.reprojection_error:.2f}',
        'outlier frames': str(pose.outlier_count),
        'error ratio of the mirrored pose': f'{pose.error_ratio:.2f}',
    }
