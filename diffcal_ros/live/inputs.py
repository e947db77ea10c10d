# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a live fit needs to know besides depth: camera, pose and where the colour camera is."""

from dataclasses import dataclass

from diffcal_ros.calibration.camera_pose import CameraPose, pose_from_rig, stored_pose
from diffcal_ros.calibration.frame_times import chosen_frames, frame_times
from diffcal_ros.calibration.motion_frames import observe_motion
from diffcal_ros.calibration.observation import fuse_frames, make_observation, Observation
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.errors import InputError, PoseError, RecordingError
from diffcal_ros.pose.marker_depth import DepthEvidence, marker_distance_check
from diffcal_ros.pose.target import target_of
from diffcal_ros.scene.model import MotionSetup, Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Where a fit takes the camera's pose from: the marker's pose on a topic, checked against the
# depth on the marker; the world's own pose on that topic; or the scene.
POSE_SOURCES = ('estimated', 'topic', 'stored')


@dataclass(frozen=True)
class RigPoseMessage:
    """A pose that arrived.

    Attributes:
        camera_from_rig: of the marker, or of the world, shape (4, 4).
        covariance: as in PoseWithCovariance, shape (6, 6); None where it is taken as exact.
        frame_id: of the camera that saw it.
    """

    camera_from_rig: FloatArray
    covariance: FloatArray | None
    frame_id: str


@dataclass(frozen=True)
class CameraTransform:
    """Where the colour camera is.

    Attributes:
        depth_from_color: shape (4, 4).
        depth_frame: parent frame.
        color_frame: child frame.
    """

    depth_from_color: FloatArray
    depth_frame: str
    color_frame: str


@dataclass(frozen=True)
class Snapshot:
    """Everything that observations of one posture or swing are made from, at one moment.

    Attributes:
        name: for reports.
        setup_index: which posture of the scene it shows.
        frames: depth images, oldest first.
        camera: of the depth images.
        pose: as it arrived; None when the scene's stored pose is used.
        transform: where the colour camera is; None when the pose is the depth camera's own.
        is_marker: the pose is the scene's marker's, not the world's.
    """

    name: str
    setup_index: int
    frames: tuple[DepthFrame, ...]
    camera: PinholeCamera
    pose: RigPoseMessage | None
    transform: CameraTransform | None
    is_marker: bool

    @property
    def newest(self) -> DepthFrame:
        """The newest frame; outputs carry its stamp."""
        return self.frames[-1]

    def frame_of(self, observation: Observation) -> DepthFrame:
        """Return the frame that an observation shows; of a body at rest the newest."""
        if observation.instant is None:
            return self.newest
        at = self.frames[0].stamp_ns + 1e9 * observation.instant.time
        return min(self.frames, key=lambda frame: abs(frame.stamp_ns - at))

    def observe(self, scene: Scene) -> tuple[Observation, ...]:
        """Make observations as the command line does with a recording: one, or one a frame.

        Args:
            scene: says whether the body moves, and then when it is let go after the first frame.

        Raises:
            InputError: when no pixel is valid, the marker's size is wrong, or frames of a motion
                do not show one.
        """
        motion = scene.observations[self.setup_index].motion
        fused = fuse_frames(self.frames if motion is None else self._before(motion))
        pose = self._camera_pose(scene, fused.depth)
        resting = make_observation(
            self.name, self.setup_index, fused, self.camera, pose, scene.sensor
        )
        if motion is None:
            return (resting,)
        times, _ = frame_times([frame.stamp_ns for frame in self.frames])
        chosen = chosen_frames(times, motion)
        read = [self.frames[time.place] for time in chosen]
        return observe_motion(resting, scene.sensor, motion, chosen, read)

    def _before(self, motion: MotionSetup) -> list[DepthFrame]:
        """Return the frames before the earliest release, the first one at least."""
        first = self.frames[0].stamp_ns
        end = first + round(1e9 * motion.release_time.lower)
        return [frame for frame in self.frames if frame.stamp_ns <= max(first, end)]

    def _camera_pose(self, scene: Scene, depth: NDArray[np.float32]) -> CameraPose:
        if self.pose is None:
            return stored_pose(scene.observations[self.setup_index])
        depth_from_color = np.eye(4) if self.transform is None else self.transform.depth_from_color
        world_from_rig = np.eye(4)
        if self.is_marker and scene.marker is not None:
            marker = scene.marker
            check = marker_distance_check(
                self.pose.camera_from_rig,
                target_of(marker),
                DepthEvidence(depth, self.camera, depth_from_color),
            )
            if check is not None:
                check.require()
            world_from_rig = marker.world_from_marker
        return pose_from_rig(
            depth_from_color,
            self.pose.camera_from_rig,
            self.pose.covariance,
            world_from_rig=world_from_rig,
        )


