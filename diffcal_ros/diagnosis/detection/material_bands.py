# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bands along a body that a depth camera reads too far or too near by one height.

Tape, paint and rings of another silicone begin and end more than once. With jumps of depth in the
model by their tangents, what any set of borders explains is known from the inner products of those
jumps: the jump of a set is their sum with signs in turn. Sets are searched by moves of one border
or two, as long as one pays for its borders.
"""

from itertools import combinations

from diffcal_ros.diagnosis.detection.depth_discontinuity import (
    beyond,
    Jumps,
    jumps_seen,
    OF_SMOOTH,
    softened,
    with_jumps,
)
from diffcal_ros.diagnosis.detection.material_boundary import LEFT
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.effects import bands
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

# Places of borders that are tried, as shares of the free length.
_PLACES = np.linspace(0.04, 0.96, 47).round(3).tolist()
# A border was chosen among so many places: what each has to explain of chi-square (BIC's penalty
# for a discrete choice).
_PRICE = 2.0 * np.log(len(_PLACES))
_STARTS = 6
# What comes up over five places instead has to leave more: else it is no jump, but the form of
# something smooth.
_SMOOTHED = 2


def find_bands(evaluator: PatchEvaluator, nominal: Refit) -> tuple[tuple[float, ...], float]:
    """Return where bands begin and end, and the chi-square that the best ones leave.

    Args:
        evaluator: of the nominal model.
        nominal: its fit.

    Returns:
        Shares of the free length, none where no bands stand out, and what is left by the best.
    """
    if not evaluator.is_measured:
        return (), np.inf
    jumps = jumps_seen(with_jumps(evaluator, nominal, beyond(_PLACES)), nominal)
    chosen = best_borders(jumps)
    left = jumps.whole - float(jumps.gains(_signs(chosen[None]))[0][0])
    if chosen.sum() < 2 or not _stands_out(jumps, chosen):
        return (), left
    return tuple(_PLACES[number] for number in np.flatnonzero(chosen)), left


def best_borders(jumps: Jumps) -> BoolArray:
    """Return which borders together explain most for what they cost, shape (s,)."""
    moves = _moves(len(jumps.pulls))
    gains, _ = jumps.gains(_signs(moves))
    ends = [_climb(jumps, moves[start], moves) for start in np.argsort(-gains)[:_STARTS]]
    return max(ends, key=lambda chosen: float(_worth(jumps, chosen[None])[0]))


def _climb(jumps: Jumps, chosen: BoolArray, moves: BoolArray) -> BoolArray:
    """Move, add and take away borders as long as that pays."""
    worth = float(_worth(jumps, chosen[None])[0])
    while True:
        others = chosen ^ moves
        counts = others.sum(axis=1)
        others = others[(counts > 0) & (counts <= len(bands.NAMES))]
        worths = _worth(jumps, others)
        best = int(worths.argmax())
        if worths[best] <= worth:
            return chosen
        chosen, worth = others[best], float(worths[best])


def _worth(jumps: Jumps, chosen: BoolArray) -> FloatArray:
    """Return what sets of borders explain, less what those cost, shape (m,)."""
    gains, _ = jumps.gains(_signs(chosen))
    return np.asarray(gains - _PRICE * chosen.sum(axis=1))


def _stands_out(jumps: Jumps, chosen: BoolArray) -> bool:
    """Tell whether bands leave far less than none, than one border and than soft ones."""
    signs = _signs(chosen[None])
    several = np.vstack([signs, softened(signs, _SMOOTHED), np.eye(len(chosen))])
    left = jumps.whole - jumps.gains(several)[0]
    one = left[2:].min()
    return bool(left[0] < LEFT * min(jumps.whole, one) and left[0] < OF_SMOOTH * left[1])


def _signs(chosen: BoolArray) -> FloatArray:
    """Return by how much each jump is in each set: up, down, up ..., shape (m, s)."""
    ranks = np.cumsum(chosen, axis=1)
    return np.where(chosen, np.where(ranks % 2 == 1, 1.0, -1.0), 0.0)


def _moves(count: int) -> BoolArray:
    """Return what changes one border or two, shape (m, count)."""
    pairs = list(combinations(range(count), 2))
    moves = np.zeros((count + len(pairs), count), dtype=bool)
    moves[:count] = np.eye(count, dtype=bool)
    for row, pair in enumerate(pairs, count):
        moves[row, list(pair)] = True
    return moves
