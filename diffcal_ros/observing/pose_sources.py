# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where the camera's pose comes from: the scene, TF, a topic, or a marker that was seen.

A source is a function from a `Sight` to a `CameraPose`; what it reads, a bag or what has arrived,
is bound to it beforehand.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from diffcal_ros.calibration.observations.camera_pose import (
    CameraPose,
    pose_from_rig,
    pose_in_world,
    stated_pose,
    steady_pose,
    stored_pose,
)
from diffcal_ros.calibration.observations.observation import measured_depth
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.errors import PoseError
from diffcal_ros.marker import Marker
from diffcal_ros.pose.marker_depth import DepthEvidence, marker_distance_check
from diffcal_ros.pose.target import target_of
from diffcal_ros.registration.held_body import BodyAtRest
from diffcal_ros.registration.register import register_part, RegisteredPart
from diffcal_ros.rigid_transform import inverse
from diffcal_ros.scene.model import Fixture, ObservationSetup, PoseSetup, Scene
from diffcal_ros.stamped_pose import StampedPose
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# What may be asked for in place of what the scene says; `estimated` is from the scene's marker.
ESTIMATED = 'estimated'
FIXTURE = 'fixture'
ASKED_SOURCES = (ESTIMATED, 'stored', 'tf', 'topic', FIXTURE)
# A pose so long before or after a frame is told [ns].
_LATE = 1_000_000_000


@dataclass(frozen=True)
class Sight:
    """What a pose is wanted for.

    Attributes:
        depth: fused, z [m], shape (H, W); NaN where invalid.
        camera: intrinsics of the depth images.
        frame_id: optical frame of the depth images; may be empty.
        stamps_ns: of the frames [ns], at least one.
    """

    depth: NDArray[np.float32]
    camera: PinholeCamera
    frame_id: str
    stamps_ns: tuple[int, ...]


PoseSource = Callable[[Sight], CameraPose]
# (target, source, stamp [ns]) to target_from_source, shape (4, 4), or None where it is not known.
Lookup = Callable[[str, str, int], FloatArray | None]


def source_in_force(setup: ObservationSetup, asked: str | None) -> str:
    """Return which of `ASKED_SOURCES` gives the pose: what was asked for, or the scene says.

    Args:
        setup: of the scene.
        asked: one of `ASKED_SOURCES`; None: what the scene says, or else from the marker.
    """
    if asked is not None:
        return asked
    return setup.pose.source if setup.pose.source not in ('', 'marker') else ESTIMATED


def from_scene(setup: ObservationSetup) -> PoseSource:
    """Take the pose that the scene stores."""
    return lambda sight: stored_pose(setup)


def from_fixture(scene: Scene, setup: ObservationSetup) -> PoseSource:
    """Take the pose that puts the scene's fixture where the depth image shows it.

    The fixture goes where the observation places the body; gravity is the scene's. Asked again, it
    first looks where the fixture was.

    Raises:
        PoseError: when the scene has no fixture.
    """
    fixture = required_fixture(scene)
    placed = setup.world_from_object
    body = body_at_rest(scene, placed[:3, :3].T @ setup.gravity)
    known: list[RegisteredPart] = []

    def find(sight: Sight) -> CameraPose:
        found = register_part(
            fixture,
            measured_depth(sight.depth, scene.sensor),
            sight.camera,
            body=body,
            masks=scene.masks,
            noise=scene.sensor.noise,
            known=known[0] if known else None,
        )
        known[:] = [found]
        return CameraPose(
            found.depth_from_object @ inverse(placed),
            covariance=found.covariance,
            pivot=found.pivot,
            notes=found.notes,
        )

    return find


def body_at_rest(scene: Scene, gravity: FloatArray | None) -> BodyAtRest:
    """Return the surface of the scene's body.

    Args:
        scene: with a mesh.
        gravity: its direction in the object frame, shape (3,), or None.
    """
    triangles = scene.mesh.surface_triangles
    used, numbers = np.unique(triangles, return_inverse=True)
    corners = np.asarray(numbers, dtype=np.int32).reshape(-1, 3)
    return BodyAtRest(scene.mesh.rest_positions[used], corners, gravity)


def required_fixture(scene: Scene) -> Fixture:
    """Return the scene's fixture.

    Raises:
        PoseError: when it has none.
    """
    if scene.fixture is None:
        raise PoseError(
            "the scene has no 'fixture' to find in the depth images: add its box or file in the "
            "mesh's frame, or take the camera's pose from elsewhere, see `pose`"
        )
    return scene.fixture


def from_tf(pose: PoseSetup, lookup: Lookup) -> PoseSource:
    """Take the chain from the scene's world frame to the frame of the depth images."""

    def find(sight: Sight) -> CameraPose:
        world = world_frame_of(pose)
        if not sight.frame_id:
            raise PoseError(
                'the depth images name no frame, so that TF cannot tell where it is: let the '
                "driver fill frame_id, or store the pose in the scene and use 'stored'"
            )
        poses = []
        for stamp_ns in sight.stamps_ns:
            found = lookup(sight.frame_id, world, stamp_ns)
            if found is None:
                raise PoseError(
                    f"TF does not lead from {world!r}, the scene's world_frame, to "
                    f'{sight.frame_id!r}, the frame of the depth images: record /tf and '
                    "/tf_static, or correct 'world_frame' under 'pose' in the scene"
                )
            poses.append(stated_pose(found, pose, 'the pose from TF'))
        return steady_pose(poses)

    return find


