# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How much parts of a body are bent that was stored, moulded or mistreated in some way."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.hammock import catenary_lever, catenary_rate
from benchmarks.blind.mattress import bedded_lever, bedded_moment
from benchmarks.blind.over_rod import over_rod
from benchmarks.blind.rotations import rotation
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.slots import slotted
from benchmarks.blind.weaving import woven
from benchmarks.blind.wrapping import wrapped

_PARTS = 12  # Arcs that a helix is made of, and what hung for long.
_HELIX_TURN = np.deg2rad(150.0)  # Of the plane of bending, from the clamp to the tip.
_HELIX_MORE = 1.3  # Curvature over that of an arc.
_TRESTLE = 0.15  # Share of a mould's length at which a trestle stands, at either end.
_UNCOILED = 0.7  # Share by which a spiral's radius is smaller at the tip.
_KINK = 0.1  # Share of the free length of a kink, or of a fold.
_WAVE_PARTS = 60  # Arcs that waves are made of.
_CRAMMED = 0.15  # Share of the free length of a bend in a box.

# Begin and end of a part, as shares of the free length, and its curvature [1/m], shape (3,).
Part = tuple[float, float, FloatArray]


def bent_parts(curvature: FloatArray, faults: Faults) -> list[Part] | None:
    """Return parts of a body and how they are bent, the outer one first.

    Args:
        curvature: of an arc whose tip is about as far off [1/m], shape (3,).
        faults: say in which form the body is bent.

    Returns:
        None where it is bent in a form that has no parts.
    """
    form = faults.curvature_form
    if form == 'kink':
        begin, end = faults.curvature_at - 0.5 * _KINK, faults.curvature_at + 0.5 * _KINK
        return [(begin, end, curvature / _KINK)]
    if form in _IN_PARTS:
        return _IN_PARTS[form](curvature, faults)
    if form == 'jumbled':
        return _jumble(curvature, faults.curvature_parts)
    if form == 'wavy':
        return _waves(curvature, faults.curvature_waves)
    if form == 'overhanging':
        return _overhung(curvature, faults.curvature_at)
    if form in ('S', 'middle', 'helix', *_RATES):
        return _parts(curvature, form)
    return None


def _parts(curvature: FloatArray, form: str) -> list[Part]:
    """Return begin and end of the parts of a body and how they are bent, the outer one first."""
    if form == 'S':
        return [(0.5, 1.0, -2.0 * curvature), (0.0, 0.5, 2.0 * curvature)]
    if form == 'middle':
        return [(1 / 3, 2 / 3, 3.0 * curvature)]
    found = []
    for number in reversed(range(_PARTS)):
        begin, end = number / _PARTS, (number + 1) / _PARTS
        middle = 0.5 * (begin + end)
        if form in _RATES:
            found.append((begin, end, _RATES[form](middle) * curvature))
            continue
        turn = rotation(np.array([_HELIX_TURN * (middle - 0.5), 0.0, 0.0]))
        found.append((begin, end, _HELIX_MORE * turn @ curvature))
    return found


def _folds(curvature: FloatArray, faults: Faults) -> list[Part]:
    """Return the two folds of a body that was folded one way and then back, the outer one first.

    Args:
        curvature: mean over the free length of what the inner fold turns [1/m], shape (3,).
        faults: say where the folds are, and which share of that the outer one turns back.
    """
    inner, outer, rate = faults.curvature_at, faults.curvature_again, curvature / _KINK
    return [
        (outer - 0.5 * _KINK, outer + 0.5 * _KINK, -faults.curvature_back * rate),
        (inner - 0.5 * _KINK, inner + 0.5 * _KINK, rate),
    ]


def _corners(curvature: FloatArray, faults: Faults) -> list[Part]:
    """Return the two bends of a body that was crammed into a box, the outer one first.

    Args:
        curvature: mean over the free length of what the inner bend turns [1/m], shape (3,).
        faults: say where the bends are, and by which share of that the outer one turns at right
            angles to it.
    """
    aside = np.cross([1.0, 0.0, 0.0], curvature)
    rates = {
        faults.curvature_again: faults.curvature_back * aside / _CRAMMED,
        faults.curvature_at: curvature / _CRAMMED,
    }
    half = 0.5 * _CRAMMED
    return [(middle - half, middle + half, rate) for middle, rate in rates.items()]


