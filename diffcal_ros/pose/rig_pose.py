# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""One pose of the rig from many frames of a camera that stands still.

A flat marker seen from afar has two poses that explain its corners almost equally well, and a
single noisy frame picks the wrong one now and then. Here both are fitted to all frames together,
and the one that explains them better is kept.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.errors import PoseError
from diffcal_ros.pose.corner_fit import (
    CornerFit,
    fit_corners,
    gather,
    pose_equations,
    Sightings,
    typical_error,
    USED,
)
from diffcal_ros.pose.detection import Detection, Detector
from diffcal_ros.pose.marker_depth import (
    DepthEvidence,
    DistanceCheck,
    marker_distance_check,
    MarkerPoints,
    points_on_markers,
)
from diffcal_ros.pose.nothing_seen import why_nothing_seen
from diffcal_ros.pose.planar_pose import pose_candidates, PoseCandidate
from diffcal_ros.pose.target import Target
from diffcal_ros.rigid_transform import angle_between
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_SHARED_ERROR_WORTH = 4.0  # What is known of a detector counts as so many observations.
_MOST_STARTS = 32
_SAME_POSE = np.deg2rad(2.0)  # Closer, the two solutions are one.
_SETTLED = 1.5  # Ratio of the two solutions' errors from which on the choice is safe.
_SETTLED_BY_DEPTH = 1.5


@dataclass(frozen=True)
class RigPose:
    """Where the target is in the colour camera.

    Attributes:
        camera_from_marker: shape (4, 4).
        covariance: of a shift of the target's origin [m] and a turn about it [rad], both as
            vectors in the camera's frame, shape (6, 6): the order and meaning of ROS's
            PoseWithCovariance.
        supports: for each given frame, whether it supports the pose; False also where it shows
            no marker.
        outlier_count: frames that show a marker and contradict the pose.
        reprojection_error: root mean square corner distance over the supporting frames [px].
        other_camera_from_marker: the mirrored solution, or None where there is none.
        error_ratio: error of the mirrored solution over the error of this one, on corners
            averaged over the frames; infinite without a second solution.
        depth_error_ratio: the same for the depth on the markers, or None without depth.
        distance_check: the distance by the corners alone against the depth on the markers, or
            None without depth there. Where it has a problem, depth did not correct the pose.
        seen_ids: parts of the target that support the pose.
    """

    camera_from_marker: FloatArray
    covariance: FloatArray
    supports: tuple[bool, ...]
    outlier_count: int
    reprojection_error: float
    other_camera_from_marker: FloatArray | None
    error_ratio: float
    depth_error_ratio: float | None = None
    distance_check: DistanceCheck | None = None
    seen_ids: tuple[int, ...] = ()

    @property
    def frame_count(self) -> int:
        """Number of frames that support the pose."""
        return sum(self.supports)

    @property
    def is_settled(self) -> bool:
        """Tell whether the mirrored solution is ruled out."""
        by_depth = self.depth_error_ratio
        return self.error_ratio >= _SETTLED or (
            by_depth is not None and by_depth >= _SETTLED_BY_DEPTH
        )


def pose_from_images(
    images: Iterable[NDArray[np.uint8]],
    detector: Detector,
    *,
    depth: DepthEvidence | None = None,
) -> RigPose:
    """Detect the target in images of a static camera and estimate one pose.

    Raises:
        PoseError: when no image shows the target.
    """
    detections = [detector.detect(image) for image in images]
    return estimate_rig_pose(detections, detector.target, detector.camera, depth=depth)


def estimate_rig_pose(
    detections: Sequence[Detection],
    target: Target,
    camera: PinholeCamera,
    *,
    depth: DepthEvidence | None = None,
) -> RigPose:
    """Estimate one pose from all frames of a camera that stands still.

    Args:
        detections: of each frame; frames that do not show the target are allowed.
        target: the marker or board.
        camera: intrinsics of the colour images.
        depth: a depth image of the same scene. Where it shows the markers it decides between
            the two solutions, and corrects distance and tilt unless it contradicts the
            markers' size (see `RigPose.distance_check`).

    Raises:
        PoseError: when no frame shows the target; says what was seen instead.
    """
    sightings = gather(detections, target)
    if not len(sightings.ids):
        raise PoseError(why_nothing_seen(detections, target))
    first = fit_corners(_best_start(sightings, camera), sightings, camera)
    scale = typical_error(sightings.errors(first.camera_from_marker, camera))
    fits = [first, *_mirrored(first, sightings, camera, scale)]
    fits.sort(key=lambda fit: fit.error)
    seen = [int(part) for part in sightings.averaged(fits[0].weights).ids]
    measured = [
        None if depth is None else points_on_markers(fit.camera_from_marker, target, depth, seen)
        for fit in fits
    ]
    depth_ratio = _depth_ratio(fits, measured)
    if depth_ratio is not None and depth_ratio <= 1.0 / _SETTLED_BY_DEPTH:
        fits.reverse()
        measured.reverse()
        depth_ratio = 1.0 / depth_ratio
    check = (
        None
        if depth is None
        else marker_distance_check(fits[0].camera_from_marker, target, depth, seen)
    )
    # Pulled towards the depth, the pose would hide that the marker's side is wrong.
    trusted = None if check is None or check.problem is not None else measured[0]
    found = _result(fits, sightings, camera, detections, trusted)
    return replace(found, depth_error_ratio=depth_ratio, distance_check=check)


