# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A surface in view reduced to a few points, those of the space beside it among them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


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


def spread(count: int, wanted: int) -> NDArray[np.int64]:
    """Return at most so many numbers, evenly spread over a random order that never changes."""
    return np.random.default_rng(11).permutation(count)[:wanted]
