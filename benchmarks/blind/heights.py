# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forces that depend on how high a part of a body is, as energies of nodes in the object frame."""

from collections.abc import Callable

import numpy as np

from benchmarks.blind.equilibrium import Potential, PotentialLaw
from benchmarks.blind.faults import Faults
from benchmarks.blind.pool import liquid
from benchmarks.blind.setups import GRAVITY, Observation
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.springs import around

_DIPPED = 0.004  # Half the depth over which a part comes to be borne by a liquid [m].

# Energy [J], and its first and second derivative, by heights in the world [m], shape (N,) each.
_Rule = Callable[[FloatArray], tuple[FloatArray, FloatArray, FloatArray]]


def by_height(
    lattice: FloatArray,
    masses: FloatArray,
    shares: FloatArray,
    observation: Observation,
    faults: Faults,
) -> tuple[PotentialLaw, ...]:
    """Return what lifts or draws a body in one pose by where it is.

    Args:
        lattice: nodes before the shape's map [m], shape (N, 3).
        masses: of nodes [kg], shape (N,).
        shares: of the free length at which they lie, shape (N,).
        observation: the pose.
        faults: say what there is.
    """
    found = []
    if faults.screen:
        free = masses * (shares > 0.0)
        charges = faults.screen * free / free.sum()
        found.append(_law(_drawn(faults.screen_reach, charges), observation, 2))
    if faults.mass_form == 'trailing' and faults.added_mass:
        line = 1e-3 * faults.added_mass / faults.mass_drop
        at_side = masses * (lattice[:, 1] > 0.0)
        weights = GRAVITY * around(line, faults.added_mass_at, at_side, shares)
        found.append(_law(_hanging(faults.mass_table, weights), observation))
    if faults.mass_form == 'pooled' and faults.added_mass:
        found.append(_law(liquid(lattice, masses, shares, faults), observation))
    if faults.bath:
        borne = faults.bath * GRAVITY * masses * (shares > 0.0)
        found.append(_law(_borne(faults.bath_level, borne), observation))
    return tuple(found)


def _hanging(table: float, weights: FloatArray) -> _Rule:
    """Return a cable whose end lies on a table: what hangs is as long as a place is high.

    Args:
        table: how high it lies [m].
        weights: of the cable by its length at each node [N/m], shape (N,).
    """

    def rule(heights: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        hanging = np.maximum(heights - table, 0.0)
        return 0.5 * weights * hanging**2, weights * hanging, weights * (hanging > 0.0)

    return rule


def _borne(level: float, borne: FloatArray) -> _Rule:
    """Return a liquid that bears each part, all of it once that lies somewhat below the level.

    Args:
        level: how high that is [m].
        borne: force on each node that is below [N], shape (N,).
    """

    def rule(heights: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        below = (level - heights) / _DIPPED
        part = np.clip(0.5 * (below + 1.0), 0.0, 1.0)
        energy = np.where(below > 1.0, below, part**2)
        slope = 0.5 / _DIPPED * (np.abs(below) < 1.0)
        return _DIPPED * borne * energy, -borne * part, borne * slope

    return rule


def _drawn(reach: float, charges: FloatArray) -> _Rule:
    """Return a charged screen far below that draws by the exponential of the height.

    Args:
        reach: over which the force falls to a third [m].
        charges: force on each node at height 0 [N], shape (N,).
    """

    def rule(heights: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        force = charges * np.exp(-heights / reach)
        return -reach * force, force, -force / reach

    return rule


def _law(rule: _Rule, observation: Observation, axis: int = 1) -> PotentialLaw:
    """Return a rule by places along an axis of the world as a law in the object frame."""
    up, high = observation.world_from_object[axis, :3], observation.world_from_object[axis, 3]
    outer = np.outer(up, up)

    def law(positions: FloatArray) -> Potential:
        energy, slope, curve = rule(positions @ up + high)
        return Potential(
            energy=float(energy.sum()),
            gradient=slope[:, None] * up,
            diagonal=curve[:, None, None] * outer,
        )

    return law
