# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Poses that explain the corners of one view; a flat target seen from afar has two."""

from dataclasses import dataclass

import cv2
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.rigid_transform import apply, rotation_matrix, transform
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_FLAT = 1e-6  # Share of a target's size by which its corners may leave a plane.


@dataclass(frozen=True)
class PoseCandidate:
    """One pose that explains a view.

    Attributes:
        camera_from_marker: shape (4, 4).
        error: root mean square distance between seen and predicted corners [px].
    """

    camera_from_marker: FloatArray
    error: float


def pose_candidates(
    points: FloatArray, pixels: FloatArray, camera: PinholeCamera
) -> tuple[PoseCandidate, ...]:
    """Find the poses that explain one view, the better one first.

    A flat target has two (Collins and Bartoli 2014, infinitesimal plane-based pose
    estimation), mirror images about the line of sight.

    Args:
        points: corners in the target's frame [m], shape (n, 3), n >= 4.
        pixels: the same in the ideal pinhole image [px], shape (n, 2).
        camera: intrinsics.

    Returns:
        Up to two candidates; none when the corners allow no pose.
    """
    method = cv2.SOLVEPNP_IPPE if _is_flat(points) else cv2.SOLVEPNP_SQPNP
    count, turns, shifts, _ = cv2.solvePnPGeneric(
        np.ascontiguousarray(points),
        np.ascontiguousarray(pixels),
        camera.K,
        np.zeros(4),
        flags=method,
    )
    vectors = np.hstack(
        [np.reshape(shifts[:count], (-1, 3)), np.reshape(turns[:count], (-1, 3))]
    ).astype(np.float64)
    poses = [transform(rotation_matrix(vector[3:]), vector[:3]) for vector in vectors]
    candidates = [
        PoseCandidate(pose, reprojection_error(pose, points, pixels, camera))
        for pose in poses
        if np.isfinite(pose).all() and apply(pose, points)[:, 2].min() > 0.0
    ]
    return tuple(sorted(candidates, key=lambda candidate: candidate.error))


def reprojection_error(
    camera_from_marker: FloatArray, points: FloatArray, pixels: FloatArray, camera: PinholeCamera
) -> float:
    """Return the root mean square distance between seen and predicted corners [px]."""
    miss = camera.project(apply(camera_from_marker, points)) - pixels
    return float(np.sqrt((miss**2).sum(axis=-1).mean()))


def _is_flat(points: FloatArray) -> bool:
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(spread[2] <= _FLAT * spread[0])
