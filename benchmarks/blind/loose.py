# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A ring that fits a body loosely, and slides along it where that is steep."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.setups import Observation, Setup
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.springs import around

_STEEP = np.sin(np.deg2rad(14.0))  # Sine of the slope on which a ring begins to slide.


def ring_masses(
    masses: FloatArray, shares: FloatArray, setup: Setup, observation: Observation, faults: Faults
) -> FloatArray:
    """Return the masses of nodes that a loose ring adds to in one pose [kg], shape (N,).

    Args:
        masses: of nodes, by which they share it, shape (N,).
        shares: of the free length at which they lie, shape (N,).
        setup: the rig.
        observation: the pose.
        faults: say how heavy the ring is and where it slides.
    """
    at = ring_place(setup, observation, faults)
    return around(1e-3 * faults.added_mass, at, masses, shares)


def ring_place(setup: Setup, observation: Observation, faults: Faults) -> float:
    """Return the share of the free length where a ring lies that slid in all poses so far."""
    inner, outer = faults.mass_stops
    at = faults.added_mass_at
    for before in setup.observations[: setup.pose_number(observation) + 1]:
        rise = float(before.world_from_object[1, 0])
        if abs(rise) > _STEEP:
            at = inner if rise > 0.0 else outer
    return at
