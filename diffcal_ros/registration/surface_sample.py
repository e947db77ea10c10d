# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A surface in view reduced to a few points, those of the space beside it among them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True)
class ShapeSample:
    """Points of a body in the camera's orientation, from a point in its middle that is in view.

    Attributes:
        surface: of the free part in view [m], shape (N, 3); the first one is the origin.
        beside: just outside of its outline, at the body's depth [m], shape (M, 3).
        beyond: those of the latter that are beyond the free end [m], shape (L, 3).
        held: of the held part towards the camera [m], shape (K, 3).
        origin: of these points in the object frame, turned into the camera's axes [m], shape (3,).
    """

    surface: FloatArray
    beside: FloatArray
    beyond: FloatArray
    held: FloatArray
    origin: FloatArray


def spread_over(areas: FloatArray, count: int) -> tuple[IntArray, FloatArray]:
    """Place points on triangles in proportion to their areas, again and again the same ones.

    Args:
        areas: of the triangles, or in proportion to them, shape (F,).
        count: of points.

    Returns:
        The triangle of each point, shape (count,), and its corners' shares, shape (count, 3).
    """
    # One number each, spaced evenly: points follow the area.
    chosen = np.searchsorted(np.cumsum(areas) / areas.sum(), (np.arange(count) + 0.5) / count)
    shares = np.random.default_rng(7).dirichlet((1.0, 1.0, 1.0), count)
    return chosen.clip(max=len(areas) - 1), shares


def spread(count: int, wanted: int) -> IntArray:
    """Return at most so many numbers, evenly spread over a random order that never changes."""
    return np.random.default_rng(11).permutation(count)[:wanted]
