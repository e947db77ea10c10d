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

# Size of a smooth error [m], its lengths, each with a third of its variance [px], and the distance
# of knots in lengths. One image of one small part tells neither: of the sizes that the diagnosis
# goes by the largest is taken, and its lengths alike: an error of the camera that is taken for
# none becomes one of the material.
SIZE, _LENGTHS, _SPACING = 0.0004, (40.0, 80.0, 160.0), 0.6
# Standard deviations of what an outline is off by: everywhere, in a direction, at a place [px].
_EVERYWHERE, _DIRECTION, _PLACE = 0.5, 0.2, 0.2
_CELL = 40.0
# What the whole depth image may be off by in each direction, beside its outlines [px].
IMAGE_SHIFT = 0.15
_OCTANTS = 8


@dataclass(frozen=True)
class SmoothField:
    """A depth error that is smooth over a part of the image.

    Attributes:
        knots: column and row [px], shape (K, 2), for each length.
    """

    knots: tuple[FloatArray, ...]

    @classmethod
    def over(cls, low: FloatArray, high: FloatArray) -> 'SmoothField':
        """Return one over the pixels between two corners, shape (2,) each."""
        return cls(tuple(_knots(low, high, _SPACING * length) for length in _LENGTHS))

    @property
    def count(self) -> int:
        """Number of unknowns."""
        return sum(len(own) for own in self.knots)

    def columns(self, pixels: FloatArray) -> FloatArray:
        """Return what independent unknowns of variance one do to pixels, shape (M, K)."""
        columns = []
        for knots, length in zip(self.knots, _LENGTHS, strict=True):
            own = _kernel(knots, knots, length) + 1e-6 * np.eye(len(knots))
            factor = np.linalg.cholesky(own)
            columns.append(np.linalg.solve(factor, _kernel(knots, pixels, length)).T)
        return np.hstack(columns) / np.sqrt(len(_LENGTHS))


def _knots(low: FloatArray, high: FloatArray, spacing: float) -> FloatArray:
    ticks = [
        np.linspace(first, last, max(2, int(np.ceil((last - first) / spacing)) + 1))
        for first, last in zip(low - 0.5 * spacing, high + 0.5 * spacing, strict=True)
    ]
    return np.stack(np.meshgrid(*ticks), axis=-1).reshape(-1, 2)


def _kernel(first: FloatArray, second: FloatArray, length: float) -> FloatArray:
    square = ((first[:, None] - second[None]) ** 2).sum(axis=2)
    return np.asarray(np.exp(-square / length**2))


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