def _best_start(sightings: Sightings, camera: PinholeCamera) -> FloatArray:
    """Return the single-frame pose that explains all frames best."""
    frames = np.unique(sightings.frames)
    chosen = frames[np.unique(np.linspace(0, len(frames) - 1, _MOST_STARTS).round().astype(int))]
    starts = [
        candidate.camera_from_marker
        for frame in chosen
        for candidate in _candidates(sightings.of_frame(int(frame)), camera)
    ]
    if not starts:
        raise PoseError(
            'the marker was detected but its corners allow no pose: move the camera nearer, so '
            'that the marker spans at least 20 pixels'
        )
    # Distances count no further than a few pixels: a frame gone wrong must not decide.
    scores = [np.minimum(sightings.errors(start, camera), 3.0).sum() for start in starts]
    return starts[int(np.argmin(scores))]


def _candidates(sightings: Sightings, camera: PinholeCamera) -> tuple[PoseCandidate, ...]:
    return pose_candidates(
        sightings.points.reshape(-1, 3), sightings.pixels.reshape(-1, 2), camera
    )


def _mirrored(
    fit: CornerFit, sightings: Sightings, camera: PinholeCamera, scale: float
) -> list[CornerFit]:
    """Fit the other solution, if there is one."""
    found = []
    for candidate in _candidates(sightings.averaged(fit.weights), camera):
        if angle_between(candidate.camera_from_marker, fit.camera_from_marker) > _SAME_POSE:
            other = fit_corners(candidate.camera_from_marker, sightings, camera, scale=scale)
            if angle_between(other.camera_from_marker, fit.camera_from_marker) > _SAME_POSE:
                found.append(other)
    return found[:1]


def _depth_ratio(
    fits: Sequence[CornerFit], measured: Sequence[MarkerPoints | None]
) -> float | None:
    """Return how much worse the second solution fits the depth than the first."""
    if len(fits) < 2 or measured[0] is None or measured[1] is None:
        return None
    spreads = []
    for fit, points in zip(fits, (measured[0], measured[1]), strict=True):
        heights = points.heights(fit.camera_from_marker)
        # The distance is not the question here, only the tilt.
        spreads.append(float(np.median(np.abs(heights - np.median(heights)))))
    return spreads[1] / max(spreads[0], 1e-9)


def _result(
    fits: Sequence[CornerFit],
    sightings: Sightings,
    camera: PinholeCamera,
    detections: Sequence[Detection],
    measured: MarkerPoints | None,
) -> RigPose:
    best, *others = fits
    mean_error = _mean_corner_error(best, sightings, camera, detections[0].shared_error)
    pose = best.camera_from_marker
    if measured is not None:
        pose = fit_corners(
            pose, sightings, camera, corner_error=mean_error, depth=measured
        ).camera_from_marker
    said = pose_equations(
        pose, sightings, camera, best.weights, corner_error=mean_error, depth=measured
    )
    supporting = best.weights >= USED
    errors = sightings.errors(best.camera_from_marker, camera)[supporting]
    supports = _supporting_frames(sightings, supporting, len(detections))
    averaged = sightings.averaged(best.weights)
    own = _rms(averaged.errors(best.camera_from_marker, camera))
    other = _rms(averaged.errors(others[0].camera_from_marker, camera)) if others else np.inf
    return RigPose(
        camera_from_marker=pose,
        covariance=np.asarray(np.linalg.inv(said.curvature), dtype=np.float64),
        supports=tuple(bool(support) for support in supports),
        outlier_count=len(np.unique(sightings.frames)) - int(supports.sum()),
        reprojection_error=_rms(errors),
        other_camera_from_marker=others[0].camera_from_marker if others else None,
        error_ratio=float(other / max(own, 1e-6)),
        seen_ids=tuple(int(part) for part in averaged.ids),
    )


def _supporting_frames(
    sightings: Sightings, supporting: NDArray[np.bool_], frame_count: int
) -> NDArray[np.bool_]:
    """Tell of each frame whether at least half of what it shows fits the pose."""
    shown = np.bincount(sightings.frames, minlength=frame_count)
    fitting = np.bincount(sightings.frames[supporting], minlength=frame_count)
    return np.asarray((shown > 0) & (2 * fitting >= shown))


def _mean_corner_error(
    fit: CornerFit, sightings: Sightings, camera: PinholeCamera, shared: float
) -> float:
    """Estimate the standard deviation of a corner coordinate averaged over the frames [px]."""
    averaged = sightings.averaged(fit.weights)
    residuals = 2 * averaged.size * len(averaged.ids)
    misfit = averaged.size * float((averaged.errors(fit.camera_from_marker, camera) ** 2).sum())
    freedom = _SHARED_ERROR_WORTH + residuals - 6
    variance = (_SHARED_ERROR_WORTH * shared**2 + misfit) / freedom
    kept = np.isin(sightings.ids, averaged.ids)
    weights = fit.weights[kept]
    indices = np.searchsorted(averaged.ids, sightings.ids[kept])
    spread = sightings.pixels[kept] - averaged.pixels[indices]
    total = weights.sum()
    frame_variance = float(weights @ (spread**2).mean(axis=(1, 2)) / total)
    effective_count = float(total**2 / (weights @ weights)) / len(averaged.ids)
    return float(np.sqrt(variance + frame_variance / max(effective_count, 1.0)))


def _rms(values: FloatArray) -> float:
    return float(np.sqrt((values**2).mean()))
