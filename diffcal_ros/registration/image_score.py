# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How well a few points of a body agree with a depth image, for many places of the body at once.

A pixel that shows the body's own depth speaks for a place; one that looks through the body speaks
against it, and so does one beside the body's outline that shows the body's depth as well: the
surface there is something larger. What is hidden behind something nearer says little.
"""

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.registration.surface_sample import ShapeSample
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_THROUGH, _HIDDEN, _OUTSIDE = -1.0, -0.35, -0.5
# Surface beside the outline counts against a place by so much.
_LARGER = 0.8
# And again where it is beyond the body's free end.
_GOES_ON = 0.4
# It is that of something larger where it is within this of the body's depth [tolerances].
_BESIDE_REACH = 2.0
# Nothing at all where the clamp should hide or hold the body counts against a place by so much.
_NO_CLAMP = 0.6
_NONE = np.zeros((0, 3))


class ImageScore:
    """One thinned depth image."""

    def __init__(self, depth: NDArray[np.float32], camera: PinholeCamera, stride: int) -> None:
        """Thin an image.

        Args:
            depth: z [m], shape (H, W), NaN where invalid.
            camera: of the image.
            stride: one pixel in so many is kept, in rows and columns.
        """
        self.depth = np.ascontiguousarray(depth[::stride, ::stride], dtype=np.float64)
        self._camera, self._stride = camera, stride

    def surface_points(self) -> FloatArray:
        """Return every pixel that shows something as a point in the camera's frame [m], (P, 3)."""
        rows, columns = np.nonzero(np.isfinite(self.depth))
        depth = self.depth[rows, columns]
        camera, stride = self._camera, self._stride
        return np.stack(
            [
                (columns * stride - camera.cx) / camera.fx * depth,
                (rows * stride - camera.cy) / camera.fy * depth,
                depth,
            ],
            axis=1,
        )

    def at(
        self,
        sample: ShapeSample,
        places: FloatArray,
        tolerance: float,
        *,
        goes_on: bool = False,
    ) -> FloatArray:
        """Return how well each place agrees, 1 at best, shape (P,).

        Args:
            sample: points of the body.
            places: of its origin in the camera's frame [m], shape (P, 3).
            tolerance: depths that differ by less are the same [m].
            goes_on: surfaces are taken to go on where the image ends.
        """
        seen, depth = self._look_up(places, sample.surface)
        with np.errstate(invalid='ignore'):
            difference = seen - depth
            value = np.where(np.abs(difference) <= tolerance, 1.0, _THROUGH)
            value = np.where(difference < -tolerance, _HIDDEN, value)
        value = np.where(np.isneginf(seen), _OUTSIDE, value)
        score: FloatArray = value.mean(axis=1)
        for points, weight in ((sample.beside, _LARGER), (sample.beyond, _GOES_ON)):
            if len(points):
                seen, depth = self._look_up(places, points)
                with np.errstate(invalid='ignore'):
                    larger = np.abs(seen - depth) <= _BESIDE_REACH * tolerance
                if goes_on:
                    larger |= np.isneginf(seen)
                score = score - weight * larger.mean(axis=1)
        if len(sample.held):
            seen, depth = self._look_up(places, sample.held)
            is_empty = ~(seen <= depth + _BESIDE_REACH * tolerance)
            score = score - _NO_CLAMP * is_empty.mean(axis=1)
        return score

    def roughly_at(self, surface: FloatArray, places: FloatArray, tolerance: float) -> FloatArray:
        """Return the same for a few points of the surface alone, shape (P,)."""
        return self.at(ShapeSample(surface, _NONE, _NONE, _NONE, _NONE), places, tolerance)

    def _look_up(self, places: FloatArray, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return what each point's pixel shows, -inf outside, and the point's depth, (P, N)."""
        camera, stride = self._camera, self._stride
        depth = places[:, 2, None] + points[None, :, 2]
        inverse = 1.0 / np.maximum(depth, 1e-3)
        column = (places[:, 0, None] + points[None, :, 0]) * inverse
        row = (places[:, 1, None] + points[None, :, 1]) * inverse
        column = np.rint((column * camera.fx + camera.cx) / stride)
        row = np.rint((row * camera.fy + camera.cy) / stride)
        high, wide = self.depth.shape
        inside = (column >= 0) & (column < wide) & (row >= 0) & (row < high) & (depth > 1e-3)
        index = np.where(inside, row * wide + column, 0).astype(np.int64)
        seen = np.where(inside, self.depth.ravel()[index], -np.inf)
        return seen, depth
