# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Make observations of a recording: depth, fused or frame by frame, and where the camera was."""

from pathlib import Path

from diffcal_ros.calibration.camera_pose import CameraPose, pose_from_rig, stored_pose
from diffcal_ros.calibration.frame_times import chosen_frames, frame_times
from diffcal_ros.calibration.motion_frames import observe_motion
from diffcal_ros.calibration.observation import (
    fuse_frames,
    FusedDepth,
    make_observation,
    MAX_FUSED_FRAMES,
    Observation,
)
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.errors import PoseError, RecordingError
from diffcal_ros.marker import Marker
from diffcal_ros.pose.detectors import make_detector
from diffcal_ros.pose.marker_depth import DepthEvidence, marker_distance_check
from diffcal_ros.pose.rig_pose import pose_from_images
from diffcal_ros.pose.target import target_of
from diffcal_ros.recording.recording import Recording
from diffcal_ros.scene.model import MotionSetup, Scene
import numpy as np

POSE_SOURCES = ('estimated', 'stored')
_MAX_COLOR_FRAMES = 60
# No depth camera sees a soft body from farther than this [m].
_FARTHEST = 50.0


def observe(
    scene: Scene, setup_index: int, recording: Recording, *, pose_source: str = 'estimated'
) -> tuple[tuple[Observation, ...], tuple[str, ...]]:
    """Turn a recording into observations: one of a body at rest, one a frame of a motion.

    Args:
        scene: the set-up.
        setup_index: which posture of the scene the recording shows.
        recording: opened.
        pose_source: `estimated` from the marker, or `stored` in the scene.

    Returns:
        The observations, and notes for a person.

    Raises:
        InputError: when there is no depth, no marker, no stored pose, or no motion to be seen.
    """
    camera = scene.depth_camera or recording.depth_camera
    fused = fuse_frames(recording.depth_frames(limit=MAX_FUSED_FRAMES))
    if fused.depth.shape != (camera.height, camera.width):
        rows, columns = fused.depth.shape
        raise RecordingError(
            f"the scene's camera is {camera.width}x{camera.height} but {recording.path} holds "
            f'{columns}x{rows} images: correct the camera in the scene, or leave it out to use '
            'camera_info'
        )
    _check_unit(fused, recording)
    if pose_source == 'stored':
        pose = stored_pose(scene.observations[setup_index])
    else:
        pose = _estimated_pose(scene, recording, fused, camera)
    setup = scene.observations[setup_index]
    name = setup.name if len(scene.observations) > 1 else _label(recording.path)
    resting = make_observation(name, setup_index, fused, camera, pose, scene.sensor)
    observations: tuple[Observation, ...] = (resting,)
    moving_notes: tuple[str, ...] = ()
    if setup.motion is not None:
        observations, moving_notes = _instants(resting, scene, setup.motion, recording)
    skipped = tuple(
        f'{count} frames left out: {reason}' for reason, count in recording.skipped.items()
    )
    return observations, (*recording.notes, *skipped, *moving_notes, *pose.notes)


def _instants(
    resting: Observation, scene: Scene, motion: MotionSetup, recording: Recording
) -> tuple[tuple[Observation, ...], tuple[str, ...]]:
    times, notes = frame_times(recording.depth_stamps(), is_slow=motion.is_slow)
    chosen = chosen_frames(times, motion)
    read = list(recording.depth_frames_at([frame.place for frame in chosen]))
    return observe_motion(resting, scene.sensor, motion, chosen, read), tuple(notes)


def _check_unit(fused: FusedDepth, recording: Recording) -> None:
    """Refuse millimetres that were published as if they were metres."""
    middle = float(np.nanmedian(fused.depth))
    if middle > _FARTHEST:
        raise RecordingError(
            f'{recording.depth_topic} holds depths of {middle:.4g} m in the middle: 32FC1 is in '
            'metres, so publish millimetres as 16UC1, or divide them by 1000'
        )


def _label(path: Path) -> str:
    """Name a recording: a folder called bag says less than the folder it lies in."""
    resolved = path.resolve()
    return resolved.parent.name if resolved.name == 'bag' else resolved.stem


def _estimated_pose(
    scene: Scene, recording: Recording, fused: FusedDepth, camera: PinholeCamera
) -> CameraPose:
    marker = _required_marker(scene)
    color_camera = scene.color_camera or recording.color_camera
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
    evidence = DepthEvidence(fused.depth, camera, depth_from_color)
    images = (frame.image for frame in recording.color_frames(limit=_MAX_COLOR_FRAMES))
    rig = pose_from_images(images, detector, depth=evidence)
    check = marker_distance_check(rig.camera_from_marker, target, evidence, rig.seen_ids)
    if check is not None:
        check.require()
    notes = [f'pose of the marker from {rig.frame_count} colour frames']
    if not rig.is_settled:
        notes.append(
            'the marker is seen so flatly that its pose may be the mirrored one (the errors '
            f'differ by a factor {rig.error_ratio:.2f}): turn the camera or use a larger marker'
        )
    return pose_from_rig(
        depth_from_color,
        rig.camera_from_marker,
        rig.covariance,
        world_from_rig=marker.world_from_marker,
        notes=tuple(notes),
    )


def _required_marker(scene: Scene) -> Marker:
    if scene.marker is None:
        raise PoseError(
            "the scene has no 'marker': add its dictionary, id and side, or use --pose stored"
        )
    return scene.marker
