# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The middle line of a bent body, from the clamp to the tip."""

from dataclasses import dataclass
from functools import cached_property

from diffcal_ros.rigid_transform import rotation_matrix
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import cKDTree

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]
BoolArray = NDArray[np.bool_]

# Places of the line that are looked for; intervals of the spline through them, and what a third
# difference of its coefficients costs beside the mean square of what is off it.
_STATIONS = np.linspace(0.0, 1.0, 33)
_INTERVALS, _SMOOTH = 12, 1e-3
# Sections that are looked at for arms: so much of a section is an arm, and of so many of them. At
# its end a body has corners.
_SECTIONS, _OF_SECTION, _OF_SECTIONS = np.linspace(0.1, 0.9, 17), 0.2, 0.15
# Nodes are put on the line anew, as far as it is believed each time, in so many steps, and a
# section leans by so much at most.
_ENDS, _STEPS, _LEANS = (0.8, 0.85, 0.9), 6, 0.2
# Pieces of the line that turn at one rate each, as a bend goes along it.
_PIECES = 128
# So many nodes say how far along a point between them is; the last of them has no say.
_NEAREST = 12
# So many sets of points are remembered: nodes and middles of elements, as each pose places them.
_REMEMBERED = 24


@dataclass(frozen=True)
class BodyLine:
    """Where a bent body goes, in the frame of its axes: origin at their root, rows their ways.

    Attributes:
        nodes: of the mesh at rest [m], shape (V, 3).
        along: how far along the line each is, 0 to 1, shape (V,).
        shares: of the length, ascending from 0 to 1, shape (S,).
        middles: of the sections there [m], shape (S, 3).
        frames: unit rows: along the line there, then across it, carried along without turning
            about it, shape (S, 3, 3).
        length: of the line [m].
    """

    nodes: FloatArray
    along: FloatArray
    shares: FloatArray
    middles: FloatArray
    frames: FloatArray
    length: float

    @cached_property
    def _tree(self) -> cKDTree:
        return cKDTree(self.nodes)

    def fraction(self, points: FloatArray) -> FloatArray:
        """Return how far along points are, 0 to 1, as the nodes next to them; shape (n,).

        Weights fall to nothing at the farthest of these nodes (Franke and Little, in Barnhill
        1977): which one of several that are as far is taken changes nothing. Each node tells
        along its own way, as means of nodes alone are drawn inwards at the tip.

        What effects and patches ask for again and again is remembered: not to be written to.
        """
        if not len(points):
            return np.zeros(0)
        key = np.ascontiguousarray(points, dtype=np.float64).tobytes()
        found = self._fractions.get(key)
        if found is None:
            found = self._fractions[key] = self._fraction(points)
            found.flags.writeable = False
            if len(self._fractions) > _REMEMBERED:
                # Other threads may forget one as well: no iterator is open while they do.
                self._fractions.pop(list(self._fractions)[0], None)  # noqa: RUF015
        return found

    @cached_property
    def _fractions(self) -> dict[bytes, FloatArray]:
        return {}

    def _fraction(self, points: FloatArray) -> FloatArray:
        apart, nearest = self._tree.query(points, k=min(_NEAREST, len(self.nodes)))
        reach, least = apart[:, -1:], 1e-9 * self.length
        weights = ((reach - apart) / np.maximum(apart, least)) ** 2 + least**2
        way = np.einsum('nki,nki->nk', self._ways[nearest], points[:, None] - self.nodes[nearest])
        found = (weights * (self.along[nearest] + way)).sum(axis=1) / weights.sum(axis=1)
        return np.clip(found, 0.0, 1.0)

    @cached_property
    def _ways(self) -> FloatArray:
        """By how much more along points are towards the line's way at each node [1/m], (V, 3)."""
        return self.frame(self.along)[:, 0] / self.length

    def middle(self, fraction: FloatArray) -> FloatArray:
        """Return the line at shares of its length [m], shape (n, 3)."""
        return np.stack([np.interp(fraction, self.shares, row) for row in self.middles.T], axis=-1)

    def frame(self, fraction: FloatArray) -> FloatArray:
        """Return its unit rows at shares of its length, shape (n, 3, 3)."""
        rows = [np.interp(fraction, self.shares, row) for row in self.frames.reshape(-1, 9).T]
        frames = np.stack(rows, axis=-1).reshape(-1, 3, 3)
        return frames / np.linalg.norm(frames, axis=2, keepdims=True)

    def across(self, points: FloatArray, fraction: FloatArray) -> FloatArray:
        """Return how far beside the line points are, by the two axes across it [m], (n, 2)."""
        ways = self.frame(fraction)[:, 1:]
        return np.einsum('nij,nj->ni', ways, points - self.middle(fraction))

    def bent(self, points: FloatArray, rates: FloatArray) -> FloatArray:
        """Bend and twist what goes along the line; sections stay plane and keep their size.

        Args:
            points: [m], shape (n, 3).
            rates: see `rest_shape.bent`, shape (s, 3), about this line's own ways.
        """
        ends = np.linspace(0.0, 1.0, _PIECES + 1)
        middles, centers = self.middle(ends), 0.5 * (ends[1:] + ends[:-1])
        part = np.minimum((centers * len(rates)).astype(int), len(rates) - 1)
        turns = np.einsum('ni,nij->nj', rates[part], self.frame(centers)) * self.length / _PIECES
        line, turned = [middles[0]], [np.eye(3)]
        for way, turn in zip(np.diff(middles, axis=0), turns, strict=True):
            line.append(line[-1] + turned[-1] @ rotation_matrix(0.5 * turn) @ way)
            turned.append(turned[-1] @ rotation_matrix(turn))
        fraction = self.fraction(points)
        beside = points - self.middle(fraction)
        piece = np.minimum((fraction * _PIECES).astype(int), _PIECES - 1)
        share = (fraction * _PIECES - piece)[:, None]
        ways, places = np.stack(turned), np.stack(line)
        first, second = (
            places[own] + np.einsum('nij,nj->ni', ways[own], beside) for own in (piece, piece + 1)
        )
        return first + share * (second - first)


