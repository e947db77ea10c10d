# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The outside of a body and of its fixture as small triangles."""

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from benchmarks.blind.hexahedra import HexMesh, shape_functions
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.speckle import on_board, speckled, stickered

IntArray = NDArray[np.int64]

# What a pixel may see.
ROOT, TIP, FIXTURE = 0, 1, 2
# Between root and tip, where that is no sharp border: by how many twentieths a label is more.
BETWEEN, PARTS = 3, 20
HALFWAY = BETWEEN + PARTS // 2
_CUTS = 3  # Of an element's face along each side; its curve is then followed to a micrometre.


@dataclass(frozen=True)
class Triangles:
    """A surface to be rendered.

    Attributes:
        corners: [m], shape (T, 3, 3).
        labels: ROOT, TIP, FIXTURE, or BETWEEN and more, shape (T,).
    """

    corners: FloatArray
    labels: IntArray


def grid_triangles(cuts: int) -> IntArray:
    """Return triangles over a square grid of (cuts + 1)^2 points, shape (2 cuts^2, 3)."""
    triangles = []
    for row, column in product(range(cuts), repeat=2):
        a = row * (cuts + 1) + column
        b, c, d = a + 1, a + cuts + 1, a + cuts + 2
        triangles += [(a, b, c), (b, d, c)]
    return np.array(triangles)


def body_triangles(
    mesh: HexMesh,
    positions: FloatArray,
    shares: FloatArray,
    tip_from: float = 0.5,
    ramp: float = 0.0,
    tip_until: float = 1.0,
    heights: FloatArray | None = None,
    bands: tuple[float, float] = (0.0, 0.0),
    *,
    is_wound: bool = False,
    speckle: tuple[float, float, int] = (0.0, 0.0, 0),
    decay: float = 0.0,
    sun: tuple[float, float] = (0.0, 0.0),
    second: float = 0.0,
    strokes: tuple[float, ...] = (),
    dips: tuple[float, ...] = (),
    board: float = 0.0,
    stickers: tuple[float, float] = (0.0, 0.0),
) -> Triangles:
    """Triangulate a body's surface.

    Args:
        mesh: the body.
        positions: of its nodes, any frame [m], shape (N, 3).
        shares: of the free length at which its nodes rest, shape (N,).
        tip_from: share from which on the surface is labelled as the tip's.
        ramp: share over which, around that, the labels go over from root to tip.
        tip_until: share beyond which they are the root's again, with the same ramp; 1: none.
        heights: of its nodes; what lies at or below 0 is the root's, shape (N,). None: nothing.
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
    """
    ticks = np.linspace(-1.0, 1.0, _CUTS + 1)
    square = np.stack(np.meshgrid(ticks, ticks, indexing='ij'), axis=-1).reshape(-1, 2)
    triangles = grid_triangles(_CUTS)
    corners, labels = [], []
    for axis, side in product(range(3), (-1, 1)):
        chosen = (mesh.faces[:, 1] == axis) & (mesh.faces[:, 2] == side)
        local = np.insert(square, axis, float(side), axis=1)
        values = shape_functions(local)
        nodes = mesh.cells[mesh.faces[chosen, 0]]
        points = values @ positions[nodes]
        along = values @ shares[nodes][..., None]
        corners.append(points[:, triangles].reshape(-1, 3, 3))
        places = along[:, triangles, 0].mean(axis=-1)
        sides = _fading(places, decay) if decay else _side(places, tip_from, ramp, tip_until)
        if second:
            sides = np.where((sides == ROOT) & (places > second), HALFWAY, sides)
        middles = (values @ mesh.lattice[nodes])[:, triangles].mean(axis=-2)
        if bands[0]:
            turned = turned_share(middles, mesh.lattice) if is_wound else 0.0
            within = (places - bands[0] * turned - tip_from) % bands[0] < bands[0] * bands[1]
            sides = np.where(within, sides, ROOT)
        if strokes:
            sides = _between(_stroked(places, tip_from, strokes) * tip_part(sides))
        if dips:
            sides = _between(_coats(places, dips))
        if speckle[0]:
            sides = np.where(speckled(middles, *speckle), sides, ROOT)
        if board:
            sides = np.where(on_board(middles, board), sides, ROOT)
        if stickers[0]:
            sides = np.where(stickered(middles, axis, *stickers), sides, ROOT)
        if heights is not None:
            above = (values @ heights[nodes][..., None])[:, triangles, 0].mean(axis=-1)
            sides = np.where(above > 0.0, sides, ROOT)
        if any(sun):
            # An end faces along the body, and is aside of all such directions.
            lit = max(side * float((0.0, *sun)[axis]), 0.0)
            sides = _between(lit * tip_part(sides))
        labels.append(sides.reshape(-1))
    return Triangles(np.concatenate(corners), np.concatenate(labels).astype(np.int64))