def world_frame_of(pose: PoseSetup) -> str:
    """Return TF's name of the scene's world.

    Raises:
        PoseError: when the scene does not give it.
    """
    if not pose.world_frame:
        raise PoseError(
            "the scene does not say which frame of TF its world is: add 'world_frame' under 'pose'"
        )
    return pose.world_frame


def from_topic(
    pose: PoseSetup, topic: str, messages: Sequence[StampedPose], lookup: Lookup
) -> PoseSource:
    """Take a pose from a topic, at each frame the message nearest in time.

    The header says whose pose it is. In the scene's `world_frame` it is the depth camera's (its
    optical frame's); in any other frame it is the world's, and a chain must lead from there to
    the depth images, such as that from the colour camera.

    Args:
        pose: how well it is known where no covariance comes with it.
        topic: its name, for messages.
        messages: what came on it, at least one.
        lookup: finds that chain.
    """

    def find(sight: Sight) -> CameraPose:
        nearest = [
            min(messages, key=lambda message: abs(message.stamp_ns - stamp_ns))
            for stamp_ns in sight.stamps_ns
        ]
        late = max(
            abs(message.stamp_ns - stamp_ns)
            for message, stamp_ns in zip(nearest, sight.stamps_ns, strict=True)
        )
        found = steady_pose(
            [
                _from_message(pose, topic, message, sight, stamp_ns, lookup)
                for message, stamp_ns in zip(nearest, sight.stamps_ns, strict=True)
            ]
        )
        # One that never changes is sent once, and often without a time.
        if len(messages) == 1 or late <= _LATE:
            return found
        note = f'poses on {topic} are up to {late / 1e9:.1f} s away from the depth images'
        return replace(found, notes=(*found.notes, note))

    return find


def _from_message(
    pose: PoseSetup,
    topic: str,
    message: StampedPose,
    sight: Sight,
    stamp_ns: int,
    lookup: Lookup,
) -> CameraPose:
    if is_in_world(message, pose):
        depth_from_world = inverse(message.frame_from_body)
        if message.covariance is not None:
            return pose_in_world(message.frame_from_body, message.covariance)
        return stated_pose(depth_from_world, pose, f'the pose on {topic}')
    depth_from_frame = _depth_from(message, sight, stamp_ns, lookup)
    if depth_from_frame is None:
        told = f'{pose.world_frame!r}' if pose.world_frame else 'which the scene does not name'
        raise PoseError(
            f'{topic} is in the frame {message.frame_id!r}: a pose of the camera must be in the '
            f"scene's world_frame ({told}; under 'pose'), a pose of the world in the depth "
            f"images' frame ({sight.frame_id!r}), or in one that transforms lead from to it"
        )
    found = pose_from_rig(
        depth_from_frame, message.frame_from_body, message.covariance, world_from_rig=np.eye(4)
    )
    if message.covariance is not None:
        return found
    return stated_pose(found.depth_from_world, pose, f'the pose on {topic}')


def is_in_world(message: StampedPose, pose: PoseSetup) -> bool:
    """Tell whether a pose is in the scene's world frame, and so is the depth camera's."""
    return bool(pose.world_frame) and is_same_frame(message.frame_id, pose.world_frame)


def is_same_frame(first: str, second: str) -> bool:
    """Compare names of frames; none is like no other."""
    return bool(first) and first.lstrip('/') == second.lstrip('/')


def _depth_from(
    message: StampedPose, sight: Sight, stamp_ns: int, lookup: Lookup
) -> FloatArray | None:
    if is_same_frame(message.frame_id, sight.frame_id):
        return np.eye(4)
    return lookup(sight.frame_id, message.frame_id, stamp_ns)


def from_seen_marker(
    scene: Scene, setup: ObservationSetup, message: StampedPose, depth_from_color: FloatArray
) -> PoseSource:
    """Take the pose of the scene's marker in the colour camera, checked against depth on it.

    Args:
        scene: with a marker.
        setup: says how well it is known where no covariance comes with it.
        message: pose of the marker.
        depth_from_color: shape (4, 4).
    """
    marker = required_marker(scene)

    def find(sight: Sight) -> CameraPose:
        evidence = DepthEvidence(sight.depth, sight.camera, depth_from_color)
        check = marker_distance_check(
            message.frame_from_body, target_of(marker), evidence, message.seen_ids
        )
        if check is not None:
            check.require()
        found = pose_from_rig(
            depth_from_color,
            message.frame_from_body,
            message.covariance,
            world_from_rig=marker.world_from_marker,
        )
        if message.covariance is not None:
            return found
        return stated_pose(found.depth_from_world, setup.pose, 'the pose of the marker')

    return find


def required_marker(scene: Scene, remedy: str = 'use --pose stored') -> Marker:
    """Return the scene's marker.

    Raises:
        PoseError: when it has none.
    """
    if scene.marker is None:
        raise PoseError(f"the scene has no 'marker': add its dictionary, id and side, or {remedy}")
    return scene.marker
