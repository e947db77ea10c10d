# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A clip that somebody hangs on a body between two poses."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.setups import Observation, Setup
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.springs import around


def hung_masses(
    masses: FloatArray, shares: FloatArray, setup: Setup, observation: Observation, faults: Faults
) -> FloatArray:
    """Return the masses of nodes that a clip adds to in one pose [kg], shape (N,).

    Args:
        masses: of nodes, by which they share it, shape (N,).
        shares: of the free length at which they lie, shape (N,).
        setup: the rig.
        observation: the pose.
        faults: say how heavy the clip is, where it hangs, and from which pose on.
    """
    if setup.pose_number(observation) < faults.mass_from:
        return np.zeros(len(masses))
    return around(1e-3 * faults.added_mass, faults.added_mass_at, masses, shares)
