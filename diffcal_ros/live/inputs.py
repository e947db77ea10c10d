# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a live fit needs to know besides depth: camera, pose and where the colour camera is."""

from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from diffcal_ros.calibration.observations.camera_pose import stored_pose
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.errors import InputError, RecordingError
from diffcal_ros.observing.observe import observe_film, Take
from diffcal_ros.observing.pose_sources import (
    ASKED_SOURCES,
    ESTIMATED,
    FIXTURE,
    from_fixture,
    from_scene,
    from_seen_marker,
    from_tf,
    from_topic,
    is_in_world,
    is_same_frame,
    Lookup,
    PoseSource,
    required_marker,
    source_in_force,
    world_frame_of,
)
from diffcal_ros.scene.model import MotionSetup, Scene
from diffcal_ros.scene.observation_choice import observation_index
from diffcal_ros.stamped_pose import StampedPose
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Where a fit takes the camera's pose from: what the scene says, or the marker's pose on a topic,
# checked against the depth on the marker; another pose on a topic; TF; or the scene.
SCENE = 'scene'
POSE_SOURCES = (SCENE, *ASKED_SOURCES)
POSE_TOPIC, SEEN_TOPIC, TRANSFORM_TOPIC, DEPTH_TOPIC = (
    'marker_pose/pose',
    'marker_pose/seen',
    'depth_from_color',
    'depth/image_rect_raw',
)
# Poses that are kept, to find that of each frame.
_REMEMBERED = 1000


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
class _LiveFilm:
    """Depth images that arrived.

    Attributes:
        frames: oldest first.
        motion: of the body; None: it is at rest.
    """

    frames: tuple[DepthFrame, ...]
    motion: MotionSetup | None

    @property
    def topic(self) -> str:
        return DEPTH_TOPIC

    def overview(self) -> Sequence[DepthFrame]:
        """Return all, or of a motion those before the earliest release, the first one at least."""
        if self.motion is None:
            return self.frames
        first = self.frames[0].stamp_ns
        end = first + round(1e9 * self.motion.release_time.lower)
        return [frame for frame in self.frames if frame.stamp_ns <= max(first, end)]

    def stamps(self) -> list[int | None]:
        return [frame.stamp_ns for frame in self.frames]

    def frames_at(self, indices: Sequence[int]) -> Iterable[DepthFrame | None]:
        return [self.frames[index] for index in indices]


@dataclass(frozen=True)
class Snapshot:
    """Everything that observations of one posture or swing are made from, at one moment.

    Attributes:
        name: for reports.
        setup_index: which posture of the scene it shows.
        frames: depth images, oldest first.
        camera: of the depth images.
        find_pose: says where the camera was.
    """

    name: str
    setup_index: int
    frames: tuple[DepthFrame, ...]
    camera: PinholeCamera
    find_pose: PoseSource

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
        """Return the observations of `take`."""
        return self.take(scene).observations

    def take(self, scene: Scene) -> Take:
        """Make observations as the command line does with a recording: one, or one a frame.

        Args:
            scene: says whether the body moves, and then when it is let go after the first frame.

        Raises:
            InputError: when no pixel is valid, the marker's size or the unit of depth is wrong,
                the camera moves, or frames of a motion do not show one.
        """
        return observe_film(
            scene,
            self.setup_index,
            _LiveFilm(self.frames, scene.observations[self.setup_index].motion),
            self.find_pose,
            name=self.name,
            camera=self.camera,
        )


