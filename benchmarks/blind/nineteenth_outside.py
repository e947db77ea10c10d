# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the nineteenth set alone has.

Their second and third size change what is seen of a body by some 4 and 10 mm.
"""

import numpy as np

from benchmarks.blind.amplitudes import Drawer, Effect, number, signed
from benchmarks.blind.faults import Faults
from benchmarks.blind.setups import Setup
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.simulation import make_specimen, settle

_MOVES = (0.002, 0.004, 0.010)  # Of the tip [m].
_UNGLUED = (0.0, 0.3, 0.45, 0.6, 0.75, 0.9)  # Shares of the free length that are tried.


def unglued(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw how far two halves that were cast apart and glued have come apart, from the tip on."""
    whole, moves = _first_tip(setup, Faults()), [0.0]
    for share in _UNGLUED[1:]:
        tip = _first_tip(setup, Faults(unglued=share))
        moves.append(float(np.linalg.norm(tip - whole)))
        if moves[-1] > _MOVES[size]:
            # What hangs by its skin alone might not come to rest.
            break
    share = float(np.interp(_MOVES[size], moves, _UNGLUED[: len(moves)]))
    amount = min(number(share, random), _UNGLUED[-1])
    return Effect('unglued', {'share': amount}, 'of the free length', {'unglued': amount})


def _first_tip(setup: Setup, faults: Faults) -> FloatArray:
    """Return where a tip rests in the first pose, object frame [m], shape (3,)."""
    specimen = make_specimen(setup, faults)
    rest = settle(specimen, setup, setup.observations[0], faults)
    return np.asarray(rest[specimen.shares > 0.99].mean(axis=0))


def trailing(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw by how much a receiver errs that has not settled where a beam comes to a body."""
    amount = signed((2.0, 4.2, 10.5)[size], random)
    width = round(float(random.uniform(10.0, 18.0)), 3)
    amplitude: dict[str, float | str] = {'amount': amount, 'width': width}
    changes = {'trailing': amount, 'trailing_width': width}
    return Effect('trailing', amplitude, 'mm, px', changes)


NINETEENTH_OUTSIDE: dict[str, Drawer] = {drawer.__name__: drawer for drawer in (unglued, trailing)}