def turned_share(points: FloatArray, lattice: FloatArray) -> FloatArray:
    """Return which share of a turn about a body's length points lie from its y, towards z.

    The section is drawn out to a square, so that each of its sides has a quarter.

    Args:
        points: before the shape's map [m], shape (..., 3).
        lattice: the nodes, which say how wide and high the body is there [m], shape (N, 3).
    """
    low, high = lattice.min(axis=0), lattice.max(axis=0)
    outward = (2.0 * points - low - high) / (high - low)
    return np.asarray(np.arctan2(outward[..., 2], outward[..., 1]) / (2.0 * np.pi) % 1.0)


def _side(along: FloatArray, tip_from: float, ramp: float, tip_until: float) -> IntArray:
    inside = along - tip_from
    if tip_until < 1.0:
        inside = np.minimum(inside, tip_until - along)
    if not ramp:
        return np.where(inside > 0.0, TIP, ROOT)
    return _between(inside / ramp + 0.5)


def _stroked(along: FloatArray, tip_from: float, strokes: tuple[float, ...]) -> FloatArray:
    """Return how thick the paint of a brush's strokes is, which lie side by side to the tip."""
    numbers = (along - tip_from) / (1.0 - tip_from) * len(strokes)
    return np.asarray(np.array(strokes)[np.clip(numbers.astype(int), 0, len(strokes) - 1)])


def _coats(along: FloatArray, dips: tuple[float, ...]) -> FloatArray:
    """Return which part of all coats is on a place that was dipped each time to another share."""
    return np.asarray((along[..., None] > np.array(dips)).mean(axis=-1))


def _fading(along: FloatArray, decay: float) -> IntArray:
    """Return labels that fall by the exponential of the way from the tip."""
    return _between(np.exp((along - 1.0) / decay))


def _between(part: FloatArray) -> IntArray:
    """Return the label of what is the tip's by a part, to the nearest twentieth."""
    twentieths = np.round(PARTS * part).astype(np.int64)
    is_tip = np.where(twentieths >= PARTS, TIP, BETWEEN + twentieths)
    return np.where(twentieths <= 0, ROOT, is_tip)


def tip_part(labels: IntArray) -> FloatArray:
    """Return how much of the tip a surface is, 0 to 1, by its label."""
    between = np.where(labels > BETWEEN, (labels - BETWEEN) / PARTS, 0.0)
    return np.asarray((labels == TIP) + between)


def box_triangles(low: FloatArray, high: FloatArray, label: int, cuts: int = 8) -> Triangles:
    """Triangulate a box from its lowest to its highest corner."""
    ticks = np.linspace(0.0, 1.0, cuts + 1)
    square = np.stack(np.meshgrid(ticks, ticks, indexing='ij'), axis=-1).reshape(-1, 2)
    faces = []
    for axis, side in product(range(3), (0.0, 1.0)):
        local = np.insert(square, axis, side, axis=1)
        faces.append((low + local * (high - low))[grid_triangles(cuts)])
    corners = np.concatenate(faces)
    return Triangles(corners, np.full(len(corners), label))


def joined(*parts: Triangles) -> Triangles:
    """Put surfaces together."""
    return Triangles(
        np.concatenate([part.corners for part in parts]),
        np.concatenate([part.labels for part in parts]),
    )


def moved(surface: Triangles, matrix: FloatArray) -> Triangles:
    """Apply a rigid transform, shape (4, 4)."""
    return Triangles(surface.corners @ matrix[:3, :3].T + matrix[:3, 3], surface.labels)
