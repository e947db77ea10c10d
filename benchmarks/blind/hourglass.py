# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""An hourglass that lies along a body: two bulbs, between which sand runs down."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.setups import Observation, Setup
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.springs import around

_SAGGED = 10.0  # By how much a body may point up and yet sag below the level [deg].


def outer_sand(setup: Setup, faults: Faults, number: int) -> float:
    """Return which part of an hourglass's sand is in its outer bulb in a pose, 0 to 1.

    All of it is in the inner bulb when a body is put into its first pose. Sand runs as fast
    however much lies above (Beverloo 1961, Chem. Eng. Sci. 15), to the bulb that is lower; a level
    body sags, so that this is the outer one.

    Args:
        setup: with its poses, which are alike in time.
        faults: say which part of the sand runs down in a pose.
        number: of the pose, from 0, when it is filmed.
    """
    outer = 0.0
    for pose in setup.observations[: number + 1]:
        is_up = float(pose.world_from_object[1, 0]) > np.sin(np.deg2rad(_SAGGED))
        outer += -faults.mass_flow if is_up else faults.mass_flow
        outer = float(np.clip(outer, 0.0, 1.0))
    return outer


def hourglass_masses(
    masses: FloatArray, shares: FloatArray, setup: Setup, observation: Observation, faults: Faults
) -> FloatArray:
    """Return the masses of nodes that bear an hourglass's sand in one pose [kg], shape (N,).

    Args:
        masses: of nodes, by which they share it, shape (N,).
        shares: of the free length at which they lie, shape (N,).
        setup: the rig.
        observation: the pose.
        faults: say how heavy the sand is, where both bulbs are, and how fast it runs.
    """
    inner, outer = faults.mass_stops
    part, whole = outer_sand(setup, faults, setup.pose_number(observation)), faults.added_mass
    found = around(1e-3 * (1.0 - part) * whole, inner, masses, shares)
    return found + around(1e-3 * part * whole, outer, masses, shares)