def _jumble(curvature: FloatArray, shares: tuple[tuple[float, float], ...]) -> list[Part]:
    """Return parts of a body that lay in a full drawer, the outer one first.

    Args:
        curvature: of the arc whose tip is as far off [1/m], shape (3,).
        shares: of that, and of as much at right angles to it, in each part, from the clamp on.
    """
    aside, ends = np.cross([1.0, 0.0, 0.0], curvature), np.linspace(0.0, 1.0, len(shares) + 1)
    parts = zip(pairwise(ends), shares, strict=True)
    found = [(begin, end, one * curvature + two * aside) for (begin, end), (one, two) in parts]
    return found[::-1]


def _supported(curvature: FloatArray, faults: Faults) -> list[Part]:
    """Return parts of a body that hung from a rail, or lay between two supports below a weight.

    The tip is as far off as that of an arc.

    Args:
        curvature: of that arc [1/m], shape (3,).
        faults: say which, and where the rail or the weight was.
    """
    at = faults.curvature_at
    if faults.curvature_form == 'draped':
        # Both ends pull by their even load: moments go with the square of the way from an end.
        power, lever = 2, at * (1.0 / 3.0 - 0.25 * at) + 0.25 * (1.0 - at) ** 2
    else:
        power, lever = 1, at * (0.5 - at / 3.0) + (1.0 - at) ** 2 / 3.0
    return _by_moments(
        curvature, lever, lambda middle: min(middle / at, (1.0 - middle) / (1.0 - at)) ** power
    )


def _propped(curvature: FloatArray, faults: Faults) -> list[Part]:
    """Return parts of a body whose tip lay on a block, which bore a part of its weight.

    By the moment of an even load less that of the block, so that the outer part is bent the other
    way. The tip is as far off as that of an arc.

    Args:
        curvature: of that arc [1/m], shape (3,).
        faults: say how much of the clamp's moment the block takes away.
    """
    prop = faults.curvature_prop
    return _by_moments(
        curvature,
        0.25 - prop / 3.0,
        lambda middle: (1.0 - middle) ** 2 - prop * (1.0 - middle),
    )


def _held_by_tip(curvature: FloatArray, faults: Faults) -> list[Part]:
    """Return parts of a body that was held by its tip, with its holder at the free end.

    By the moments of its even load and of the holder's weight, which both grow from the clamp on.
    The tip is as far off as that of an arc.

    Args:
        curvature: of that arc [1/m], shape (3,).
        faults: say which share of the moment at the tip was the holder's.
    """
    heavy = faults.curvature_heavy
    return _by_moments(
        curvature,
        heavy / 6.0 + (1.0 - heavy) / 12.0,
        lambda middle: heavy * middle + (1.0 - heavy) * middle**2,
    )


def _hammock(curvature: FloatArray, faults: Faults) -> list[Part]:
    """Return parts of a body that was hung up by both ends; its tip is as far off as an arc's."""
    at, sag = faults.curvature_at, faults.curvature_sag
    lever = catenary_lever(at, sag)
    return _by_moments(curvature, lever, lambda middle: catenary_rate(middle, at, sag))


def _bedded(curvature: FloatArray, faults: Faults) -> list[Part]:
    """Return parts of a body whose holder sank into a mattress; its tip is as far as an arc's."""
    bed = faults.curvature_bed
    return _by_moments(curvature, bedded_lever(bed), lambda middle: bedded_moment(middle, bed))


def _four_point(curvature: FloatArray, faults: Faults) -> list[Part]:
    """Return parts of a body that lay on its two ends below a board on two feet.

    Between the feet its moment is even, and falls evenly from there to both ends. The tip is as
    far off as that of an arc.

    Args:
        curvature: of that arc [1/m], shape (3,).
        faults: say where both feet stood.
    """
    inner, outer = faults.curvature_at, faults.curvature_again
    lever = inner * (0.5 - inner / 3.0) + (1.0 - outer) ** 2 / 3.0
    lever += (outer - inner) * (1.0 - 0.5 * (inner + outer))
    return _by_moments(
        curvature, lever, lambda middle: min(middle / inner, 1.0, (1.0 - middle) / (1.0 - outer))
    )


def _by_moments(
    curvature: FloatArray, lever: float, moment: Callable[[float], float]
) -> list[Part]:
    """Return parts of a body that moments bent whose tip is as far off as that of an arc.

    Args:
        curvature: of that arc [1/m], shape (3,).
        lever: mean over the free length of moments times what is left to the tip.
        moment: by the share of the free length.
    """
    found = []
    for number in reversed(range(_PARTS)):
        begin, end = number / _PARTS, (number + 1) / _PARTS
        middle = 0.5 * (begin + end)
        found.append((begin, end, 0.5 / lever * moment(middle) * curvature))
    return found


