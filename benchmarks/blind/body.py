# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Energy, forces and banded stiffness of a body of hexahedra."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import reverse_cuthill_mckee

from benchmarks.blind.hexahedra import integrate, Quadrature
from benchmarks.blind.material import (
    Constants,
    respond,
    Response,
    squares_stiffness,
    squares_stress,
)
from benchmarks.blind.shapes import FloatArray

IntArray = NDArray[np.int64]

_ORDER = 60  # Numbers of an element: 20 nodes of 3.


@dataclass(frozen=True)
class Elastic:
    """What one evaluation gives.

    Attributes:
        energy: [J].
        gradient: derivative by node positions [N], shape (N, 3).
        blocks: element stiffness [N/m], shape (C, 60, 60); None when not asked for.
    """

    energy: float
    gradient: FloatArray
    blocks: FloatArray | None


@dataclass(frozen=True)
class Body:
    """An elastic body.

    Attributes:
        cells: nodes of each element, shape (C, 20).
        quadrature: over the shape without stress.
        numbers: of the law, (C, 8).
        masses: consistent, lumped by shape functions [kg], shape (N,).
        held: nodes that the clamp moves, ascending.
    """

    cells: IntArray
    quadrature: Quadrature
    numbers: Constants
    masses: FloatArray
    held: IntArray

    @property
    def node_count(self) -> int:
        """Number of nodes."""
        return len(self.masses)

    @cached_property
    def cross_gradients(self) -> FloatArray:
        """Cross products of shape gradients, shape (C, 24, 400): one row per point and axis."""
        g = self.quadrature.gradients
        cross = np.cross(g[:, :, :, None], g[:, :, None, :])
        return np.ascontiguousarray(np.moveaxis(cross, -1, 2)).reshape(len(g), 24, 400)

    def evaluate(self, positions: FloatArray, *, with_stiffness: bool = True) -> Elastic:
        """Evaluate at node positions [m], shape (N, 3), object frame."""
        gradients, volumes = self.quadrature.gradients, self.quadrature.volumes
        x = positions[self.cells]
        F = np.swapaxes(x, 1, 2)[:, None] @ gradients
        law = respond(F, self.numbers)
        stress = law.along[..., None, None] * F + law.pressure[..., None, None] * law.cofactor
        if law.squares.any():
            stress = stress + squares_stress(F, law.squares)
        for family in self.numbers.families:
            stress = stress + family.stress(F)
        forces = (volumes[..., None, None] * gradients @ np.swapaxes(stress, -1, -2)).sum(axis=1)
        gradient = np.zeros((self.node_count, 3))
        for axis in range(3):
            gradient[:, axis] = np.bincount(
                self.cells.ravel(), forces[..., axis].ravel(), self.node_count
            )
        energy = float((volumes * law.energy).sum())
        if not with_stiffness:
            return Elastic(energy, gradient, None)
        return Elastic(energy, gradient, self._blocks(F, law))

    def _blocks(self, F: FloatArray, law: Response) -> FloatArray:
        """Return the stiffness of the elements: outer products, then what keeps an axis."""
        gradients, volumes = self.quadrature.gradients, self.quadrature.volumes
        count = len(self.cells)
        along_F = (
            gradients @ np.swapaxes(F, -1, -2) * np.sqrt(volumes * law.stretch)[..., None, None]
        )
        along_C = (
            gradients
            @ np.swapaxes(law.cofactor, -1, -2)
            * np.sqrt(volumes * law.bulk)[..., None, None]
        )
        outer = np.concatenate([along_F, along_C], axis=1).reshape(count, 16, _ORDER)
        blocks = np.swapaxes(outer, 1, 2) @ outer
        blocks = blocks.reshape(count, 20, 3, 20, 3)
        flat = np.swapaxes(gradients, 1, 2).reshape(count, 20, 24)
        scaled = gradients * (volumes * law.along)[..., None, None]
        diagonal = flat @ np.swapaxes(np.swapaxes(scaled, 1, 2).reshape(count, 20, 24), 1, 2)
        pressure = (volumes * law.pressure)[..., None, None] * F
        turns = np.swapaxes(pressure, 1, 2).reshape(count, 3, 24) @ self.cross_gradients
        turns = turns.reshape(count, 3, 20, 20)
        for axis in range(3):
            blocks[:, :, axis, :, axis] += diagonal
            one, two = (axis + 1) % 3, (axis + 2) % 3
            blocks[:, :, one, :, two] += turns[:, axis]
            blocks[:, :, two, :, one] -= turns[:, axis]
        if law.squares.any():
            slopes = squares_stiffness(F, law.squares * volumes)
            half = np.einsum('cqiIjJ,cqbJ->cqiIjb', slopes, gradients, optimize=True)
            blocks += np.einsum('cqaI,cqiIjb->caibj', gradients, half, optimize=True)
        for family in self.numbers.families:
            blocks += family.blocks(F, gradients, volumes)
        return blocks.reshape(count, _ORDER, _ORDER)

    @cached_property
    def band(self) -> 'Band':
        """Where the element blocks of free nodes go in a banded matrix."""
        return make_band(self.cells, self.held, self.node_count)