class LiveInputs:
    """Holds the latest of every input but the frames, and says what is missing.

    Attributes:
        scene: the set-up.
        source: where the pose comes from, one of `ASKED_SOURCES`.
        setup_index: which of the scene's postures is in view.
        camera: of the depth images, or None.
        transform: where the colour camera is, or None.
        lookup: asks TF; None where there is none.
        seen_ids: parts of the marker or board that its pose rests on; None where nobody says.
    """

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
        self.setup_index = observation_index(scene, observation)
        self._setup = scene.observations[self.setup_index]
        asked = None if pose_source == SCENE else pose_source
        self.source = source_in_force(self._setup, asked)
        self._fixture: PoseSource | None = None
        if self.source == 'stored':
            stored_pose(self._setup)
        elif self.source == 'tf':
            world_frame_of(self._setup.pose)
        elif self.source == FIXTURE:
            # Kept: it is found again faster where it was.
            self._fixture = from_fixture(scene, self._setup)
        elif self.source == ESTIMATED:
            required_marker(
                scene,
                "set pose_source to 'topic' (a pose of the world or of the camera), 'tf' or "
                "'stored'",
            )
        self.camera = scene.depth_camera
        self.transform: CameraTransform | None = None
        self.lookup: Lookup | None = None
        self.seen_ids: tuple[int, ...] | None = None
        self._poses: deque[StampedPose] = deque(maxlen=_REMEMBERED)

    @property
    def pose(self) -> StampedPose | None:
        """The newest pose on the topic, or None."""
        return self._poses[-1] if self._poses else None

    @pose.setter
    def pose(self, pose: StampedPose) -> None:
        self._poses.append(pose)

    @property
    def pose_topic(self) -> str:
        """Where poses come from: for a pose that is no marker's the scene may name it."""
        return (self._setup.pose.topic if self.source == 'topic' else '') or POSE_TOPIC

    @property
    def world_frame(self) -> str:
        """TF's name of the scene's world; empty where the scene has none."""
        return self._setup.pose.world_frame

    def set_camera(self, camera: PinholeCamera) -> None:
        """Take a camera_info; the scene's own camera goes before it."""
        if self.scene.depth_camera is None:
            self.camera = camera

    def take_over(self, other: 'LiveInputs') -> None:
        """Go on with what arrived for other inputs; poses only from the same topic."""
        self.transform, self.lookup = other.transform, other.lookup
        self.seen_ids = other.seen_ids
        if other.pose_topic == self.pose_topic:
            self._poses.extend(other._poses)

    def missing(self, frame: DepthFrame | None) -> list[str]:
        """List what has not arrived yet.

        Args:
            frame: the newest depth image.
        """
        needs = []
        if frame is None:
            needs.append(DEPTH_TOPIC)
        if self.camera is None:
            needs.append('depth/camera_info')
        if self.source == 'tf' and frame is not None and not self._is_in_tf(frame):
            needs.append(
                f'TF from {self._setup.pose.world_frame!r} to {frame.frame_id!r}, the frame of '
                'the depth images'
            )
        if self.source in (ESTIMATED, 'topic'):
            if self.pose is None:
                needs.append(self.pose_topic)
            if self._transform_to(frame) is None and not self._is_in_world:
                needs.append(self._needed_transform(frame))
        return needs

    def _needed_transform(self, frame: DepthFrame | None) -> str:
        if self.pose is None or frame is None:
            return TRANSFORM_TOPIC
        cure = transform_cure(self.pose.frame_id, frame.frame_id, has_tf=self.lookup is not None)
        return f'{TRANSFORM_TOPIC}: {cure}'

    def snapshot(self, frames: tuple[DepthFrame, ...]) -> Snapshot:
        """Freeze what there is.

        Raises:
            InputError: when something is missing, or inputs contradict each other.
        """
        missing = self.missing(frames[-1] if frames else None)
        if missing or self.camera is None:
            raise InputError(f'nothing has arrived yet on {", ".join(missing)}')
        self._check_size(frames[-1], self.camera)
        return Snapshot(
            name=self._setup.name,
            setup_index=self.setup_index,
            frames=frames,
            camera=self.camera,
            find_pose=self._pose_source(frames),
        )

    def _pose_source(self, frames: tuple[DepthFrame, ...]) -> PoseSource:
        """Bind the source of the pose to what has arrived by now."""
        newest, pose = frames[-1], self.pose
        if self.source == 'stored':
            return from_scene(self._setup)
        if self.source == FIXTURE:
            assert self._fixture is not None
            return self._fixture
        if self.source == 'tf':
            assert self.lookup is not None
            world = self._setup.pose.world_frame
            return from_tf(self._setup.pose, _frozen(self.lookup, frames, world))
        assert pose is not None
        self._check_transform(newest, pose)
        if self.source == ESTIMATED:
            depth_from_color = self._transform_to(newest)
            assert depth_from_color is not None
            seen = replace(pose, seen_ids=self.seen_ids)
            return from_seen_marker(self.scene, self._setup, seen, depth_from_color)
        known = {frame.stamp_ns: self._transform_to(frame) for frame in frames}

        def lookup(target: str, source: str, stamp_ns: int) -> FloatArray | None:
            return known[stamp_ns] if source == pose.frame_id else None

        return from_topic(self._setup.pose, self.pose_topic, tuple(self._poses), lookup)

    @property
    def _is_in_world(self) -> bool:
        """Tell whether the pose is the depth camera's own, in the world."""
        if self.source != 'topic' or self.pose is None:
            return False
        return is_in_world(self.pose, self._setup.pose)

    def _transform_to(self, frame: DepthFrame | None) -> FloatArray | None:
        """Return what leads from the pose's frame to the depth images', or None."""
        own = None if self.transform is None else self.transform.depth_from_color
        pose = self.pose
        if pose is None or frame is None:
            return own
        if is_same_frame(pose.frame_id, frame.frame_id):
            return np.eye(4)
        if own is not None or self.source != 'topic' or self.lookup is None:
            return own
        return self.lookup(frame.frame_id, pose.frame_id, frame.stamp_ns)

    def _check_transform(self, newest: DepthFrame, pose: StampedPose) -> None:
        """Refuse a transform that does not lead from the pose to the depth images."""
        is_own = is_same_frame(pose.frame_id, newest.frame_id)
        if self.transform is not None and not is_own and not self._is_in_world:
            _check_frames(newest, pose, self.transform)

    def _is_in_tf(self, frame: DepthFrame) -> bool:
        if self.lookup is None:
            return False
        world = self._setup.pose.world_frame
        return self.lookup(frame.frame_id, world, frame.stamp_ns) is not None

    def _check_size(self, frame: DepthFrame, camera: PinholeCamera) -> None:
        rows, columns = frame.depth.shape
        if (columns, rows) != (camera.width, camera.height):
            source = "the scene's camera" if self.scene.depth_camera else 'depth/camera_info'
            raise RecordingError(
                f'{source} is for {camera.width}x{camera.height} pixels, but the depth images are '
                f'{columns}x{rows}: give the camera_info that belongs to the depth topic'
            )