def body_line(
    nodes: FloatArray, mesh: TetMesh, held: IntArray, *, is_amid: bool
) -> BodyLine | None:
    """Find the middle line of a body: where its nodes are, by the shortest way along the mesh.

    Args:
        nodes: at rest, in the frame of the body's axes [m], shape (V, 3).
        mesh: whose vertices they are.
        held: vertices, shape (h,).
        is_amid: whether the body goes on to both sides of what is held, or is held at both ends.

    Returns:
        None where it goes along several ways at once, is in pieces, or all at one place.
    """
    graph = _edges(nodes, mesh)
    begin = _begin(graph, nodes, held) if is_amid else held
    ways = dijkstra(graph, directed=False, indices=begin, min_only=True)
    if not np.isfinite(ways).all() or ways.max() <= 0.0:
        return None
    along = ways / ways.max()
    if _has_arms(mesh, along):
        return None
    # One node is a tip, and no clamp.
    clamp = begin if len(begin) > 1 else np.zeros(0, dtype=np.int32)
    is_held = np.isin(mesh.tets, clamp)
    behind = np.setdiff1d(clamp, mesh.tets[~is_held.all(axis=1)])
    line = _through(nodes, along, behind)
    for end in _ENDS:
        line = _through(nodes, _projected(line, clamp, end), behind)
    return line


def _through(nodes: FloatArray, along: FloatArray, behind: IntArray) -> BodyLine:
    """Return the line through the middles of sections.

    Args:
        nodes: [m], shape (V, 3).
        along: how far along each is, 0 to 1, shape (V,).
        behind: nodes that are behind where it begins, shape (c,).
    """
    middles, tangents = _middles(np.delete(nodes, behind, axis=0), np.delete(along, behind))
    steps = np.linalg.norm(np.diff(middles, axis=0), axis=1)
    length = float(steps.sum())
    # Ways along a mesh zigzag more in one direction than in another; the line itself does not.
    shares = np.concatenate([[0.0], np.cumsum(steps) / length])
    frames = _carried(tangents)
    return BodyLine(nodes, np.interp(along, _STATIONS, shares), shares, middles, frames, length)


def _projected(line: BodyLine, clamp: IntArray, end: float) -> FloatArray:
    """Return how far along a line its nodes are by sections square to it, 0 to 1, shape (V,).

    The shortest way goes along the inner side of a bend, and sections by it lean: at the tip the
    line by them turns to the outer corner.

    Args:
        line: by other sections.
        clamp: nodes that are where it begins, shape (c,); none: it begins at a tip as well.
        end: share of the line beyond which it is not believed, and goes straight on instead.
    """
    begin = 0.0 if len(clamp) else 1.0 - end
    along = line.along
    for _ in range(_STEPS):
        within = np.clip(along, begin, end)
        ways = line.frame(within)[:, 0]
        beyond = np.einsum('ni,ni->n', ways, line.nodes - line.middle(within)) / line.length
        along = np.clip(within + beyond, line.along - _LEANS, line.along + _LEANS)
    first = 0.0 if len(clamp) else float(along.min())
    along = np.clip((along - first) / (along.max() - first), 0.0, 1.0)
    along[clamp] = 0.0
    return along


