# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Depth measured on the markers: it settles which way they face, and how far away they are."""

from collections.abc import Collection
from dataclasses import dataclass

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.errors import PoseError
from diffcal_ros.pose.board_target import BoardTarget
from diffcal_ros.pose.target import Target
from diffcal_ros.rigid_transform import apply, check_rigid, inverse
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_FEWEST_PIXELS = 30  # Fewer are noise.
# Depth further off is not the marker, as a share of the predicted one. Where the marker's size is
# in doubt it may be off by any factor.
_FARTHEST = 0.1
_FARTHEST_OF_UNKNOWN_SIZE = 20.0
_MARKER_WORDS = ('marker', 'side', 'edge of the black square')
_BOARD_WORDS = ('board', 'square', 'print over several squares')
_UNCOVERED = 0.75  # Quantile of the parts' distances: up to three quarters may be covered.
# A pose further off than this has a wrong scale: the corners themselves are good to under 1 %.
_TOLERATED = 0.03


@dataclass(frozen=True)
class DepthEvidence:
    """A depth image that shows the markers.

    Attributes:
        depth: z [m], shape (H, W); NaN where invalid.
        camera: intrinsics of the depth image.
        depth_from_color: from the colour to the depth camera's frame, shape (4, 4).
    """

    depth: NDArray[np.floating]
    camera: PinholeCamera
    depth_from_color: FloatArray

    def __post_init__(self) -> None:
        check_rigid('depth_from_color', self.depth_from_color)
        if self.depth.shape != (self.camera.height, self.camera.width):
            raise PoseError(
                f'depth is {self.depth.shape}, its camera expects '
                f'{(self.camera.height, self.camera.width)}: check that camera_info matches '
                'the depth topic'
            )


@dataclass(frozen=True)
class MarkerPoints:
    """Measured points on the markers.

    Attributes:
        points: in the colour camera's frame [m], shape (n, 3).
        normals: of the marker each lies on, in the target's frame, shape (n, 3).
        origins: a point of that marker in the target's frame [m], shape (n, 3).
        depth_ratio: measured over predicted depth, shape (n,).
        parts: number of the part of the target each lies on, shape (n,).
    """

    points: FloatArray
    normals: FloatArray
    origins: FloatArray
    depth_ratio: FloatArray
    parts: IntArray

    def own_depth_ratio(self) -> float:
        """Return measured over predicted depth of the target, covered parts of it left out.

        What stands before a board is nearer than it: of the parts' medians the farther ones count.
        """
        medians = [
            float(np.median(self.depth_ratio[self.parts == part]))
            for part in np.unique(self.parts)
        ]
        return float(np.quantile(medians, _UNCOVERED))

    def heights(self, camera_from_marker: FloatArray) -> FloatArray:
        """Return how far each point lies in front of its marker [m], shape (n,)."""
        normals = self.normals @ camera_from_marker[:3, :3].T
        heights: FloatArray = (
            normals * (self.points - apply(camera_from_marker, self.origins))
        ).sum(axis=1)
        return heights


@dataclass(frozen=True)
class DistanceCheck:
    """The markers' distance as their pose says against the depth measured on them.

    Attributes:
        pose_distance: from the depth camera, by the pose [m].
        measured_distance: by the depth image [m].
        pixel_count: depth pixels on the markers.
        is_board: they are squares of a ChArUco board.
    """

    pose_distance: float
    measured_distance: float
    pixel_count: int
    is_board: bool = False

    @property
    def relative_error(self) -> float:
        """By how much the pose is too far, as a share of the measured distance."""
        return self.pose_distance / self.measured_distance - 1.0

    @property
    def problem(self) -> str | None:
        """What is wrong and what to do, or None."""
        if abs(self.relative_error) <= _TOLERATED:
            return None
        what, length, remedy = _BOARD_WORDS if self.is_board else _MARKER_WORDS
        return (
            f'the {what} is {self.pose_distance * 1e3:.0f} mm away by its size in the image, but '
            f'{self.measured_distance * 1e3:.0f} mm by the depth on it '
            f"({self._error_words}, {_TOLERATED:.0%} is tolerated): the {what}'s {length} "
            f'in the scene is wrong; {self._factor_words} times it would fit. '
            f'Measure the {remedy}'
        )

    @property
    def _error_words(self) -> str:
        """Say the error as people do: 3 % too far, or 40 times as far."""
        if self.relative_error < 1.0:
            return f'{self.relative_error:+.1%}'
        return f'{1.0 + self.relative_error:.3g} times as far'

    @property
    def _factor_words(self) -> str:
        factor = 1.0 / (1.0 + self.relative_error)
        return f'{factor:.3f}' if factor > 0.1 else f'{factor:.2g}'

    def require(self) -> None:
        """Raise when the distances disagree.

        Raises:
            PoseError: with `problem`.
        """
        if self.problem is not None:
            raise PoseError(self.problem)


