# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A cup that hangs below a body, into which a tap drips."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.setups import Observation, Setup
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.springs import around


def filling_masses(
    masses: FloatArray, shares: FloatArray, setup: Setup, observation: Observation, faults: Faults
) -> FloatArray:
    """Return the masses of nodes from which a cup hangs in one pose [kg], shape (N,).

    Args:
        masses: of nodes, by which they share it, shape (N,).
        shares: of the free length at which they lie, shape (N,).
        setup: the rig.
        observation: the pose.
        faults: say how heavy the cup is at last, how much of that it is in each pose, and where.
    """
    grams = faults.mass_shares[setup.pose_number(observation)] * faults.added_mass
    return around(1e-3 * grams, faults.added_mass_at, masses, shares)


def filled_shares(count: int, empty: float) -> tuple[float, ...]:
    """Return how heavy a cup is in each pose that fills as fast all the time, 1 at last.

    Args:
        count: of poses, which are as far apart in time.
        empty: how heavy it is in the first, with what it holds.
    """
    return tuple(round(float(share), 4) for share in np.linspace(empty, 1.0, count))