class LiveInputs:
    """Holds the latest of every input but the frames, and says what is missing."""

    def __init__(self, scene: Scene, pose_source: str, observation: str) -> None:
        """Start with what the scene gives.

        Args:
            scene: the set-up.
            pose_source: one of `POSE_SOURCES`.
            observation: which of the scene's postures is in view; empty for the first.

        Raises:
            InputError: when the scene lacks what the pose source needs.
        """
        self.scene = scene
        self.pose_source = pose_source
        self.setup_index = _setup_index(scene, observation)
        if pose_source == 'stored':
            stored_pose(scene.observations[self.setup_index])
        elif pose_source == 'estimated' and scene.marker is None:
            raise PoseError(
                "the scene has no 'marker': add its dictionary, id and side, or set pose_source "
                "to 'topic' (the pose of the world itself) or 'stored'"
            )
        self.camera = scene.depth_camera
        self.pose: RigPoseMessage | None = None
        self.transform: CameraTransform | None = None

    def set_camera(self, camera: PinholeCamera) -> None:
        """Take a camera_info; the scene's own camera goes before it."""
        if self.scene.depth_camera is None:
            self.camera = camera

    def missing(self, frame: DepthFrame | None) -> list[str]:
        """List what has not arrived yet.

        Args:
            frame: the newest depth image.
        """
        needs = []
        if frame is None:
            needs.append('depth/image_rect_raw')
        if self.camera is None:
            needs.append('depth/camera_info')
        if self.pose_source != 'stored':
            if self.pose is None:
                needs.append('marker_pose/pose')
            needs_transform = self.transform is None and not self._is_own_pose(frame)
            if needs_transform:
                needs.append('depth_from_color')
        return needs

    def snapshot(self, frames: tuple[DepthFrame, ...]) -> Snapshot:
        """Freeze what there is.

        Raises:
            InputError: when something is missing, or inputs contradict each other.
        """
        missing = self.missing(frames[-1] if frames else None)
        if missing or self.camera is None:
            raise InputError(f'nothing has arrived yet on {", ".join(missing)}')
        frame = frames[-1]
        self._check_size(frame, self.camera)
        stored = self.pose_source == 'stored'
        is_own = self._is_own_pose(frame)
        if not stored and not is_own and self.pose is not None and self.transform is not None:
            _check_frames(frame, self.pose, self.transform)
        return Snapshot(
            name=self.scene.observations[self.setup_index].name,
            setup_index=self.setup_index,
            frames=frames,
            camera=self.camera,
            pose=None if stored else self.pose,
            transform=None if stored or is_own else self.transform,
            is_marker=self.pose_source == 'estimated',
        )

    def _is_own_pose(self, frame: DepthFrame | None) -> bool:
        """Tell whether the pose is given in the depth camera's own frame."""
        if self.pose is None or frame is None:
            return False
        return bool(frame.frame_id) and self.pose.frame_id == frame.frame_id

    def _check_size(self, frame: DepthFrame, camera: PinholeCamera) -> None:
        rows, columns = frame.depth.shape
        if (columns, rows) != (camera.width, camera.height):
            source = "the scene's camera" if self.scene.depth_camera else 'depth/camera_info'
            raise RecordingError(
                f'{source} is for {camera.width}x{camera.height} pixels, but the depth images are '
                f'{columns}x{rows}: give the camera_info that belongs to the depth topic'
            )


def _check_frames(frame: DepthFrame, pose: RigPoseMessage, transform: CameraTransform) -> None:
    """Refuse a transform between other frames than those of the images."""
    pairs = (
        ('the depth images are', frame.frame_id, 'to', transform.depth_frame),
        ('the pose is', pose.frame_id, 'from', transform.color_frame),
    )
    for what, given, direction, expected in pairs:
        if given and expected and given != expected:
            raise InputError(
                f'{what} in the frame {given!r}, but depth_from_color leads {direction} '
                f'{expected!r}: publish the transform between the two cameras in use'
            )


def _setup_index(scene: Scene, name: str) -> int:
    names = [setup.name for setup in scene.observations]
    if not name:
        return 0
    if name not in names:
        raise InputError(
            f'observation is {name!r}: the scene has {", ".join(names)}; choose one of them'
        )
    return names.index(name)
