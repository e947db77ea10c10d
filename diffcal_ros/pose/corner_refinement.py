# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Corners of a marker from straight lines through its four sides.

A detector's own corners are pixels of the black square's rim: half a pixel inside, which puts a
marker of 30 pixels 3 % too far away. Here the edge is located on many short profiles across each
side, a line is laid through them, and neighbouring lines are intersected.
"""

import cv2
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.median_spread import median_spread
from diffcal_ros.pose.lens import distort, undistort
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_ROUNDS = 3
_PROFILES = 40  # Per side.
_STEPS = 32  # Samples along a profile.
# Profiles stay clear of the corners, where two edges mix.
_FIRST, _LAST = 0.12, 0.88
# Half length of a profile in squares of the marker: neither the code inside nor what lies
# beyond the white rim is reached.
_REACH = 0.7
_REACH_LIMITS = (1.5, 4.0)  # [px]
# A corner that walks off further than this left the marker for another edge [profile halves].
_LONGEST_WALK = 1.5
_FIT_ROUNDS = 5


def refine_corners(
    gray: NDArray[np.uint8], corners: FloatArray, *, camera: PinholeCamera, cells: int
) -> FloatArray | None:
    """Locate the corners of one detected marker to a few hundredths of a pixel.

    Args:
        gray: image, shape (H, W).
        corners: as detected [px], shape (4, 2), clockwise.
        camera: intrinsics; sides are straight once its distortion is taken out.
        cells: squares along a side, black border included.

    Returns:
        Corners in the ideal pinhole image [px], shape (4, 2), or None where the sides show no
        clear edge.
    """
    start = undistort(corners, camera)
    length = np.linalg.norm(start - np.roll(start, -1, axis=0), axis=1).mean()
    reach = float(np.clip(_REACH * length / cells, *_REACH_LIMITS))
    ideal = start
    for _ in range(_ROUNDS):
        points, weights = _edge_points(gray, ideal, camera, reach)
        if (weights.max(axis=1) <= 0.0).any():
            return None
        ideal = _intersections(points, weights)
        # The comparison is also false for NaN, from parallel sides.
        if not np.linalg.norm(ideal - start, axis=1).max() <= _LONGEST_WALK * reach:
            return None
    return ideal


def _edge_points(
    gray: NDArray[np.uint8], ideal: FloatArray, camera: PinholeCamera, reach: float
) -> tuple[FloatArray, FloatArray]:
    """Find the dark-to-bright edge on profiles across each side.

    Returns:
        Points in the ideal pinhole image [px], shape (4, n, 2), and their weights, shape (4, n);
        weight zero where there is no edge.
    """
    sides = np.roll(ideal, -1, axis=0) - ideal
    along = np.linspace(_FIRST, _LAST, _PROFILES)
    offsets = np.linspace(-reach, reach, _STEPS)
    # Corners run clockwise in an image with y down, so this normal points outwards.
    normals = np.stack([sides[:, 1], -sides[:, 0]], axis=1)
    normals /= np.linalg.norm(sides, axis=1, keepdims=True)
    feet = ideal[:, None] + along[:, None] * sides[:, None]
    samples = feet[:, :, None] + offsets[:, None] * normals[:, None, None]
    profiles = _sampled(gray, distort(samples, camera))
    # Inside is ink and outside paper: only a rise counts, squared so that the steepest part leads.
    rises = np.clip(np.diff(profiles, axis=2), 0.0, None) ** 2
    strength = rises.sum(axis=2)
    middles = (offsets[1:] + offsets[:-1]) / 2.0
    shift = (rises @ middles) / np.maximum(strength, 1e-9)
    clear = strength > 0.2 * np.median(strength, axis=1, keepdims=True)
    return feet + shift[..., None] * normals[:, None], clear.astype(np.float64)


def _sampled(gray: NDArray[np.uint8], pixels: FloatArray) -> FloatArray:
    """Interpolate an image at pixels, shape (..., 2), linearly; the rim goes on outside."""
    flat = pixels.reshape(-1, 2)
    low = np.maximum(np.floor(flat.min(axis=0)).astype(int) - 1, 0)
    high = np.ceil(flat.max(axis=0)).astype(int) + 2
    patch = gray[low[1] : high[1], low[0] : high[0]].astype(np.float32)
    local = (flat - low).astype(np.float32)
    values = cv2.remap(
        patch,
        local[:, :1].copy(),
        local[:, 1:].copy(),
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_REPLICATE,
    )
    return np.asarray(values, dtype=np.float64).reshape(pixels.shape[:-1])


def _intersections(points: FloatArray, weights: FloatArray) -> FloatArray:
    """Intersect robust lines through the points of neighbouring sides, shape (4, 2)."""
    lines = [_line(points[side], weights[side]) for side in range(4)]
    corners = np.full((4, 2), np.nan)
    for corner in range(4):
        before, after = lines[corner - 1], lines[corner]
        meeting = np.cross(before, after)
        if abs(meeting[2]) > 1e-9:
            corners[corner] = meeting[:2] / meeting[2]
    return corners


def _line(points: FloatArray, weights: FloatArray) -> FloatArray:
    """Fit a line a x + b y + c = 0 with a unit normal, outliers weighted down."""
    robust = weights
    line = np.zeros(3)
    for _ in range(_FIT_ROUNDS):
        middle = (robust[:, None] * points).sum(axis=0) / robust.sum()
        spread = points - middle
        _, axes = np.linalg.eigh((robust[:, None] * spread).T @ spread)
        normal = axes[:, 0]
        line = np.array([*normal, -normal @ middle])
        distance = np.abs(spread @ normal)
        scale = median_spread(distance[weights > 0.0]) + 1e-3
        robust = weights / (1.0 + (distance / (2.0 * scale)) ** 2)
    return line
