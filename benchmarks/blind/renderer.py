# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A depth buffer with several samples a pixel.

Pixel centres are at integers; depth is z along the optical axis.
"""

from dataclasses import dataclass

import numpy as np

from benchmarks.blind.paint import IntArray
from benchmarks.blind.rotations import rotation
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.surface import Triangles

SAMPLES = 3  # Along each side of a pixel; odd, so that one lies in its centre.
_MARGIN = 6  # Pixels around the body, for what the sensor smears.
_ON_EDGE = 1e-9


@dataclass(frozen=True)
class Camera:
    """A pinhole camera.

    Attributes:
        width: [px].
        height: [px].
        fx: [px].
        fy: [px].
        cx: [px].
        cy: [px].
        radial: first radial distortion coefficient; 0 for a rectified image.
        tangential: two coefficients of a lens element that sits beside the axis, as Brown's.
        wobble: amplitude [px], period [px] and phase [rad] of how columns swing over the rows.
        skew: by how much columns are shifted over the rows, from the middle one on [-].
        tilt: of the imager behind its lens, about its x and y [rad].
        drop: of a drop on the window: its middle's column and row from the principal point, by
            how much it shifts at most, and how far from its middle that is [px].
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    radial: float = 0.0
    tangential: tuple[float, float] = (0.0, 0.0)
    wobble: tuple[float, float, float] = (0.0, 1.0, 0.0)
    skew: float = 0.0
    tilt: tuple[float, float] = (0.0, 0.0)
    drop: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)

    def project(self, points: FloatArray) -> FloatArray:
        """Return column and row of points (..., 3) [px], shape (..., 2)."""
        x, y = points[..., 0] / points[..., 2], points[..., 1] / points[..., 2]
        one, two = self.tangential
        squares, product = x**2 + y**2, x * y
        aside = 2.0 * one * product + two * (squares + 2.0 * x**2)
        down = one * (squares + 2.0 * y**2) + 2.0 * two * product
        if self.radial:
            stretch = 1.0 + self.radial * squares
            x, y = x * stretch, y * stretch
        if one or two:
            x, y = x + aside, y + down
        if any(self.tilt):
            x, y = on_tilted(x, y, self.tilt)
        columns, rows = self.fx * x + self.cx, self.fy * y + self.cy
        amount, period, phase = self.wobble
        if amount:
            columns = columns + amount * np.sin(2.0 * np.pi * rows / period + phase)
        if self.skew:
            columns = columns + self.skew * (rows - self.cy)
        if self.drop[2]:
            aside, down = through_drop(columns - self.cx, rows - self.cy, self.drop)
            columns, rows = self.cx + aside, self.cy + down
        return np.stack([columns, rows], axis=-1)


def through_drop(
    across: FloatArray, down: FloatArray, drop: tuple[float, float, float, float]
) -> tuple[FloatArray, FloatArray]:
    """Return where in an image places are seen that lie behind a drop.

    A drop is round and thick in its middle: it bends rays by its slope, away from there or, where
    the shift is negative, towards it, which falls by the exponential of the square of the way.

    Args:
        across: of places without it, from the principal point [px], any shape.
        down: likewise.
        drop: its middle, the largest shift, and how far from its middle that is [px].

    Returns:
        Places with it, the shape of `across` each.
    """
    x, y, most, width = drop
    away, below = (across - x) / width, (down - y) / width
    shift = most * np.exp(0.5 - 0.5 * (away**2 + below**2))
    return across + shift * away, down + shift * below


def on_tilted(
    x: FloatArray, y: FloatArray, tilt: tuple[float, float]
) -> tuple[FloatArray, FloatArray]:
    """Return where rays meet an imager that stands aslant behind its lens.

    It goes through where the axis meets the plane at distance 1 (the model of a tilted sensor of
    OpenCV's calib3d; Louhichi et al. 2007, Meas. Sci. Technol. 18).

    Args:
        x: of rays where z is 1 [-], any shape.
        y: likewise.
        tilt: about x, then about y [rad].

    Returns:
        Places in the imager's own plane [-], the shape of x each.
    """
    imager = rotation(np.array([0.0, -tilt[1], 0.0])) @ rotation(np.array([-tilt[0], 0.0, 0.0]))
    ahead, aside, along = (row[0] * x + row[1] * y + row[2] for row in imager)
    scale = imager[2, 2] / along
    return scale * ahead - imager[0, 2], scale * aside - imager[1, 2]


@dataclass(frozen=True)
class Rendering:
    """Samples of the part of an image that shows the surface.

    Attributes:
        column: first column of the window [px].
        row: first row [px].
        depth: z [m], shape (h, w, 9); infinite where nothing is.
        labels: of the surface, -1 where nothing is, shape (h, w, 9).
        facing: cosine of the angle between ray and surface, 1 where nothing is, shape (h, w, 9).
    """

    column: int
    row: int
    depth: FloatArray
    labels: IntArray
    facing: FloatArray


