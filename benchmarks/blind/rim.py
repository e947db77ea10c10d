# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The round rim of a bucket, which a body's outer part lies across, as a penalty."""

import numpy as np

from benchmarks.blind.crate import waved
from benchmarks.blind.equilibrium import PotentialLaw
from benchmarks.blind.faults import Faults
from benchmarks.blind.setups import Observation
from benchmarks.blind.shapes import FloatArray

_LEVEL = np.array([1.0, 0.0, 1.0])
_AMID = 1e-4  # Nearer to the bucket's middle than which nothing is at its rim [m].


def rim_tops(points: FloatArray, faults: Faults) -> FloatArray:
    """Return how high a rim may lie before it touches each node [m], shape (N,).

    Args:
        points: in the world [m], shape (N, 3).
        faults: say where the bucket's middle is, how wide it is, and how round its rim.
    """
    return np.asarray(points[:, 1] - _brim(points, faults)[0])


def rim(observation: Observation, faults: Faults, stiffness: FloatArray) -> PotentialLaw:
    """Return a rim without friction.

    Args:
        observation: the pose.
        faults: as above, and how high it is.
        stiffness: force by dent, upright, at each node [N/m], shape (N,).
    """
    return waved(observation, faults, stiffness, _brim)


def _brim(points: FloatArray, faults: Faults) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return how high a surface is over a rim's crest [m], and its two derivatives by places.

    By the square of the way from the crest, a circle, over twice the radius of its rounding.

    Args:
        points: in the world [m], shape (N, 3).
        faults: as above.

    Returns:
        Heights [m], shape (N,), slopes, shape (N, 3), and curvatures [1/m], shape (N, 3, 3).
    """
    away = (points - [faults.contact_ahead, 0.0, faults.contact_at]) * _LEVEL
    far = np.maximum(np.linalg.norm(away, axis=1), _AMID)
    out, ways = far - faults.contact_ring, away / far[:, None]
    outer = ways[:, :, None] * ways[:, None, :]
    around = (out / far)[:, None, None] * (np.diag(_LEVEL) - outer)
    return (
        -0.5 * out**2 / faults.contact_round,
        -out[:, None] * ways / faults.contact_round,
        -(outer + around) / faults.contact_round,
    )