@dataclass(frozen=True)
class Band:
    """Lower band storage of the free numbers, ordered to be narrow.

    Attributes:
        order: place of each number (3 N) in the matrix; -1 where held, shape (3 N,).
        numbers: the number at each place, shape (n,).
        width: diagonals below the main one.
        targets: flat position in the band of each kept block entry.
        entries: flat index of those entries in the blocks.
    """

    order: IntArray
    numbers: IntArray
    width: int
    targets: IntArray
    entries: IntArray

    def assemble(self, blocks: FloatArray) -> FloatArray:
        """Sum element blocks into lower band storage, shape (width + 1, n)."""
        size = (self.width + 1) * len(self.numbers)
        values = np.bincount(self.targets, blocks.ravel()[self.entries], size).astype(np.float64)
        return values.reshape(self.width + 1, len(self.numbers))


def make_band(cells: IntArray, held: IntArray, node_count: int) -> Band:
    """Order free nodes by reverse Cuthill-McKee and place every block entry."""
    pairs = np.stack(
        [np.repeat(cells, 20, axis=1).ravel(), np.tile(cells, (1, 20)).ravel()], axis=0
    )
    ones = np.ones(pairs.shape[1], dtype=np.int8)
    graph = coo_array((ones, (pairs[0], pairs[1])), shape=(node_count, node_count)).tocsr()
    ranking = reverse_cuthill_mckee(graph, symmetric_mode=True).astype(np.int64)
    ranking = ranking[~np.isin(ranking, held)]
    numbers = (3 * ranking[:, None] + np.arange(3)).ravel()
    order = np.full(3 * node_count, -1)
    order[numbers] = np.arange(len(numbers))
    own = order[(3 * cells[:, :, None] + np.arange(3)).reshape(len(cells), _ORDER)]
    rows = np.repeat(own, _ORDER, axis=1).ravel()
    columns = np.tile(own, (1, _ORDER)).ravel()
    entries = np.flatnonzero((columns >= 0) & (rows >= columns))
    below = rows[entries] - columns[entries]
    targets = below * len(numbers) + columns[entries]
    return Band(order, numbers, int(below.max()), targets, entries)


def make_body(
    stress_free: FloatArray,
    cells: IntArray,
    held: IntArray,
    numbers: Constants,
    density: float,
) -> Body:
    """Build a body of one density.

    Args:
        stress_free: node positions without stress [m], shape (N, 3).
        cells: shape (C, 20).
        held: nodes in the clamp.
        numbers: of the law.
        density: [kg/m^3].
    """
    quadrature = integrate(stress_free, cells)
    return Body(
        cells=cells,
        quadrature=quadrature,
        numbers=numbers,
        masses=spread(density * quadrature.volumes, quadrature, cells, len(stress_free)),
        held=held,
    )


def spread(
    masses: FloatArray, quadrature: Quadrature, cells: IntArray, node_count: int
) -> FloatArray:
    """Give masses of Gauss points (C, 8) to the nodes by their shape functions [kg]."""
    weights = (masses @ quadrature.values).ravel()
    return np.bincount(cells.ravel(), weights, node_count).astype(np.float64)