def render(surface: Triangles, camera: Camera) -> Rendering:
    """Render a surface in the camera frame."""
    image = camera.project(surface.corners)
    low = np.floor(image.min(axis=(0, 1))).astype(int) - _MARGIN
    high = np.ceil(image.max(axis=(0, 1))).astype(int) + _MARGIN
    low = np.maximum(low, 0)
    high = np.minimum(high, [camera.width - 1, camera.height - 1])
    width, height = (high - low + 1).tolist()
    if width <= 0 or height <= 0:
        raise ValueError('the surface lies outside the image: move the camera')
    # Sample k of a pixel sits at (k + 1/2) / SAMPLES - 1/2 from its centre.
    samples = (image - low + 0.5) * SAMPLES - 0.5
    shape = (height * SAMPLES, width * SAMPLES)
    depth, owners = _fill(samples, surface, shape)
    labels = np.where(owners < 0, -1, surface.labels[owners])
    facing = np.where(owners < 0, 1.0, _cosines(surface)[owners])
    blocks = (height, SAMPLES, width, SAMPLES)
    return Rendering(
        column=int(low[0]),
        row=int(low[1]),
        depth=depth.reshape(blocks).swapaxes(1, 2).reshape(height, width, -1),
        labels=labels.reshape(blocks).swapaxes(1, 2).reshape(height, width, -1),
        facing=facing.reshape(blocks).swapaxes(1, 2).reshape(height, width, -1),
    )


def _cosines(surface: Triangles) -> FloatArray:
    """Return the cosine between each triangle's normal and the ray to its middle, shape (T,)."""
    a, b, c = surface.corners.swapaxes(0, 1)
    normals, rays = np.cross(b - a, c - a), surface.corners.mean(axis=1)
    sizes = np.linalg.norm(normals, axis=1) * np.linalg.norm(rays, axis=1)
    return np.abs((normals * rays).sum(axis=1)) / np.maximum(sizes, 1e-30)


def _fill(
    corners: FloatArray, surface: Triangles, shape: tuple[int, int]
) -> tuple[FloatArray, IntArray]:
    """Return depth, and which triangle is seen, -1 for none, at each sample, flat.

    Args:
        corners: in units of samples, shape (T, 3, 2).
        surface: the triangles.
        shape: samples down and across.
    """
    owners, columns, rows = _candidates(corners, shape)
    a, b, c = (corners[owners, corner] for corner in range(3))
    point = np.stack([columns, rows], axis=1)
    double_area = _cross(b - a, c - a)
    with np.errstate(divide='ignore', invalid='ignore'):
        weights = (
            np.stack(
                [_cross(c - b, point - b), _cross(a - c, point - c), _cross(b - a, point - a)],
                axis=1,
            )
            / double_area[:, None]
        )
    # A NaN of a triangle seen edge on compares false and falls out.
    inside = (weights >= -_ON_EDGE).all(axis=1)
    owners, weights = owners[inside], weights[inside]
    # In the image, 1/z is linear over a plane and z is not.
    inverse = (weights / surface.corners[owners, :, 2]).sum(axis=1)
    z = 1.0 / inverse
    flat = rows[inside] * shape[1] + columns[inside]
    order = np.lexsort((z, flat))
    first = np.ones(len(order), dtype=bool)
    first[1:] = flat[order][1:] != flat[order][:-1]
    nearest = order[first]
    depth = np.full(shape[0] * shape[1], np.inf)
    seen = np.full(shape[0] * shape[1], -1)
    depth[flat[nearest]] = z[nearest]
    seen[flat[nearest]] = owners[nearest]
    return depth, seen


def _candidates(
    corners: FloatArray, shape: tuple[int, int]
) -> tuple[IntArray, IntArray, IntArray]:
    """List the samples in each triangle's bounding box: triangle, column, row."""
    limit = np.array([shape[1] - 1, shape[0] - 1])
    low = np.maximum(np.ceil(corners.min(axis=1) - _ON_EDGE), 0).astype(np.int64)
    high = np.minimum(np.floor(corners.max(axis=1) + _ON_EDGE), limit).astype(np.int64)
    size = np.maximum(high - low + 1, 0)
    count = size[:, 0] * size[:, 1]
    owners = np.repeat(np.arange(len(corners)), count)
    place = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    across = size[owners, 0]
    return owners, low[owners, 0] + place % across, low[owners, 1] + place // across


def _cross(one: FloatArray, two: FloatArray) -> FloatArray:
    return one[..., 0] * two[..., 1] - one[..., 1] * two[..., 0]
