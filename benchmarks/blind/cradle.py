# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A weight that hangs below a body in two threads, from two of its places."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.setups import Observation, Setup
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.springs import around


def outer_part(down: FloatArray, drop: float, apart: float) -> float:
    """Return which part of a weight the outer one of two threads bears.

    Both are as long, and make a triangle with the body that swings about that: where the body
    slopes, the weight hangs nearer to the higher place, until the other thread is slack. What
    draws both places together is left out: along itself a body hardly gives way.

    Args:
        down: where gravity points, object frame, shape (3,).
        drop: how far the weight hangs below the body, square to that [m].
        apart: way from the inner place to the outer one [m].
    """
    across = max(float(np.hypot(down[1], down[2])), 1e-9)
    return float(np.clip(0.5 - drop / apart * float(down[0]) / across, 0.0, 1.0))


def cradled_masses(
    masses: FloatArray, shares: FloatArray, setup: Setup, observation: Observation, faults: Faults
) -> FloatArray:
    """Return the masses of nodes that bear a cradled weight in one pose [kg], shape (N,).

    Args:
        masses: of nodes, by which they share it, shape (N,).
        shares: of the free length at which they lie, shape (N,).
        setup: the rig.
        observation: the pose.
        faults: say how heavy the weight is, at which places it hangs, and how far below them.
    """
    inner, outer = faults.mass_stops
    away = (outer - inner) * (setup.shape.length - setup.shape.clamp)
    part = outer_part(-observation.world_from_object[1, :3], faults.mass_drop, away)
    whole = 1e-3 * faults.added_mass
    found = around((1.0 - part) * whole, inner, masses, shares)
    return found + around(part * whole, outer, masses, shares)
