# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where the depth camera was, by the scene or by a marker on the rig."""

from dataclasses import dataclass

from diffcal_ros.errors import PoseError
from diffcal_ros.rigid_transform import inverse
from diffcal_ros.scene.model import ObservationSetup
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class CameraPose:
    """Where the depth camera was.

    Attributes:
        depth_from_world: shape (4, 4).
        covariance: of a shift of `pivot` and a turn about it in the camera's frame, shape (6, 6);
            None where it is taken as exact.
        pivot: in the depth camera's frame [m], shape (3,), or None.
        notes: what a person should know.
    """

    depth_from_world: FloatArray
    covariance: FloatArray | None = None
    pivot: FloatArray | None = None
    notes: tuple[str, ...] = ()


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
    return CameraPose(setup.stored_depth_from_world)


def pose_from_rig(
    depth_from_color: FloatArray,
    color_from_rig: FloatArray,
    covariance: FloatArray | None,
    *,
    world_from_rig: FloatArray,
    notes: tuple[str, ...] = (),
) -> CameraPose:
    """Turn the pose of a part of the rig in the colour camera into the depth camera's.

    Args:
        depth_from_color: shape (4, 4).
        color_from_rig: pose of the marker, say, shape (4, 4).
        covariance: of that pose: a shift of the rig's origin [m] and a turn about it [rad], as
            vectors in the colour camera's frame, shape (6, 6); None where it is exact.
        world_from_rig: where the marker sits in the scene, shape (4, 4).
        notes: what a person should know.
    """
    depth_from_rig = depth_from_color @ color_from_rig
    turn = np.kron(np.eye(2), depth_from_color[:3, :3])
    return CameraPose(
        depth_from_world=depth_from_rig @ inverse(world_from_rig),
        covariance=None if covariance is None else turn @ covariance @ turn.T,
        pivot=depth_from_rig[:3, 3],
        notes=notes,
    )
