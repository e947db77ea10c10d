# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A wet cloth around a part of a body, which dries from pose to pose."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.setups import Observation, Setup
from benchmarks.blind.shapes import FloatArray


def cloth_masses(
    masses: FloatArray, shares: FloatArray, setup: Setup, observation: Observation, faults: Faults
) -> FloatArray:
    """Return the masses of nodes that a cloth adds to in one pose [kg], shape (N,).

    Args:
        masses: of nodes, by which they share it, shape (N,).
        shares: of the free length at which they lie, shape (N,).
        setup: the rig.
        observation: the pose.
        faults: say where the cloth is, how heavy at first, and how much of that each pose finds.
    """
    inner, outer = faults.mass_stops
    below = masses * ((shares > inner) & (shares < outer))
    grams = faults.added_mass * faults.mass_shares[setup.pose_number(observation)]
    return np.asarray(1e-3 * grams * below / below.sum())
