# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The rig's pose while frames arrive one by one."""

from collections import deque

from diffcal_ros.errors import PoseError
from diffcal_ros.pose.detection import Detection, Detector
from diffcal_ros.pose.marker_depth import DepthEvidence
from diffcal_ros.pose.nothing_seen import why_nothing_seen
from diffcal_ros.pose.rig_pose import estimate_rig_pose, RigPose
import numpy as np
from numpy.typing import NDArray

# So many frames in a row that contradict the pose mean that camera or rig moved.
_MOVED_AFTER = 5


class RunningPose:
    """Fuses the latest frames; what it keeps is bounded by the window."""

    def __init__(self, detector: Detector, *, window: int = 30) -> None:
        """Start without any frame.

        Args:
            detector: for the target and the camera.
            window: frames with a marker that are fused.
        """
        if window < 1:
            raise PoseError(f'pose window is {window} frames: at least one is needed')
        self.detector = detector
        self.pose: RigPose | None = None
        self.detection: Detection | None = None
        self.problem: str | None = None
        self._seen: deque[Detection] = deque(maxlen=window)

    def reset(self) -> None:
        """Forget all frames."""
        self.pose = None
        self.detection = None
        self.problem = None
        self._seen.clear()

    def add(
        self, image: NDArray[np.uint8], *, depth: DepthEvidence | None = None
    ) -> RigPose | None:
        """Take one more frame.

        `detection` then holds what this frame shows, and `problem` why it did not help, or None.

        Args:
            image: BGR, shape (H, W, 3), or grey, shape (H, W).
            depth: a depth image of the same moment, or None.

        Returns:
            The pose from the frames so far, or None before a marker was seen.

        Raises:
            PoseError: when the image has another size than the camera.
        """
        self.detection = self.detector.detect(image)
        if not self.detection.corners:
            self.problem = why_nothing_seen([self.detection], self.detector.target)
            return self.pose
        self.problem = None
        self._seen.append(self.detection)
        self.pose = self._fused(list(self._seen), depth)
        latest = self.pose.supports[-_MOVED_AFTER:]
        if len(latest) == _MOVED_AFTER and not any(latest):
            kept = list(self._seen)[-_MOVED_AFTER:]
            self._seen.clear()
            self._seen.extend(kept)
            self.pose = self._fused(kept, depth)
        return self.pose

    def _fused(self, detections: list[Detection], depth: DepthEvidence | None) -> RigPose:
        return estimate_rig_pose(
            detections, self.detector.target, self.detector.camera, depth=depth
        )