def _outweighed(curvature: FloatArray, faults: Faults) -> list[Part]:
    """Return parts of a body that lay on a shelf, and whose holder hung over that's edge.

    The holder's weight bends it by the way from there to the edge; what lay on the shelf stayed
    straight. The tip is as far off as that of an arc.

    Args:
        curvature: of that arc [1/m], shape (3,).
        faults: say at which share of the free length the edge was.
    """
    edge, found = faults.curvature_at, []
    lever = edge**2 * (0.5 - edge / 3.0)
    for number in reversed(range(_PARTS)):
        begin, end = edge * number / _PARTS, edge * (number + 1) / _PARTS
        found.append((begin, end, 0.25 / lever * (begin + end) * curvature))
    return found


def _burdened(curvature: FloatArray, faults: Faults) -> list[Part]:
    """Return parts of a body on which something hung for long, the outer one first.

    It bends the body by the way from there; what is beyond stayed straight. The tip is as far off
    as that of an arc.

    Args:
        curvature: of that arc [1/m], shape (3,).
        faults: say at which share of the free length it hung.
    """
    at, found = faults.curvature_at, []
    lever = at**2 * (0.5 - at / 6.0)
    for number in reversed(range(_PARTS)):
        begin, end = at * number / _PARTS, at * (number + 1) / _PARTS
        found.append((begin, end, 0.25 / lever * (2.0 * at - begin - end) * curvature))
    return found


def _waves(curvature: FloatArray, count: float) -> list[Part]:
    """Return parts of a body that lay on ridges: it is bent by the sine, the outer one first.

    The tip is as far off as that of an arc.

    Args:
        curvature: of that arc [1/m], shape (3,).
        count: of waves over the free length.
    """
    rate = 2.0 * np.pi * count
    # How far a tip goes by the sine: the mean of that times the way that is left to the tip.
    lever = (1.0 - np.sin(rate) / rate) / rate
    ends, found = np.linspace(0.0, 1.0, _WAVE_PARTS + 1), []
    for begin, end in reversed(list(pairwise(ends))):
        # The mean over a part, so that all of them turn by as much as the waves do.
        mean = (np.cos(rate * begin) - np.cos(rate * end)) / (rate * (end - begin))
        found.append((begin, end, 0.5 / lever * mean * curvature))
    return found


def _overhung(curvature: FloatArray, edge: float) -> list[Part]:
    """Return parts of a body that lay on a table and hung over its edge, the outer one first.

    What lay on the table stayed straight, and the tip is as far off as that of an arc.

    Args:
        curvature: of that arc [1/m], shape (3,).
        edge: share of the free length that lay over the table's edge.
    """
    outer, found = 1.0 - edge, []
    for number in reversed(range(_PARTS)):
        begin, end = edge + outer * number / _PARTS, edge + outer * (number + 1) / _PARTS
        left = 1.0 - (number + 0.5) / _PARTS
        found.append((begin, end, 2.0 / outer**2 * left**2 * curvature))
    return found


def _hung(share: float) -> float:
    """Return the moment of an even load: the tip moves as far as that of an arc."""
    return 2.0 * (1.0 - share) ** 2


def _coiled(share: float) -> float:
    """Return the curvature of a spiral, whose tip moves as far as that of an arc."""
    lever = (1.0 + (1.0 - 1.0 / _UNCOILED) * -np.log1p(-_UNCOILED)) / _UNCOILED
    return float(0.5 / lever / (1.0 - _UNCOILED * share))


def _buckled(share: float) -> float:
    """Return the curvature of Euler's column between two hinges: its tip is as far as an arc's."""
    return float(0.5 * np.pi * np.sin(np.pi * share))


def _sagged(share: float) -> float:
    """Return the moment of a mould's weight on two trestles at a place, over its mean."""
    one, other = max(share - _TRESTLE, 0.0), max(share - 1.0 + _TRESTLE, 0.0)
    mean = 0.25 * ((1.0 - _TRESTLE) ** 2 + _TRESTLE**2) - 1.0 / 6.0
    return 0.5 * (one + other - share**2) / mean


# How much of a curvature is there at a share of the free length.
_RATES = {
    'set': _hung,
    'trestles': _sagged,
    'coiled': _coiled,
    'buckled': _buckled,
    'slots': slotted,
}


# Parts that a body is bent in, by the curvature and the faults.
_IN_PARTS = {
    'folded': _folds,
    'crammed': _corners,
    'draped': _supported,
    'weighed down': _supported,
    'propped': _propped,
    'outweighed': _outweighed,
    'held by its tip': _held_by_tip,
    'burdened': _burdened,
    'hammock': _hammock,
    'mattress': _bedded,
    'four-point': _four_point,
    'over a rod': over_rod,
    'woven': woven,
    'wrapped': wrapped,
}
