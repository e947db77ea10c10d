# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A rubber into which oil came from all sides: it creeps there, and hardly does so amid it."""

import numpy as np

from benchmarks.blind.setups import Setup
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.specimen import Specimen


def depth_below(specimen: Specimen, setup: Setup) -> FloatArray:
    """Return how far below the nearest side Gauss points lie [mm], shape (C, 8).

    Before the shape's map, as all that is told of a section.
    """
    body = specimen.body
    at_points = specimen.mesh.lattice[body.cells].swapaxes(1, 2) @ body.quadrature.values.T
    half = 0.5 * np.array(setup.shape.section)[:, None]
    return np.asarray(1e3 * (half - np.abs(at_points[:, 1:])).min(axis=1))


def oil_share(below: FloatArray, reach: float) -> FloatArray:
    """Return how much oil there is, 1 at the surface.

    Args:
        below: how far below that [mm], any shape.
        reach: over which there is a third as much [mm].
    """
    return np.asarray(np.exp(-np.maximum(below, 0.0) / reach))
