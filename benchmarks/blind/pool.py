# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A liquid in a closed channel along a body, which runs to where that is lowest."""

from collections.abc import Callable

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.setups import GRAVITY
from benchmarks.blind.shapes import FloatArray

_CLEAR = 0.004  # Height of the channel [m].
_ROUNDS = 60  # In which the level is halved to where the channel holds all.


def channel(
    lattice: FloatArray, masses: FloatArray, shares: FloatArray, faults: Faults
) -> FloatArray:
    """Return how much a channel along the middle of the upper side can hold [kg], shape (N,).

    Args:
        lattice: nodes before the shape's map [m], shape (N, 3).
        masses: of nodes, by which they share it, shape (N,).
        shares: of the free length at which they lie, shape (N,).
        faults: say how heavy the liquid is, where the channel ends, and how full it is.
    """
    inner, outer = faults.mass_stops
    width, top = np.abs(lattice[:, 1]), lattice[:, 2].max()
    along = (width < 1e-9) & (lattice[:, 2] > top - 1e-9) & (shares > inner) & (shares < outer)
    part = np.abs(masses) * along
    return np.asarray(1e-3 * faults.added_mass / faults.mass_filled * part / part.sum())


def pooled(
    room: FloatArray, total: float
) -> Callable[[FloatArray], tuple[FloatArray, FloatArray, FloatArray]]:
    """Return energy, weight and curve of a liquid with a level surface, by heights of nodes [m].

    Each part of the channel is filled as far as the level reaches up in it. Of all ways to share
    the liquid that has the least energy: by how a part's height changes, so does the energy as if
    what is in it stayed. The curve is told as 0; it is negative, so that Newton's steps descend.

    Args:
        room: for the liquid at each node [kg], shape (N,).
        total: mass of the liquid, less than all of that [kg].
    """
    there = room > 0.0

    def rule(heights: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        held, most = np.zeros(len(room)), room[there]
        low, high = heights[there].min() - _CLEAR, heights[there].max() + _CLEAR
        for _ in range(_ROUNDS):
            level = 0.5 * (low + high)
            filled = np.clip((level - heights[there]) / _CLEAR + 0.5, 0.0, 1.0)
            low, high = (low, level) if most @ filled > total else (level, high)
        held[there] = most * filled
        # What fills a part of the channel lies on its bottom first.
        lifted = np.zeros(len(room))
        lifted[there] = 0.5 * _CLEAR * most * (filled - 1.0) * filled
        weight = GRAVITY * held
        return weight * heights + GRAVITY * lifted, weight, np.zeros(len(room))

    return rule


def liquid(
    lattice: FloatArray, masses: FloatArray, shares: FloatArray, faults: Faults
) -> Callable[[FloatArray], tuple[FloatArray, FloatArray, FloatArray]]:
    """Return that of the channel that faults tell of."""
    return pooled(channel(lattice, masses, shares, faults), 1e-3 * faults.added_mass)