def marker_distance_check(
    camera_from_marker: FloatArray,
    target: Target,
    evidence: DepthEvidence,
    seen: Collection[int] | None = None,
) -> DistanceCheck | None:
    """Compare the pose's distance with the depth on the markers.

    Args:
        camera_from_marker: pose in the colour camera, shape (4, 4).
        target: the marker or board.
        evidence: a depth image.
        seen: parts of the target that are known to be uncovered, or None for all of them.

    Returns:
        The comparison, or None where the depth image shows nothing on the markers.
    """
    measured = points_on_markers(
        camera_from_marker, target, evidence, seen, farthest=_FARTHEST_OF_UNKNOWN_SIZE
    )
    if measured is None:
        return None
    middle = np.mean([corners.mean(axis=0) for corners in target.corners.values()], axis=0)
    in_depth = apply(evidence.depth_from_color @ camera_from_marker, middle)
    return DistanceCheck(
        pose_distance=float(in_depth[2]),
        measured_distance=float(in_depth[2] * measured.own_depth_ratio()),
        pixel_count=len(measured.points),
        is_board=isinstance(target, BoardTarget),
    )


def points_on_markers(
    camera_from_marker: FloatArray,
    target: Target,
    evidence: DepthEvidence,
    seen: Collection[int] | None = None,
    *,
    farthest: float = _FARTHEST,
) -> MarkerPoints | None:
    """Collect the depth pixels whose rays meet a marker, or a board's squares around a corner.

    Args:
        camera_from_marker: pose in the colour camera, shape (4, 4).
        target: the marker or board.
        evidence: a depth image.
        seen: parts of the target that are known to be uncovered, or None for all of them.
        farthest: depth off by more than this share of the predicted one is left out.

    Returns:
        The points, or None where there are too few.
    """
    depth_from_target = evidence.depth_from_color @ camera_from_marker
    parts = [
        part
        for number, corners in target.areas.items()
        if seen is None or number in seen
        if (part := _on_one_part(depth_from_target, number, corners, evidence, farthest))
        is not None
    ]
    if not parts or sum(len(part.points) for part in parts) < _FEWEST_PIXELS:
        return None
    return MarkerPoints(
        np.concatenate([part.points for part in parts]),
        np.concatenate([part.normals for part in parts]),
        np.concatenate([part.origins for part in parts]),
        np.concatenate([part.depth_ratio for part in parts]),
        np.concatenate([part.parts for part in parts]),
    )


def _on_one_part(
    depth_from_target: FloatArray,
    number: int,
    corners: FloatArray,
    evidence: DepthEvidence,
    farthest: float,
) -> MarkerPoints | None:
    camera = evidence.camera
    in_depth = apply(depth_from_target, corners)
    if in_depth[:, 2].min() <= 0.0:
        return None
    pixels = camera.project(in_depth)
    left, top = np.maximum(np.floor(pixels.min(axis=0)).astype(int), 0)
    right, bottom = np.minimum(
        np.ceil(pixels.max(axis=0)).astype(int) + 1, [camera.width, camera.height]
    )
    if left >= right or top >= bottom:
        return None
    columns, rows = np.meshgrid(np.arange(left, right), np.arange(top, bottom))
    rays = np.stack(
        [(columns - camera.cx) / camera.fx, (rows - camera.cy) / camera.fy, np.ones(rows.shape)],
        axis=-1,
    ).reshape(-1, 3)
    middle, across, down, normal = _square_frame(in_depth)
    predicted = (middle @ normal) / (rays @ normal)
    on_plane = rays * predicted[:, None] - middle
    inside = (np.abs(on_plane @ across) <= 1.0) & (np.abs(on_plane @ down) <= 1.0)
    depth = np.asarray(evidence.depth[top:bottom, left:right], dtype=np.float64).ravel()
    ratio = depth / predicted
    # NaN compares false: invalid pixels drop out here.
    kept = inside & (np.abs(ratio - 1.0) < farthest)
    points = apply(inverse(evidence.depth_from_color), rays[kept] * depth[kept, None])
    *_, target_normal = _square_frame(corners)
    count = len(points)
    return MarkerPoints(
        points,
        np.tile(target_normal, (count, 1)),
        np.tile(corners.mean(axis=0), (count, 1)),
        ratio[kept],
        np.full(count, number),
    )


def _square_frame(corners: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return a square's middle, two vectors that measure it as -1..1, and its outward normal."""
    middle = corners.mean(axis=0)
    across = (corners[1] + corners[2]) / 2.0 - middle
    down = (corners[2] + corners[3]) / 2.0 - middle
    normal = np.cross(down, across)
    return (
        middle,
        across / (across @ across),
        down / (down @ down),
        normal / np.linalg.norm(normal),
    )
