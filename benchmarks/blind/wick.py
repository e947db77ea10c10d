# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A cord along a body that soaks up a liquid from its clamp on, farther from pose to pose."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.setups import Observation, Setup
from benchmarks.blind.shapes import FloatArray

_FRONT = 0.1  # Share of the free length over which a cord goes over from wet to dry.


def wick_masses(
    masses: FloatArray, shares: FloatArray, setup: Setup, observation: Observation, faults: Faults
) -> FloatArray:
    """Return the masses of nodes that a wet cord adds to in one pose [kg], shape (N,).

    What is wet is as heavy everywhere, so that all of it goes with how far that reaches.

    Args:
        masses: of nodes, by which they share it, shape (N,).
        shares: of the free length at which they lie, shape (N,).
        setup: the rig.
        observation: the pose.
        faults: say how heavy it is in the last pose, and how far it is wet in each.
    """
    front = faults.mass_places[setup.pose_number(observation)]
    wet = np.clip(0.5 + (front - shares) / _FRONT, 0.0, 1.0) * (shares > 0.0) * masses
    grams = faults.added_mass * front / faults.mass_places[-1]
    return np.asarray(1e-3 * grams * wet / wet.sum())
