# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A loose spring around a body, whose inner end is fixed and which its own weight draws out."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.setups import Observation, Setup
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.springs import around

_COILS = 24  # By which it is followed.


def coil_places(observation: Observation, faults: Faults) -> FloatArray:
    """Return the shares of the free length at which coils come to rest in one pose, shape (K,).

    Each bears the weight along the body, as that is held, of all beyond it.

    Args:
        observation: the pose.
        faults: say where the inner end is, how long the spring is on a level body, and by how much
            longer where that points straight down.
    """
    down = -float(observation.world_from_object[1, 0])
    inside = (np.arange(_COILS) + 0.5) / _COILS
    drawn = faults.mass_travel * down * inside * (2.0 - inside)
    return np.asarray(faults.added_mass_at + faults.mass_coiled * inside + drawn)


def slinky_masses(
    masses: FloatArray, shares: FloatArray, setup: Setup, observation: Observation, faults: Faults
) -> FloatArray:
    """Return the masses of nodes that bear a loose spring in one pose [kg], shape (N,).

    Args:
        masses: of nodes, by which they share it, shape (N,).
        shares: of the free length at which they lie, shape (N,).
        setup: the rig.
        observation: the pose.
        faults: say how heavy it is, and how it lies.
    """
    one = 1e-3 * faults.added_mass / _COILS
    coils = [around(one, float(at), masses, shares) for at in coil_places(observation, faults)]
    return np.asarray(np.sum(coils, axis=0))
