# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What pixels of one image are off by together: unknowns that are fitted beside a pose.

A depth error that is smooth over the image has the covariance s^2 exp(-|u|^2 / l^2)
(docs/diagnosis.md, "The sensor"). A Gaussian process on a grid of knots (Nystroem) carries it.
An outline is found a little outside or inside of where it is, by as much everywhere, or wherever
it runs in one direction, as along a row of pixels, or from place to place.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Length of a smooth error, and distance of knots [px].
LENGTH, _SPACING = 80.0, 48.0
# Standard deviations of what an outline is off by: everywhere, in a direction, at a place [px].
_EVERYWHERE, _DIRECTION, _PLACE = 0.5, 0.2, 0.2
_CELL = 40.0
_OCTANTS = 8


@dataclass(frozen=True)
class SmoothField:
    """A depth error that is smooth over a part of the image.

    Attributes:
        knots: column and row [px], shape (K, 2).
    """

    knots: FloatArray

    @classmethod
    def over(cls, low: FloatArray, high: FloatArray) -> 'SmoothField':
        """Return one over the pixels between two corners, shape (2,) each."""
        ticks = [
            np.linspace(first, last, max(2, int(np.ceil((last - first) / _SPACING)) + 1))
            for first, last in zip(low - 0.5 * _SPACING, high + 0.5 * _SPACING, strict=True)
        ]
        return cls(np.stack(np.meshgrid(*ticks), axis=-1).reshape(-1, 2))

    def columns(self, pixels: FloatArray) -> FloatArray:
        """Return what independent unknowns of variance one do to pixels, shape (M, K)."""
        own = _kernel(self.knots, self.knots) + 1e-6 * np.eye(len(self.knots))
        factor = np.linalg.cholesky(own)
        return np.linalg.solve(factor, _kernel(self.knots, pixels)).T


def _kernel(first: FloatArray, second: FloatArray) -> FloatArray:
    square = ((first[:, None] - second[None]) ** 2).sum(axis=2)
    return np.asarray(np.exp(-square / LENGTH**2))


def outline_columns(pixels: FloatArray, normals: FloatArray, scale: FloatArray) -> FloatArray:
    """Return what independent unknowns of variance one do to an outline [m], shape (M, k).

    Args:
        pixels: column and row of each piece [px], shape (M, 2).
        normals: in the image, outward, shape (M, 2).
        scale: metres per pixel, shape (M,).
    """
    angle = np.arctan2(normals[:, 1], normals[:, 0])
    octant = np.round(angle / (2.0 * np.pi / _OCTANTS)).astype(np.int64) % _OCTANTS
    cells = np.floor(pixels / _CELL).astype(np.int64)
    places = np.column_stack([cells, octant])
    columns = [
        np.full((len(pixels), 1), _EVERYWHERE),
        _DIRECTION * _indicator(octant[:, None]),
        _PLACE * _indicator(places),
    ]
    return np.hstack(columns) * scale[:, None]


def _indicator(keys: IntArray) -> FloatArray:
    """Return one column of zeros and ones for each different row of keys, shape (M, k)."""
    if not len(keys):
        return np.zeros((0, 0))
    _, index = np.unique(keys, axis=0, return_inverse=True)
    return np.eye(int(index.max()) + 1)[index.ravel()]
