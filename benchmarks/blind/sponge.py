# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A wet sponge around a part of a body, whose water sinks to where that is lowest."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.setups import Observation, Setup
from benchmarks.blind.shapes import FloatArray


def sponge_masses(
    masses: FloatArray, shares: FloatArray, setup: Setup, observation: Observation, faults: Faults
) -> FloatArray:
    """Return the masses of nodes that a wet sponge adds to in one pose [kg], shape (N,).

    Water is held by suction: there is less of it by the exponential of the height of the body's
    middle line, where nothing is loaded. All of it stays in the sponge.

    Args:
        masses: of nodes, by which they share it, shape (N,).
        shares: of the free length at which they lie, shape (N,).
        setup: the rig.
        observation: the pose.
        faults: say where the sponge is, how heavy, and over which height its water falls.
    """
    inner, outer = faults.mass_stops
    below = masses * ((shares > inner) & (shares < outer))
    shape = setup.shape
    line = np.zeros((len(shares), 3))
    line[:, 0] = shape.clamp + shares * (shape.length - shape.clamp)
    heights = shape.place(line) @ observation.world_from_object[1, :3]
    middle = float(below @ heights / below.sum())
    wet = below * np.exp((middle - heights) / faults.mass_suction)
    return np.asarray(1e-3 * faults.added_mass * wet / wet.sum())
