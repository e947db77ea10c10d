# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where the depth camera was, and how well that is known."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from diffcal_ros.errors import PoseError
from diffcal_ros.rigid_transform import angle_between, apply, inverse
from diffcal_ros.scene.model import ObservationSetup, PoseSetup
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Standard deviations by which poses of one recording may differ before it is told, and refused.
_TOLD, _REFUSED = 1.0, 3.0
# Numbers that were rounded on their way differ so much in place [m] and direction [rad].
_ROUNDING = (1e-4, float(np.deg2rad(0.02)))


@dataclass(frozen=True)
class CameraPose:
    """Where the depth camera was.

    Attributes:
        depth_from_world: shape (4, 4).
        covariance: of a shift of `pivot` and a turn about it in the camera's frame, shape (6, 6);
            None where it is taken as exact.
        pivot: in the depth camera's frame [m], shape (3,), or None.
        notes: what a person should know.
        mirrored: another pose, shape (4, 4), that explains a flat marker about as well; None where
            there is none, or it is ruled out.
    """

    depth_from_world: FloatArray
    covariance: FloatArray | None = None
    pivot: FloatArray | None = None
    notes: tuple[str, ...] = ()
    mirrored: FloatArray | None = None


def stored_pose(setup: ObservationSetup) -> CameraPose:
    """Return the pose that the scene gives for one of its observations.

    Raises:
        PoseError: when it gives none.
    """
    if setup.stored_depth_from_world is None:
        raise PoseError(
            "the scene has no 'stored_depth_from_world': add it, or use --pose estimated with a "
            'marker in the colour images'
        )
    return stated_pose(setup.stored_depth_from_world, setup.pose, 'the stored pose')


def stated_pose(depth_from_world: FloatArray, pose: PoseSetup, what: str) -> CameraPose:
    """Return a pose that is known as well as the scene says.

    The camera's position and its direction are each off by a little, so that the pivot is the
    camera itself, as where ROS states the covariance of a camera's pose in the world.

    Args:
        depth_from_world: shape (4, 4).
        pose: how well it is known.
        what: words for it, such as 'the stored pose'.
    """
    position, rotation = pose.spread
    if position == 0.0:
        return CameraPose(depth_from_world)
    note = (
        f'{what} is taken to be known to {1e3 * position:.3g} mm and {np.rad2deg(rotation):.3g} '
        "degrees: state position_std and rotation_std_deg under 'pose' in the scene if you know "
        'better'
    )
    return CameraPose(
        depth_from_world,
        covariance=np.diag([position**2] * 3 + [rotation**2] * 3),
        pivot=np.zeros(3),
        notes=() if pose.is_spread_stated else (note,),
    )


def pose_in_world(world_from_depth: FloatArray, covariance: FloatArray) -> CameraPose:
    """Turn the camera's own pose in the world, with its covariance, into what a fit needs.

    Args:
        world_from_depth: shape (4, 4).
        covariance: of a shift of the camera [m] and a turn about it [rad], along the world's
            axes, shape (6, 6).
    """
    depth_from_world = inverse(world_from_depth)
    # What the camera moves by, everything in its view moves by the other way: signs cancel.
    turn = np.kron(np.eye(2), depth_from_world[:3, :3])
    return CameraPose(depth_from_world, turn @ covariance @ turn.T, pivot=np.zeros(3))


def steady_pose(poses: Sequence[CameraPose]) -> CameraPose:
    """Return the one pose of a recording from those at its frames: the middle one.

    Args:
        poses: in the order of the frames, at least one.

    Raises:
        PoseError: when the camera moved, by far more than its pose is unsure of.
    """
    middle = poses[len(poses) // 2]
    pivot = np.zeros(3) if middle.pivot is None else middle.pivot
    in_world = apply(inverse(middle.depth_from_world), pivot)
    shift = max(
        float(np.linalg.norm(apply(pose.depth_from_world, in_world) - pivot)) for pose in poses
    )
    turn = max(angle_between(pose.depth_from_world, middle.depth_from_world) for pose in poses)
    known = (0.0, 0.0) if middle.covariance is None else _spread(middle.covariance)
    ratio = max(
        moved / max(std, rounding)
        for moved, std, rounding in zip((shift, turn), known, _ROUNDING, strict=True)
    )
    if ratio <= _TOLD:
        return middle
    told = (
        f'while the body is filmed the pose of the camera changes by {1e3 * shift:.3g} mm and '
        f'{np.rad2deg(turn):.3g} degrees, and is known to {1e3 * known[0]:.3g} mm and '
        f'{np.rad2deg(known[1]):.3g} degrees'
    )
    if ratio > _REFUSED:
        raise PoseError(
            f'{told}: hold camera and rig still while recording, use the part where they stand '
            "still, or state position_std and rotation_std_deg under 'pose' as they are"
        )
    return replace(middle, notes=(*middle.notes, f'{told}: the one in the middle is taken'))


def _spread(covariance: FloatArray) -> tuple[float, float]:
    """Return standard deviations of a shift [m] and a turn [rad], on average over the axes."""
    variances = np.diag(covariance)
    return float(np.sqrt(variances[:3].mean())), float(np.sqrt(variances[3:].mean()))


def pose_from_rig(
    depth_from_color: FloatArray,
    color_from_rig: FloatArray,
    covariance: FloatArray | None,
    *,
    world_from_rig: FloatArray,
    notes: tuple[str, ...] = (),
    mirrored: FloatArray | None = None,
) -> CameraPose:
    """Turn the pose of a part of the rig in the colour camera into the depth camera's.

    Args:
        depth_from_color: shape (4, 4).
        color_from_rig: pose of the marker, say, shape (4, 4).
        covariance: of that pose: a shift of the rig's origin [m] and a turn about it [rad], as
            vectors in the colour camera's frame, shape (6, 6); None where it is exact.
        world_from_rig: where the marker sits in the scene, shape (4, 4).
        notes: what a person should know.
        mirrored: another pose of that part that explains the images about as well, shape (4, 4).
    """
    depth_from_rig = depth_from_color @ color_from_rig
    turn = np.kron(np.eye(2), depth_from_color[:3, :3])
    return CameraPose(
        depth_from_world=depth_from_rig @ inverse(world_from_rig),
        covariance=None if covariance is None else turn @ covariance @ turn.T,
        pivot=depth_from_rig[:3, 3],
        notes=notes,
        mirrored=(
            None if mirrored is None else depth_from_color @ mirrored @ inverse(world_from_rig)
        ),
    )
