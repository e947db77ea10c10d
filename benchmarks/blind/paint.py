# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which parts of a body's surface are painted, taped or dipped: the tip's, and by how much."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.speckle import netted, on_board, speckled, stickered

IntArray = NDArray[np.int64]

# What a pixel may see.
ROOT, TIP, FIXTURE = 0, 1, 2
# Between root and tip, where that is no sharp border: by how many twentieths a label is more.
BETWEEN, PARTS = 3, 20
HALFWAY = BETWEEN + PARTS // 2


@dataclass(frozen=True)
class Paint:
    """What is the tip's of a body's surface, and what the root's.

    Attributes:
        tip_from: share from which on the surface is labelled as the tip's.
        ramp: share over which, around that, the labels go over from root to tip.
        tip_until: share beyond which they are the root's again, with the same ramp; 1: none.
        bands: distance between the tip's bands from `tip_from` on, and which share of that each
            has; (0, 0): it is one.
        is_wound: whether the bands are the turns of one, wound around the body.
        speckle: edge of dots [m], which share of the tip they cover, and the seed of their places;
            what is between them is the root's; (0, 0, 0): all is one dot.
        decay: share over which labels fall from the tip's to a third, from the very tip on, in
            place of a border; 0: they do not.
        sun: direction, object's y and z, by whose cosine with each side its labels are less the
            tip's; (0, 0): they are not.
        second: share from which on what would be the root's is a half of the tip's; 0: nothing.
        strokes: by which part each of some bands is the tip's, alike in length from `tip_from` on;
            empty: all is.
        dips: shares from which on each of some coats is on it, all of which are the tip's, in
            place of a border; empty: there are none.
        board: edge of squares [m], every other of which is the root's; 0: there are none.
        stickers: way from one to the next along each side and their radius [m]; what is between
            them is the root's; (0, 0): all is one.
        net: way from knot to knot along it [m], and which share of that a thread covers; what is
            in the meshes is the root's; (0, 0): there are none.
        bell: share of the free length where it is all the tip's, and over which, to either side,
            a third of it is left, by the exponential of the square; (0, 0): it begins at a border.
        tongue: share from which on it is all around; from a point amid each side, at `tip_from`,
            it grows to that; 0: it is all around at once.
        edges: share of the way from an edge to the middle of a side which is worn along the edges,
            alone the tip's; 0: all is.
        flakes: edge of flakes that are as likely to be there yet as they lie farther on from
            `tip_from` to the tip [m], and the seed of that; where they are not is the root's;
            (0, 0): nothing flakes off.
        bars: shares at which the dark bars of a label begin and end in turn; what is between two
            bars is the root's; empty: it is one bar.
    """

    tip_from: float = 0.5
    ramp: float = 0.0
    tip_until: float = 1.0
    bands: tuple[float, float] = (0.0, 0.0)
    is_wound: bool = False
    speckle: tuple[float, float, int] = (0.0, 0.0, 0)
    decay: float = 0.0
    sun: tuple[float, float] = (0.0, 0.0)
    second: float = 0.0
    strokes: tuple[float, ...] = ()
    dips: tuple[float, ...] = ()
    board: float = 0.0
    stickers: tuple[float, float] = (0.0, 0.0)
    net: tuple[float, float] = (0.0, 0.0)
    bell: tuple[float, float] = (0.0, 0.0)
    tongue: float = 0.0
    edges: float = 0.0
    flakes: tuple[float, int] = (0.0, 0)
    bars: tuple[float, ...] = ()


PLAIN = Paint()


@dataclass(frozen=True)
class Side:
    """Spots on one of the six sides of a body, before the shape's map.

    Attributes:
        along: shares of the free length, shape (...).
        points: [m], shape (..., 3).
        axis: of the object, along which the side faces.
        sign: of the way in which it faces.
        lattice: the body's nodes, which say how wide and high it is [m], shape (N, 3).
        heights: above what covers the body; what lies at or below 0 is the root's, shape (...).
            None: nothing covers it.
    """

    along: FloatArray
    points: FloatArray
    axis: int
    sign: int
    lattice: FloatArray
    heights: FloatArray | None = None


Coat = Callable[[IntArray, Side, Paint], IntArray]


def painted(side: Side, paint: Paint) -> IntArray:
    """Return the labels of spots on one side of a body, shape (...)."""
    labels = _border(side, paint)
    for coat in _COATS:
        labels = coat(labels, side, paint)
    return labels


def _border(side: Side, paint: Paint) -> IntArray:
    """Return labels by the border of root and tip alone, or by what fades from a place."""
    if paint.decay:
        return _between(np.exp((side.along - 1.0) / paint.decay))
    if paint.bell[1]:
        at, width = paint.bell
        return _between(np.exp(-(((side.along - at) / width) ** 2)))
    inside = side.along - paint.tip_from
    if paint.tip_until < 1.0:
        inside = np.minimum(inside, paint.tip_until - side.along)
    if not paint.ramp:
        return np.where(inside > 0.0, TIP, ROOT)
    return _between(inside / paint.ramp + 0.5)


def _with_second(labels: IntArray, side: Side, paint: Paint) -> IntArray:
    if not paint.second:
        return labels
    return np.where((labels == ROOT) & (side.along > paint.second), HALFWAY, labels)


