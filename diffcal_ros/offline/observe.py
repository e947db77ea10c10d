# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Make observations of a recording."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from diffcal_ros.calibration.observations.camera_pose import CameraPose, pose_from_rig
from diffcal_ros.calibration.observations.observation import MAX_FUSED_FRAMES
from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.errors import PoseError
from diffcal_ros.observing.observe import observe_film, Take
from diffcal_ros.observing.pose_sources import (
    ESTIMATED,
    FIXTURE,
    from_fixture,
    from_scene,
    from_tf,
    from_topic,
    PoseSource,
    required_marker,
    Sight,
    source_in_force,
    world_frame_of,
)
from diffcal_ros.pose.detectors import make_detector
from diffcal_ros.pose.marker_depth import DepthEvidence, marker_distance_check
from diffcal_ros.pose.rig_pose import pose_from_images
from diffcal_ros.pose.target import target_of
from diffcal_ros.recording.recording import Recording
from diffcal_ros.recording.topics.pose_topics import read_poses
from diffcal_ros.recording.topics.recorded_frames import read_frames
from diffcal_ros.scene.model import Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_MAX_COLOR_FRAMES = 60


@dataclass(frozen=True)
class _RecordedFilm:
    """The depth images of a recording."""

    recording: Recording

    @property
    def topic(self) -> str:
        return self.recording.depth_topic

    def overview(self) -> Sequence[DepthFrame]:
        return list(self.recording.depth_frames(limit=MAX_FUSED_FRAMES))

    def stamps(self) -> list[int | None]:
        return self.recording.depth_stamps()

    def frames_at(self, indices: Sequence[int]) -> Iterable[DepthFrame | None]:
        return self.recording.depth_frames_at(indices)


def observe(
    scene: Scene, setup_index: int, recording: Recording, *, pose_source: str | None = None
) -> Take:
    """Turn a recording into observations: one of a body at rest, one a frame of a motion.

    Args:
        scene: the set-up.
        setup_index: which posture of the scene the recording shows.
        recording: opened.
        pose_source: one of `ASKED_SOURCES`; None: as the scene says.

    Returns:
        The observations, and notes for a person.

    Raises:
        InputError: when there is no depth, no pose, or no motion to be seen.
    """
    setup = scene.observations[setup_index]
    take = observe_film(
        scene,
        setup_index,
        _RecordedFilm(recording),
        _source(scene, setup_index, recording, pose_source),
        name=setup.name if len(scene.observations) > 1 else _label(recording.path),
        camera=scene.depth_camera or recording.depth_camera,
    )
    return Take(take.observations, (*recording.notes, *recording.left_out, *take.notes))


def _label(path: Path) -> str:
    """Name a recording: a folder called bag says less than the folder it lies in."""
    resolved = path.resolve()
    return resolved.parent.name if resolved.name == 'bag' else resolved.stem


def _source(scene: Scene, setup_index: int, recording: Recording, asked: str | None) -> PoseSource:
    """Bind the source of the pose to the recording."""
    setup = scene.observations[setup_index]
    source = source_in_force(setup, asked)
    if source == ESTIMATED:
        return lambda sight: _estimated_pose(scene, recording, sight)
    if source == 'stored':
        return from_scene(setup)
    if source == FIXTURE:
        return from_fixture(scene, setup)
    # Long recordings carry much TF: it is read once, and only where it is asked.
    frames = cache(lambda: read_frames(recording.messages, recording.leave_out))

    def lookup(target: str, source: str, stamp_ns: int) -> FloatArray | None:
        return frames().find(target, source, stamp_ns)

    if source == 'tf':
        world_frame_of(setup.pose)
        return from_tf(setup.pose, lookup)
    topic, messages = read_poses(recording.messages, setup.pose.topic, recording.leave_out)
    return from_topic(setup.pose, topic, messages, lookup)


def _estimated_pose(scene: Scene, recording: Recording, sight: Sight) -> CameraPose:
    marker = required_marker(scene)
    is_given = recording.is_color_camera_given or scene.color_camera is None
    color_camera = recording.color_camera if is_given else scene.color_camera
    if recording.color_topic is not None and color_camera is None:
        raise PoseError(
            f'{recording.path}: the marker cannot be looked for in {recording.color_topic}, '
            f'{recording.color_problem}'
        )
    if recording.color_topic is None or color_camera is None:
        raise PoseError(
            f'{recording.path} has no colour images with a camera_info to find the marker in: '
            "record them too, or give 'stored_depth_from_world' in the scene and --pose stored"
        )
    depth_from_color = recording.depth_from_color
    if depth_from_color is None:
        raise PoseError(
            f'{recording.path} does not say where the colour camera is: record /tf_static or the '
            'topic depth_from_color, or use --pose stored'
        )
    target = target_of(marker)
    detector = make_detector(target, color_camera)
    evidence = DepthEvidence(sight.depth, sight.camera, depth_from_color)
    images = (frame.image for frame in recording.color_frames(limit=_MAX_COLOR_FRAMES))
    rig = pose_from_images(images, detector, depth=evidence)
    check = marker_distance_check(rig.camera_from_marker, target, evidence, rig.seen_ids)
    if check is not None:
        check.require()
    notes = [f'pose of the marker from {rig.frame_count} colour frames']
    if not rig.is_settled:
        notes.append(
            'the marker is seen so flatly that its pose may be the mirrored one (the errors '
            f'differ by a factor {rig.error_ratio:.2f}): the body itself decides between the two; '
            'turn the camera or use a larger marker'
        )
    return pose_from_rig(
        depth_from_color,
        rig.camera_from_marker,
        rig.covariance,
        world_from_rig=marker.world_from_marker,
        notes=tuple(notes),
        mirrored=None if rig.is_settled else rig.other_camera_from_marker,
    )
