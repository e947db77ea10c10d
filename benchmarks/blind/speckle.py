# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Dots at random places of a surface, for a correlation of images, squares, stickers, nets."""

import numpy as np
from numpy.typing import NDArray

from benchmarks.blind.shapes import FloatArray

_PERIOD = 64  # Dots along each axis after which their pattern comes again.


def speckled(
    points: FloatArray, edge: float, cover: FloatArray | float, seed: int
) -> NDArray[np.bool_]:
    """Return which points lie in a dot: one of the cubes of a grid that were drawn, (...).

    Args:
        points: before the shape's map [m], shape (..., 3).
        edge: of a cube [m].
        cover: share of the cubes that are dots, the same all over or at each point, (...).
        seed: of their draw.
    """
    x, y, z = np.moveaxis(np.floor(points / edge).astype(np.int64) % _PERIOD, -1, 0)
    drawn = np.random.default_rng(seed).random((_PERIOD,) * 3)
    return np.asarray(drawn[x, y, z] < cover)


def on_board(points: FloatArray, edge: float) -> NDArray[np.bool_]:
    """Return which points lie in a dark square of a chequered sheet, (...).

    On each flat side of a body the cubes of a grid are squares, every other of which is dark.

    Args:
        points: before the shape's map [m], shape (..., 3).
        edge: of a square [m].
    """
    return np.asarray(np.floor(points / edge).astype(np.int64).sum(axis=-1) % 2 == 0)


def stickered(points: FloatArray, axis: int, apart: float, radius: float) -> NDArray[np.bool_]:
    """Return which points of one side lie on a round sticker of a row along its middle, (...).

    Args:
        points: before the shape's map [m], shape (..., 3).
        axis: across which the side lies; across x, on an end, there are none.
        apart: from sticker to sticker, the first half of that from where x is 0 [m].
        radius: of each [m].
    """
    if axis == 0:
        return np.zeros(points.shape[:-1], dtype=bool)
    ahead = (points[..., 0] / apart) % 1.0 - 0.5
    return np.asarray((apart * ahead) ** 2 + points[..., 3 - axis] ** 2 < radius**2)


def netted(points: FloatArray, axis: int, apart: float, cover: float) -> NDArray[np.bool_]:
    """Return which points of one side lie below a thread of a net, shape (...).

    Its threads go at 45 degrees to the body's length, either way.

    Args:
        points: before the shape's map [m], shape (..., 3).
        axis: across which the side lies.
        apart: from knot to knot along the body [m].
        cover: which share of that a thread covers.
    """
    ahead, aside = np.moveaxis(np.delete(points, axis, axis=-1), -1, 0)
    one, other = (ahead + aside) / apart % 1.0, (ahead - aside) / apart % 1.0
    return np.asarray((one < cover) | (other < cover))
