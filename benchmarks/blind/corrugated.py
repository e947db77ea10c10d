# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A corrugated sheet, which waves along one way, as a penalty in the object frame."""

import numpy as np

from benchmarks.blind.crate import waved
from benchmarks.blind.equilibrium import PotentialLaw
from benchmarks.blind.faults import Faults
from benchmarks.blind.setups import Observation
from benchmarks.blind.shapes import FloatArray


def corrugated_tops(points: FloatArray, faults: Faults) -> FloatArray:
    """Return how high a sheet's crests may lie before it touches each node [m], shape (N,).

    Args:
        points: in the world [m], shape (N, 3).
        faults: say where a crest is, which way it waves, how far and how deep.
    """
    return np.asarray(points[:, 1] - _waves(points, faults)[0])


def corrugated(observation: Observation, faults: Faults, stiffness: FloatArray) -> PotentialLaw:
    """Return a sheet without friction.

    Args:
        observation: the pose.
        faults: as above, and how high its crests are.
        stiffness: force by dent, upright, at each node [N/m], shape (N,).
    """
    return waved(observation, faults, stiffness, _waves)


def _waves(points: FloatArray, faults: Faults) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return how high a sheet is over its crests [m], and its two derivatives by places.

    Args:
        points: in the world [m], shape (N, 3).
        faults: as above.

    Returns:
        Heights [m], shape (N,), slopes, shape (N, 3), and curvatures [1/m], shape (N, 3, 3).
    """
    rate, half = 2.0 * np.pi / faults.contact_wave, 0.5 * faults.contact_trough
    slant = np.deg2rad(faults.contact_slant)
    way = np.array([np.cos(slant), 0.0, np.sin(slant)])
    along = rate * ((points - [faults.contact_ahead, 0.0, faults.contact_at]) @ way)
    curve = -half * rate**2 * np.cos(along)[:, None, None] * np.outer(way, way)
    return half * (np.cos(along) - 1.0), -half * rate * np.sin(along)[:, None] * way, curve
