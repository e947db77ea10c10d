# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A saddle, which rises along one way and falls along the other, as a penalty."""

import numpy as np

from benchmarks.blind.crate import waved
from benchmarks.blind.equilibrium import PotentialLaw
from benchmarks.blind.faults import Faults
from benchmarks.blind.setups import Observation
from benchmarks.blind.shapes import FloatArray


def saddle_tops(points: FloatArray, faults: Faults) -> FloatArray:
    """Return how high a saddle's middle may lie before it touches each node [m], shape (N,).

    Args:
        points: in the world [m], shape (N, 3).
        faults: say where its middle is, along which way it rises, and how round it is.
    """
    return np.asarray(points[:, 1] - _seat(points, faults)[0])


def saddle(observation: Observation, faults: Faults, stiffness: FloatArray) -> PotentialLaw:
    """Return a saddle without friction.

    Args:
        observation: the pose.
        faults: as above, and how high its middle is.
        stiffness: force by dent, upright, at each node [N/m], shape (N,).
    """
    return waved(observation, faults, stiffness, _seat)


def _seat(points: FloatArray, faults: Faults) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return how high a saddle is over its middle [m], and its two derivatives by places.

    It is as round across its ridge as along it, by the squares of both ways.

    Args:
        points: in the world [m], shape (N, 3).
        faults: as above.

    Returns:
        Heights [m], shape (N,), slopes, shape (N, 3), and curvatures [1/m], shape (N, 3, 3).
    """
    slant = 2.0 * np.deg2rad(faults.contact_slant)
    one, other = np.cos(slant), np.sin(slant)
    bend = np.array([[one, 0.0, other], [0.0, 0.0, 0.0], [other, 0.0, -one]])
    bend /= faults.contact_round
    away = points - [faults.contact_ahead, 0.0, faults.contact_at]
    slopes = away @ bend
    return (
        0.5 * (slopes * away).sum(axis=1),
        slopes,
        np.broadcast_to(bend, (len(points), 3, 3)),
    )
