# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A folded card that stands like a tent, as a penalty in the object frame."""

import numpy as np

from benchmarks.blind.crate import waved
from benchmarks.blind.equilibrium import PotentialLaw
from benchmarks.blind.faults import Faults
from benchmarks.blind.setups import Observation
from benchmarks.blind.shapes import FloatArray


def tent_tops(points: FloatArray, faults: Faults) -> FloatArray:
    """Return how high a tent's ridge may lie before it touches each node [m], shape (N,).

    Args:
        points: in the world [m], shape (N, 3).
        faults: say where the ridge is and across which way, how steep and how sharp the tent is.
    """
    return np.asarray(points[:, 1] - _roof(points, faults)[0])


def tent(observation: Observation, faults: Faults, stiffness: FloatArray) -> PotentialLaw:
    """Return a tent without friction.

    Args:
        observation: the pose.
        faults: as above, and how high its ridge is.
        stiffness: force by dent, upright, at each node [N/m], shape (N,).
    """
    return waved(observation, faults, stiffness, _roof)


def _roof(points: FloatArray, faults: Faults) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return how high a tent is over its ridge [m], and its two derivatives by places.

    It is a hyperbola: as steep as told far from the ridge, and round there.

    Args:
        points: in the world [m], shape (N, 3).
        faults: as above.

    Returns:
        Heights [m], shape (N,), slopes, shape (N, 3), and curvatures [1/m], shape (N, 3, 3).
    """
    steep, round_ = faults.contact_steep, faults.contact_round
    slant = np.deg2rad(faults.contact_slant)
    way = np.array([np.cos(slant), 0.0, np.sin(slant)])
    across = (points - [faults.contact_ahead, 0.0, faults.contact_at]) @ way
    # Its radius of curvature at the ridge is what is told.
    blunt = steep * round_
    far = np.hypot(across, blunt)
    curve = -steep * blunt**2 / far**3
    return (
        -steep * (far - blunt),
        -steep * (across / far)[:, None] * way,
        curve[:, None, None] * np.outer(way, way),
    )