def is_branched(mesh: TetMesh, held: IntArray) -> bool:
    """Tell whether a body goes along several ways at once from what is held of it.

    Args:
        mesh: of the body at rest.
        held: vertices, shape (h,).
    """
    ways = dijkstra(_edges(mesh.rest_positions, mesh), directed=False, indices=held, min_only=True)
    return bool(
        np.isfinite(ways).all() and ways.max() > 0.0 and _has_arms(mesh, ways / ways.max())
    )


def _edges(nodes: FloatArray, mesh: TetMesh) -> csr_array:
    """Return the lengths of a mesh's edges [m], shape (V, V)."""
    first, second = mesh.edges[0].T
    lengths = np.linalg.norm(nodes[second] - nodes[first], axis=1)
    return csr_array((lengths, (first, second)), shape=(len(nodes), len(nodes)))


def _has_arms(mesh: TetMesh, along: FloatArray) -> bool:
    """Tell whether sections of a body are in several pieces: arms, prongs, a hole."""
    low, high = along[mesh.tets].min(axis=1), along[mesh.tets].max(axis=1)
    several = 0
    for station in _SECTIONS:
        tets = mesh.tets[(low < station) & (high > station)]
        nodes, own = np.unique(tets, return_inverse=True)
        ends = np.repeat(np.arange(len(tets)), tets.shape[1]), own.ravel() + len(tets)
        size = len(tets) + len(nodes)
        graph = csr_array((np.ones(own.size), ends), shape=(size, size))
        _, labels = connected_components(graph, directed=False)
        counts = np.bincount(labels[: len(tets)])
        several += int(counts.sum() - counts.max(initial=0) > _OF_SECTION * counts.sum())
    return several > _OF_SECTIONS * len(_SECTIONS)


def _begin(graph: csr_array, nodes: FloatArray, held: IntArray) -> IntArray:
    """Return where a body begins that has no clamp at one end: nodes, shape (n,)."""
    own = graph[held][:, held]
    count, labels = connected_components(own, directed=False)
    if count > 1:
        places = [nodes[held[labels == number], 0].mean() for number in range(count)]
        return np.asarray(held[labels == int(np.argmin(places))])
    ways = dijkstra(graph, directed=False, indices=held, min_only=True)
    behind = nodes[:, 0] < nodes[held, 0].mean()
    farthest = int(np.argmax(np.where(behind, ways, -1.0)))
    return np.array([farthest], dtype=np.int32)


def _middles(nodes: FloatArray, along: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return middles of sections, and which way they go on, shape (S, 3) each.

    A spline through the nodes, smooth where they are few (P-splines, Eilers and Marx 1996): means
    of single sections would be drawn inwards at the ends, and to the inner side of a bend.
    """
    knots = np.concatenate([[0.0] * 3, np.linspace(0.0, 1.0, _INTERVALS + 1), [1.0] * 3])
    columns = BSpline.design_matrix(along, knots, 3)
    count = columns.shape[1]
    rough = np.diff(np.eye(count), 2, axis=0)
    normal = (columns.T @ columns).toarray() / len(nodes) + _SMOOTH * rough.T @ rough
    values = np.linalg.solve(normal, columns.T @ nodes / len(nodes))
    spline = BSpline(knots, values, 3)
    return np.asarray(spline(_STATIONS)), np.asarray(spline(_STATIONS, 1))


def _carried(tangents: FloatArray) -> FloatArray:
    """Return frames along a line that do not turn about it (parallel transport), (S, 3, 3).

    Args:
        tangents: shape (S, 3).
    """
    frame, found = np.eye(3), []
    for tangent in tangents:
        size = float(np.linalg.norm(tangent))
        if size > 0.0:
            way = tangent / size
            axis, cosine = np.cross(frame[0], way), float(frame[0] @ way)
            sine = float(np.linalg.norm(axis))
            if sine > 0.0:
                frame = frame @ rotation_matrix(axis / sine * np.arctan2(sine, cosine)).T
        found.append(frame)
    return np.stack(found)
