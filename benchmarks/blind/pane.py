# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A pane before a camera, through which all is seen nearer along the pane's normal."""

from dataclasses import replace

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.surface import Triangles

_INDEX = 1.49  # Of acrylic.
_ROUNDS = 6  # In which the direction of a ray is found to some nanometres.


def apparent(points: FloatArray, thickness: float, normal: FloatArray) -> FloatArray:
    """Return where points seem to be that are seen through a pane, by Snell's law, shape (..., 3).

    Args:
        points: camera frame [m], shape (..., 3).
        thickness: of the pane [m].
        normal: of it, away from the camera, shape (3,).
    """
    seen = points
    for _ in range(_ROUNDS):
        # The ray that comes to the camera is that from where a point seems to be.
        cosine = seen @ normal / np.linalg.norm(seen, axis=-1)
        inside = np.sqrt(1.0 - (1.0 - cosine**2) / _INDEX**2)
        nearer = thickness * (1.0 - cosine / (_INDEX * inside))
        seen = points - nearer[..., None] * normal
    return np.asarray(seen)


def through_pane(surface: Triangles, faults: Faults) -> Triangles:
    """Return a surface in the camera frame as it is seen."""
    if not faults.pane:
        return surface
    corners = apparent(surface.corners, 1e-3 * faults.pane, np.array(faults.pane_normal))
    return replace(surface, corners=corners)
