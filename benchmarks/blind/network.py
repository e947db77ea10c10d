# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Rubber that is stiffened by fibres on all sides, or on its upper side.

Short ones in all directions, which lie in waves until they are drawn straight; or threads of a
braid, which cross the body aslant and resist a pull by its exponential; or loops of a knitted
sleeve, along the body and near its surface; or rows of beads along it, which resist a push; or
threads along it and near its surface, which are loose until they are drawn taut; or the coils of
a spring there, which touch once they are pressed together; or a hose of interlocked strips there,
which have play either way; or the leads of a sensor along both sides, which are loose at first; or
blocks along the lower side, like those of a spine, which touch where it is bent that way; or a
tape on the upper side, which was stuck on in ruffles and is drawn straight; or a strip of foam
on the lower side, which grows dense where it is pressed; or curly cords on both of these sides,
which go straight and no further; or rovings of glass along the four edges, whose filaments come
taut one after another.
On the upper side alone a fabric resists a pull, and the sides of its
cracks a push.
"""

from dataclasses import replace

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.fibres import Fibres
from benchmarks.blind.material import Constants, stiffened
from benchmarks.blind.shapes import FloatArray

_GOLDEN = 0.5 * (1.0 + np.sqrt(5.0))
# Through the corners of an icosahedron: alike in all directions, to the fourth power.
_AXES = np.array(
    [[0.0, 1.0, way * _GOLDEN] for way in (1.0, -1.0)]
    + [[1.0, way * _GOLDEN, 0.0] for way in (1.0, -1.0)]
    + [[way * _GOLDEN, 0.0, 1.0] for way in (1.0, -1.0)]
)
AXES = _AXES / np.linalg.norm(_AXES[0])
_ALONG = np.array([1.0, 0.0, 0.0])
_KNIT_FROM = 0.6  # Of the way from the section's middle to its surface; threads and coils as well.
_LEADS_FROM, _LEADS_WITHIN = 0.55, 0.6  # Of the way to a side, and to its edges, for leads.
_SPINE_BELOW = -0.5  # Of the way from the section's middle to its upper side, for blocks or foam.
_ROVINGS_FROM = 0.5  # Of the way to both sides that meet in an edge, for rovings.
_TAPE_ABOVE = 0.5  # Of that way, for a tape, and for cords on either side.
_DRAWN = 0.1  # Growth of a loop's square, or loss of a row's, at which its stiffness is stated.
# Aslant to the body's length, towards either side of its width and of its height.
_SIDES = np.array([[0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])


def reinforced(
    numbers: Constants,
    modulus: FloatArray,
    faults: Faults,
    outward: FloatArray | float = 0.0,
    beside: FloatArray | float = 0.0,
    heights: FloatArray | float = 0.0,
) -> Constants:
    """Return the numbers of a law with what stiffens it in other forms than the library's.

    Args:
        numbers: of the law without.
        modulus: E at the Gauss points [Pa].
        faults: say in which form, and how much.
        outward: of these, 0 in the section's middle and 1 at its surface.
        beside: which of these lie along the middles of both sides, or along edges, 1 or 0.
        heights: of these, -1 at the lower face and 1 at the upper one.
    """
    if faults.stiffening_form == 'knitted' and faults.stiffening:
        knit = faults.stiffening * modulus / (24.0 * _DRAWN) * (np.asarray(outward) > _KNIT_FROM)
        return replace(numbers, network=(Fibres(knit, _ALONG, slack=True, knit=True),))
    if faults.stiffening_form in ('threaded', 'coils') and faults.stiffening:
        outer = faults.stiffening * modulus / 8.0 * (np.asarray(outward) > _KNIT_FROM)
        is_coil, begin = faults.stiffening_form == 'coils', faults.stiffening_from
        loose = Fibres(outer, _ALONG, slack=not is_coil, pressed=is_coil, loose=begin)
        return replace(numbers, network=(loose,))
    if faults.stiffening_form == 'interlocked' and faults.stiffening:
        hose, play = faults.stiffening * modulus / 8.0, faults.stiffening_from
        hose = hose * (np.asarray(outward) > _KNIT_FROM)
        drawn = Fibres(hose, _ALONG, slack=True, loose=play)
        return replace(numbers, network=(drawn, replace(drawn, slack=False, pressed=True)))
    if faults.stiffening_form in ('leads', 'rovings') and faults.stiffening:
        laid, begin = faults.stiffening * modulus / 8.0 * beside, faults.stiffening_from
        spread = faults.stiffening_spread
        drawn = Fibres(laid, _ALONG, slack=True, loose=begin, spread=spread)
        return replace(numbers, network=(drawn,))
    if faults.stiffening_form == 'vertebrae' and faults.stiffening:
        spine = faults.stiffening * modulus / 8.0 * (np.asarray(heights) < _SPINE_BELOW)
        touching = Fibres(spine, _ALONG, pressed=True, loose=faults.stiffening_from)
        return replace(numbers, network=(touching,))
    if faults.stiffening_form == 'ruffled' and faults.stiffening:
        tape = faults.stiffening * modulus / 8.0 * (np.asarray(heights) > _TAPE_ABOVE)
        ruffles = Fibres(tape, _ALONG, slack=True, waves=faults.stiffening_from)
        return replace(numbers, network=(ruffles,))
    if faults.stiffening_form == 'foam strip' and faults.stiffening:
        strip = faults.stiffening * modulus / 8.0 * (np.asarray(heights) < _SPINE_BELOW)
        dense = Fibres(strip, _ALONG, pressed=True, steep=faults.stiffening_steep)
        return replace(numbers, network=(dense,))
    if faults.stiffening_form == 'corded' and faults.stiffening:
        cords = faults.stiffening * modulus / 8.0 * (np.abs(heights) > _TAPE_ABOVE)
        curly = Fibres(cords, _ALONG, slack=True, limit=faults.stiffening_from)
        return replace(numbers, network=(curly,))
    if faults.stiffening_form == 'beaded' and faults.stiffening:
        rows = faults.stiffening * modulus / (24.0 * _DRAWN)
        return replace(numbers, network=(Fibres(rows, _ALONG, pressed=True, knit=True),))
    if faults.stiffening_form == 'braided' and faults.stiffening:
        return replace(numbers, network=_braid(modulus, faults))
    if faults.stiffening_form != 'recruited' or not faults.stiffening:
        return stiffened(numbers, faults.stiffening_form, faults.stiffening)
    # A pull along x meets 8 K times the sum of the fourth powers of all axes' x: a fifth each.
    stiffness = faults.stiffening * modulus / (8.0 * 0.2 * len(AXES))
    waves = faults.stiffening_from
    fibres = (Fibres(stiffness, axis, slack=True, waves=waves) for axis in AXES)
    return replace(numbers, network=tuple(fibres))


def on_upper_side(
    numbers: Constants, modulus: FloatArray, heights: FloatArray, faults: Faults
) -> Constants:
    """Return the numbers of a law with what resists in the uppermost quarter alone.

    Args:
        numbers: of the law without.
        modulus: E at the Gauss points, lower where the upper side is crazed [Pa].
        heights: of these, -1 at the lower face and 1 at the upper one.
        faults: say what there is.
    """
    above = heights > 0.5
    if faults.fabric:
        stiffness = faults.fabric * modulus / 8.0 * above
        return replace(numbers, fabric=Fibres(stiffness, _ALONG, slack=True))
    if faults.crazed:
        # What cracks take from the modulus they give back where they are shut.
        stiffness = faults.crazed / (1.0 - faults.crazed) * modulus / 8.0 * above
        return replace(numbers, fabric=Fibres(stiffness, _ALONG, pressed=True))
    return numbers


def beside_middle(across: FloatArray) -> FloatArray:
    """Return which places lie where leads run along both sides, 1 or 0, shape (C, 8).

    Args:
        across: of Gauss points, over half the width and the height, shape (C, 2, 8).
    """
    aside, high = np.abs(across).swapaxes(0, 1)
    is_beside = (aside > _LEADS_FROM) & (aside < 1.0) & (high < _LEADS_WITHIN)
    return np.asarray(is_beside.astype(float))


def laid_along(across: FloatArray, faults: Faults) -> FloatArray:
    """Return which places lie where leads run, or where rovings do, 1 or 0, shape (C, 8).

    Args:
        across: of Gauss points, over half the width and the height, shape (C, 2, 8).
        faults: say which.
    """
    if faults.stiffening_form != 'rovings':
        return beside_middle(across)
    inner, outer = np.abs(across).min(axis=1), np.abs(across).max(axis=1)
    return np.asarray(((inner > _ROVINGS_FROM) & (outer < 1.0)).astype(float))


def _braid(modulus: FloatArray, faults: Faults) -> tuple[Fibres, ...]:
    """Return the threads of a braid, which are slack where they are pressed."""
    slant = np.deg2rad(faults.stiffening_slant)
    # A pull along x meets 8 K times the sum of the fourth powers of all threads' x.
    stiffness = faults.stiffening * modulus / (8.0 * len(_SIDES) * np.cos(slant) ** 4)
    axes = np.cos(slant) * np.array([1.0, 0.0, 0.0]) + np.sin(slant) * _SIDES
    steep = faults.stiffening_steep
    return tuple(Fibres(stiffness, axis, slack=True, steep=steep) for axis in axes)
