# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Shorten cables in quasi-static steps: a stiff cable pulled far at once folds a soft body."""

from collections.abc import Sequence
from dataclasses import replace

from diffcal_ros.fem.statics.equilibrium import Equilibrium, EquilibriumError, EquilibriumSolver
from diffcal_ros.fem.terms.cable import CableTerm
from diffcal_ros.fem.terms.conditions import CableState
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Of the routed length, taken up by one step: what a straight finger needs to bend by 20 degrees.
_FIRST_FRACTION = 0.03
_LARGEST_FRACTION = 0.08
_GROWTH = 1.5
_SMALLEST_STEP = 1e-3  # Of the whole way.


def needs_steps(cables: Sequence[CableTerm], positions: FloatArray) -> bool:
    """Tell whether some cable would shorten by more than one step's share."""
    return any(
        cable.length(positions) - cable.state.rest_length > _FIRST_FRACTION * cable.route_length
        for cable in cables
        if cable.state.stiffness != 0.0
    )


def loosen(cables: Sequence[CableTerm], positions: FloatArray) -> tuple[CableState, ...]:
    """Let cables hang slack at some positions; return how they are to be."""
    wanted = tuple(cable.state for cable in cables)
    for cable, state in zip(cables, wanted, strict=True):
        slack = cable.length(positions) + cable.route_length
        cable.state = replace(state, rest_length=max(state.rest_length, slack))
    return wanted


def tighten(
    cables: Sequence[CableTerm],
    wanted: Sequence[CableState],
    solver: EquilibriumSolver,
    loads: FloatArray,
    start: FloatArray,
) -> Equilibrium:
    """Shorten cables from where they are just taut; their states are the wanted ones then.

    Args:
        cables: of the body.
        wanted: their states at the end.
        solver: with the cables among its terms.
        loads: external forces [N], shape (N, 3).
        start: equilibrium with slack cables [m], shape (N, 3).

    Raises:
        EquilibriumError: when they cannot be shortened so far.
    """
    taut = [cable.length(start) for cable in cables]
    ways = [length - state.rest_length for length, state in zip(taut, wanted, strict=True)]
    fractions = [way / cable.route_length for way, cable in zip(ways, cables, strict=True)]
    whole = max(*fractions, _FIRST_FRACTION)
    done, step, positions = 0.0, _FIRST_FRACTION / whole, start
    while True:
        trial = min(1.0, done + step)
        for cable, state, way in zip(cables, wanted, ways, strict=True):
            left = max(way, 0.0) * (1.0 - trial)
            cable.state = replace(state, rest_length=state.rest_length + left)
        try:
            found = solver.solve(loads, positions)
        except EquilibriumError as error:
            step *= 0.5
            if step < _SMALLEST_STEP:
                raise EquilibriumError(
                    f'the cables got stuck after {done:.0%} of their pull: {error}'
                ) from error
            continue
        if trial == 1.0:
            return found
        done, positions = trial, found.positions
        step = min(_GROWTH * step, _LARGEST_FRACTION / whole)
