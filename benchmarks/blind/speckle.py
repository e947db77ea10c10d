# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Dots at random places of a surface, for a correlation of images, and a board's squares."""

import numpy as np
from numpy.typing import NDArray

from benchmarks.blind.shapes import FloatArray

_PERIOD = 64  # Dots along each axis after which their pattern comes again.


def speckled(points: FloatArray, edge: float, cover: float, seed: int) -> NDArray[np.bool_]:
    """Return which points lie in a dot: one of the cubes of a grid that were drawn, (...).

    Args:
        points: before the shape's map [m], shape (..., 3).
        edge: of a cube [m].
        cover: share of the cubes that are dots.
        seed: of their draw.
    """
    x, y, z = np.moveaxis(np.floor(points / edge).astype(np.int64) % _PERIOD, -1, 0)
    drawn = np.random.default_rng(seed).random((_PERIOD,) * 3) < cover
    return np.asarray(drawn[x, y, z])


def on_board(points: FloatArray, edge: float) -> NDArray[np.bool_]:
    """Return which points lie in a dark square of a chequered sheet, (...).

    On each flat side of a body the cubes of a grid are squares, every other of which is dark.

    Args:
        points: before the shape's map [m], shape (..., 3).
        edge: of a square [m].
    """
    return np.asarray(np.floor(points / edge).astype(np.int64).sum(axis=-1) % 2 == 0)