def transform_cure(color_frame: str, depth_frame: str, *, has_tf: bool) -> str:
    """Say which transform is missing, and who may give it.

    Args:
        color_frame: where the pose is given; empty where nobody says.
        depth_frame: of the depth images.
        has_tf: TF is listened to.
    """
    if not color_frame or not depth_frame:
        return (
            f'the pose is in the frame {color_frame!r} and the depth images in {depth_frame!r}: '
            'let their publishers fill frame_id'
        )
    with_tf = '' if has_tf else ' (install ros-jazzy-tf2-ros first: without it TF is not heard)'
    return (
        f'where the frame {color_frame!r} is in {depth_frame!r}: let the camera driver publish it '
        f'on /tf_static{with_tf}, or set the parameter depth_from_color of the depth source'
    )


def _frozen(lookup: Lookup, frames: tuple[DepthFrame, ...], world_frame: str) -> Lookup:
    """Ask TF for all frames now: it forgets, and a fit is made later."""
    known = {
        frame.stamp_ns: lookup(frame.frame_id, world_frame, frame.stamp_ns) for frame in frames
    }
    return lambda target, source, stamp_ns: known.get(stamp_ns)


def _check_frames(frame: DepthFrame, pose: StampedPose, transform: CameraTransform) -> None:
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
