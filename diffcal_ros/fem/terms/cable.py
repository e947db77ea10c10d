# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A cable that runs through a body without friction: a spring of its whole length that only pulls.

With L the length over the via points, L0 the rest length and k the stiffness, the tension is

    T(e) = 0              for e <= -w/2      e = L - L0
         = k (e + w/2)^2 / (2 w)  between
         = k e            for e >= w/2

so that the energy is k/2 max(0, e)^2 but for a constant, twice continuously differentiable, and
exactly zero where the cable is slack. w is a small share of the routed length: Newton's method
needs the second derivative, and a cable is never that precise.
"""

from diffcal_ros.fem.elements.element import Discretisation
from diffcal_ros.fem.elements.sparse_pattern import SparsePattern
from diffcal_ros.fem.terms.cable_route import CableRoute
from diffcal_ros.fem.terms.conditions import CableState
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Of the routed length: 0.3 mm of 150.
_SMOOTHING = 2e-3
_SHORTEST_LEG = 1e-9  # [m], keeps directions finite where via points fall together.


class CableTerm:
    """One cable in one body.

    Attributes:
        state: rest length and stiffness now.
        route_length: of the cable in the body at rest [m].
        smoothing: over how much change of length tension sets in [m].
    """

    def __init__(self, route: CableRoute, discretisation: Discretisation) -> None:
        """Prepare a cable; it has no stiffness until `state` is set."""
        self.state = CableState(route.length, 0.0)
        self.route_length = route.length
        self.smoothing = _SMOOTHING * route.length
        nodes, weights = route.nodes_and_weights(discretisation)
        self.nodes, indices = np.unique(nodes, return_inverse=True)
        self._weights = np.zeros((len(nodes), len(self.nodes)))  # (n, u)
        rows = np.arange(len(nodes))[:, None]
        np.add.at(self._weights, (rows, indices.reshape(nodes.shape)), weights)
        self._slots: tuple[NDArray[np.int64], NDArray[np.int64]] | None = None
        self._entry_count = 0

    def use_pattern(self, pattern: SparsePattern) -> None:
        """Find the places of the cable's entries; its nodes must be coupled in the pattern."""
        number = np.full(int(max(pattern.free_nodes.max(), self.nodes.max())) + 1, -1)
        number[pattern.free_nodes] = np.arange(len(pattern.free_nodes))
        unknowns = (3 * number[self.nodes][:, None] + np.arange(3)).ravel()
        unknowns[np.repeat(number[self.nodes] < 0, 3)] = -1
        column, row = np.meshgrid(unknowns, unknowns, indexing='ij')
        stored = np.flatnonzero(((column >= 0) & (row >= column)).ravel())
        columns = np.repeat(np.arange(pattern.size), np.diff(pattern.column_starts))
        keys = columns * pattern.size + pattern.row_indices
        wanted = column.ravel()[stored] * pattern.size + row.ravel()[stored]
        self._slots = stored, np.searchsorted(keys, wanted)
        self._entry_count = pattern.entry_count

    def via_positions(self, positions: FloatArray) -> FloatArray:
        """Return where the via points are [m], shape (n, 3)."""
        return self._weights @ positions[self.nodes]

    def length(self, positions: FloatArray) -> float:
        """Return the length over the via points [m]."""
        return float(np.linalg.norm(np.diff(self.via_positions(positions), axis=0), axis=1).sum())

    def tension(self, positions: FloatArray) -> float:
        """Return the pull along the cable [N]."""
        return self.state.stiffness * self._law(self.length(positions))[1]

    def energy(self, positions: FloatArray) -> float:
        """Return the energy [J]."""
        return self.state.stiffness * self._law(self.length(positions))[0]

    def forces(self, positions: FloatArray) -> FloatArray:
        """Return its gradient [N], shape (N, 3)."""
        return self.tension(positions) * self.length_gradient(positions)

    def length_gradient(self, positions: FloatArray) -> FloatArray:
        """Return the derivative of the length by node positions, shape (N, 3)."""
        gradient = np.zeros_like(positions)
        gradient[self.nodes] = self._weights.T @ self._via_gradient(positions)
        return gradient

    def force_of_rest_length(self, positions: FloatArray) -> FloatArray:
        """Return the derivative of the forces by the rest length [N/m], shape (N, 3)."""
        _, _, rate = self._law(self.length(positions))
        return -self.state.stiffness * rate * self.length_gradient(positions)

    def force_of_stiffness(self, positions: FloatArray) -> FloatArray:
        """Return the derivative of the forces by the stiffness [m], shape (N, 3)."""
        _, pull, _ = self._law(self.length(positions))
        return pull * self.length_gradient(positions)

    def force_tangent(self, positions: FloatArray, direction: FloatArray) -> FloatArray:
        """Return its Hessian times a direction [N], shape (N, 3)."""
        moved = (self._weights @ direction[self.nodes]).ravel()
        forces = np.zeros_like(positions)
        pulled = (self._via_hessian(positions) @ moved).reshape(-1, 3)
        forces[self.nodes] = self._weights.T @ pulled
        return forces

    def stiffness(self, positions: FloatArray, *, is_guarded: bool) -> FloatArray:
        """Return its Hessian's entries in the pattern, shape (nnz,); never indefinite."""
        if self._slots is None:
            raise RuntimeError('the cable knows no pattern: call use_pattern first')
        stored, slots = self._slots
        values = np.zeros(self._entry_count)
        spread = np.kron(self._weights, np.eye(3))
        values[slots] = (spread.T @ self._via_hessian(positions) @ spread).ravel()[stored]
        return values

    def _law(self, length: float) -> tuple[float, float, float]:
        """Return energy, tension and its derivative by the length, all over the stiffness."""
        width, stretch = self.smoothing, length - self.state.rest_length
        if stretch <= -0.5 * width:
            return 0.0, 0.0, 0.0
        if stretch < 0.5 * width:
            above = stretch + 0.5 * width
            fraction = above / width
            return above**2 * fraction / 6.0, 0.5 * above * fraction, fraction
        return 0.5 * (stretch**2 + width**2 / 12.0), stretch, 1.0

    def _legs(self, positions: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return directions, shape (n - 1, 3), and lengths [m] between via points."""
        legs = np.diff(self.via_positions(positions), axis=0)
        lengths = np.maximum(np.linalg.norm(legs, axis=1), _SHORTEST_LEG)
        return legs / lengths[:, None], lengths

    def _via_gradient(self, positions: FloatArray) -> FloatArray:
        """Return the derivative of the length by the via points, shape (n, 3)."""
        directions, _ = self._legs(positions)
        none = np.zeros((1, 3))
        return np.vstack([none, directions]) - np.vstack([directions, none])

    def _via_hessian(self, positions: FloatArray) -> FloatArray:
        """Return the energy's Hessian by the via points [N/m], shape (3 n, 3 n)."""
        directions, lengths = self._legs(positions)
        _, pull, rate = self._law(self.length(positions))
        gradient = self._via_gradient(positions).ravel()
        hessian = rate * np.outer(gradient, gradient)
        for index, (direction, length) in enumerate(zip(directions, lengths, strict=True)):
            across = pull / length * (np.eye(3) - np.outer(direction, direction))
            here, there = slice(3 * index, 3 * index + 3), slice(3 * index + 3, 3 * index + 6)
            hessian[here, here] += across
            hessian[there, there] += across
            hessian[here, there] -= across
            hessian[there, here] -= across
        return self.state.stiffness * hessian
