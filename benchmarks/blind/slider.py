# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A weight that slides along a body on a spring."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.setups import Observation, Setup
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.springs import around

_STOPS = (0.05, 0.97)  # Shares of the free length between which it slides.


def slid_to(observation: Observation, faults: Faults) -> float:
    """Return the share of the free length at which a weight comes to rest in one pose.

    Its spring lets it go by the part of its weight along the body, as that is held.

    Args:
        observation: the pose.
        faults: say where it is on a level body, and how far its spring lets it go.
    """
    down = -float(observation.world_from_object[1, 0])
    return float(np.clip(faults.added_mass_at + faults.mass_travel * down, *_STOPS))


def slider_masses(
    masses: FloatArray, shares: FloatArray, setup: Setup, observation: Observation, faults: Faults
) -> FloatArray:
    """Return the masses of nodes that bear a sliding weight in one pose [kg], shape (N,).

    Args:
        masses: of nodes, by which they share it, shape (N,).
        shares: of the free length at which they lie, shape (N,).
        setup: the rig.
        observation: the pose.
        faults: say how heavy it is, and how it slides.
    """
    return around(1e-3 * faults.added_mass, slid_to(observation, faults), masses, shares)