def _in_bands(labels: IntArray, side: Side, paint: Paint) -> IntArray:
    distance, share = paint.bands
    if not distance:
        return labels
    turned = turned_share(side.points, side.lattice) if paint.is_wound else 0.0
    place = (side.along - distance * turned - paint.tip_from) % distance
    return np.where(place < distance * share, labels, ROOT)


def _brushed(labels: IntArray, side: Side, paint: Paint) -> IntArray:
    """Return labels by how thick the strokes of a brush are, which lie side by side to the tip."""
    if not paint.strokes:
        return labels
    count = len(paint.strokes)
    numbers = (side.along - paint.tip_from) / (1.0 - paint.tip_from) * count
    thick = np.array(paint.strokes)[np.clip(numbers.astype(int), 0, count - 1)]
    return _between(thick * tip_part(labels))


def _dipped(labels: IntArray, side: Side, paint: Paint) -> IntArray:
    """Return labels by which part of all coats is on what was dipped to several shares."""
    if not paint.dips:
        return labels
    return _between(np.asarray((side.along[..., None] > np.array(paint.dips)).mean(axis=-1)))


def _in_spots(labels: IntArray, side: Side, paint: Paint) -> IntArray:
    """Return labels of what is in dots, dark squares, stickers or nets; all else is the root's."""
    if paint.speckle[0]:
        labels = np.where(speckled(side.points, *paint.speckle), labels, ROOT)
    if paint.board:
        labels = np.where(on_board(side.points, paint.board), labels, ROOT)
    if paint.stickers[0]:
        labels = np.where(stickered(side.points, side.axis, *paint.stickers), labels, ROOT)
    if paint.net[0]:
        labels = np.where(netted(side.points, side.axis, *paint.net), labels, ROOT)
    return labels


def _tongued(labels: IntArray, side: Side, paint: Paint) -> IntArray:
    """Return labels of what is cut to a tongue on each side that faces across the body."""
    if not paint.tongue or side.axis == 0:
        return labels
    wide = (side.along - paint.tip_from) / (paint.tongue - paint.tip_from)
    aside = np.abs(_outward(side.points, side.lattice)[..., 3 - side.axis])
    return np.where(aside < wide, labels, ROOT)


def _worn(labels: IntArray, side: Side, paint: Paint) -> IntArray:
    """Return labels of what is worn along the edges of each side alone."""
    if not paint.edges:
        return labels
    aside = np.abs(_outward(side.points, side.lattice))
    aside[..., [0, side.axis]] = 0.0
    return np.where(aside.max(axis=-1) > 1.0 - paint.edges, labels, ROOT)


def _flaked(labels: IntArray, side: Side, paint: Paint) -> IntArray:
    """Return labels of a coat that flakes off, the more the nearer it is to where it begins."""
    edge, seed = paint.flakes
    if not edge:
        return labels
    cover = (side.along - paint.tip_from) / (1.0 - paint.tip_from)
    return np.where(speckled(side.points, edge, cover, seed), labels, ROOT)


def _barred(labels: IntArray, side: Side, paint: Paint) -> IntArray:
    if not paint.bars:
        return labels
    return np.where(np.searchsorted(np.array(paint.bars), side.along) % 2 == 1, labels, ROOT)


def _uncovered(labels: IntArray, side: Side, paint: Paint) -> IntArray:
    return labels if side.heights is None else np.where(side.heights > 0.0, labels, ROOT)


def _in_the_sun(labels: IntArray, side: Side, paint: Paint) -> IntArray:
    if not any(paint.sun):
        return labels
    # An end faces along the body, and is aside of all such directions.
    lit = max(side.sign * float((0.0, *paint.sun)[side.axis]), 0.0)
    return _between(lit * tip_part(labels))


# One after the other, each on what those before it left.
_COATS: tuple[Coat, ...] = (
    _with_second,
    _in_bands,
    _brushed,
    _dipped,
    _in_spots,
    _tongued,
    _worn,
    _flaked,
    _barred,
    _uncovered,
    _in_the_sun,
)


def turned_share(points: FloatArray, lattice: FloatArray) -> FloatArray:
    """Return which share of a turn about a body's length points lie from its y, towards z.

    The section is drawn out to a square, so that each of its sides has a quarter.

    Args:
        points: before the shape's map [m], shape (..., 3).
        lattice: the nodes, which say how wide and high the body is there [m], shape (N, 3).
    """
    outward = _outward(points, lattice)
    return np.asarray(np.arctan2(outward[..., 2], outward[..., 1]) / (2.0 * np.pi) % 1.0)


def _outward(points: FloatArray, lattice: FloatArray) -> FloatArray:
    """Return where points lie along each axis, -1 and 1 at the outermost nodes (..., 3)."""
    low, high = lattice.min(axis=0), lattice.max(axis=0)
    return np.asarray((2.0 * points - low - high) / (high - low))


def _between(part: FloatArray) -> IntArray:
    """Return the label of what is the tip's by a part, to the nearest twentieth."""
    twentieths = np.round(PARTS * part).astype(np.int64)
    is_tip = np.where(twentieths >= PARTS, TIP, BETWEEN + twentieths)
    return np.where(twentieths <= 0, ROOT, is_tip)


def tip_part(labels: IntArray) -> FloatArray:
    """Return how much of the tip a surface is, 0 to 1, by its label."""
    between = np.where(labels > BETWEEN, (labels - BETWEEN) / PARTS, 0.0)
    return np.asarray((labels == TIP) + between)
