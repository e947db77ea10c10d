# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the mesh costs: where a better discretisation would put the nodes of this one.

Linear elements lock so badly that only the quadratic ones on the same mesh, solved anew, tell.
For quadratic elements it is one Newton step at half the mesh size from the interpolated
equilibrium, solved by conjugate gradients with two levels: the coarse factorisation and the fine
diagonal. A few percent of accuracy are enough for an error bar. Where the step leaves the region
in which it means something, or the finer body would buckle, it ends at the region's border, as in
Steihaug (1983).
"""

from diffcal_ros.fem.activity import during
from diffcal_ros.fem.elements.elastic_body import ElasticBody
from diffcal_ros.fem.elements.element import Discretisation, Element
from diffcal_ros.fem.elements.prolongation import Enrichment, refine
from diffcal_ros.fem.held_part import HeldPath
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.fem.terms.cable import CableTerm
from diffcal_ros.fem.terms.cable_route import route_through
from diffcal_ros.fem.terms.conditions import CableState, Conditions
from diffcal_ros.material import LameParameters, Material
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

FloatArray = NDArray[np.float64]

_TOLERANCE = 0.05
_MAX_STEPS = 80
# So large a move, as a share of the body's size, is no small one: a linear step tells no more.
_TRUSTED = 0.1


class MeshError:
    """Estimates the discretisation error of one body."""

    def __init__(self, body: StaticBody, *, solver: str = 'auto', device: str = 'cpu') -> None:
        self._body = body
        self._quadratic: StaticBody | None = None
        self._refined: _RefinedBody | None = None
        if body.discretisation.element is Element.LINEAR:
            self._quadratic = StaticBody(
                body.mesh,
                Element.QUADRATIC,
                body.held_vertices,
                law=body.elastic.law,
                solver=solver,
                device=device,
                cables=body.cable_routes,
            )
        else:
            # A node has some seven finer ones.
            count = 3 * 7 * body.discretisation.node_count
            with during('cutting the tetrahedra into finer ones', count):
                self._refined = _RefinedBody(body, device)

    def displacement(
        self,
        material: Material,
        gravity: FloatArray,
        held_path: HeldPath | None = None,
        cables: tuple[CableState, ...] = (),
    ) -> FloatArray:
        """Return how far a better discretisation would move each node [m], shape (N, 3).

        Args:
            material: of the tetrahedra; the body must be in equilibrium under it.
            gravity: [m/s^2], shape (3,).
            held_path: motion of the clamp, as the body was given.
            cables: their states, as the body was given.
        """
        if self._refined is not None:
            return self._refined.displacement(material, gravity, cables)
        assert self._quadratic is not None
        self._quadratic.solve_equilibrium(
            material, gravity, held_path=held_path, conditions=Conditions(cables=cables)
        )
        better = self._quadratic.own_state.positions[: self._body.mesh.vertex_count]
        return better - self._body.own_state.positions


class _RefinedBody:
    """Quadratic elements at half the mesh size."""

    def __init__(self, body: StaticBody, device: str) -> None:
        self._body = body
        self._enrichment: Enrichment = refine(body.own_mesh, body.own_discretisation)
        fine = self._enrichment.fine
        self._elastic = ElasticBody(fine, law=body.elastic.law, device=device)
        self._cables = _cables_through(body, fine)
        is_held = np.zeros(body.discretisation.node_count, dtype=bool)
        is_held[body.held_nodes] = True
        from_middle = fine.rest_nodes - fine.rest_nodes.mean(axis=0)
        self._trusted = _TRUSTED * 2.0 * float(np.linalg.norm(from_middle, axis=1).max())
        self._free = _depends_on_free(self._enrichment.fine_from_coarse, ~is_held)
        self._coarse_places = self._find_coarse_places()

    def displacement(
        self, material: Material, gravity: FloatArray, cables: tuple[CableState, ...]
    ) -> FloatArray:
        """Take one Newton step on the fine nodes; return it at the coarse ones."""
        enrichment, fine = self._enrichment, self._enrichment.fine
        lame_parameters, parents = material.lame_parameters(), enrichment.parents
        self._elastic.set_lame_parameters(
            LameParameters(
                lame_parameters.neo_hookean_mu[parents],
                lame_parameters.neo_hookean_lambda[parents],
            )
        )
        positions = enrichment.fine_from_coarse @ self._body.own_state.positions
        fractions = fine.load_fractions * material.density[parents][:, None]
        masses = np.bincount(fine.nodes.ravel(), fractions.ravel(), fine.node_count)
        unbalanced = masses[:, None] * gravity - self._elastic.forces(positions)
        for cable, state in zip(self._cables, cables, strict=bool(cables)):
            cable.state = state
            unbalanced -= cable.forces(positions)
        unbalanced[~self._free] = 0.0
        with during(f'a step of {fine.node_count:,} finer nodes', 3 * fine.node_count):
            change = self._solve(positions, unbalanced)
        return change[self._coarse_places]

    def _solve(self, positions: FloatArray, right_side: FloatArray) -> FloatArray:
        smoother = np.linalg.inv(self._elastic.diagonal_blocks(positions)).astype(np.float64)
        solution = np.zeros_like(right_side)
        residual = right_side.copy()
        preconditioned = self._precondition(smoother, residual)
        search = preconditioned.copy()
        weight = first = float((residual * preconditioned).sum())
        for _ in range(_MAX_STEPS):
            if weight <= _TOLERANCE**2 * first:
                break
            image = self._elastic.force_tangent(positions, search)
            for cable in self._cables:
                image += cable.force_tangent(positions, search)
            image[~self._free] = 0.0
            curvature = float((search * image).sum())
            length = weight / curvature if curvature > 0.0 else np.inf
            rest = _largest_fraction(solution, search, self._trusted)
            if length > rest:
                return solution + rest * search
            solution += length * search
            residual -= length * image
            preconditioned = self._precondition(smoother, residual)
            before, weight = weight, float((residual * preconditioned).sum())
            search = preconditioned + weight / before * search
        return solution

    def _precondition(self, smoother: FloatArray, residual: FloatArray) -> FloatArray:
        fine_from_coarse = self._enrichment.fine_from_coarse
        result = np.einsum('nij,nj->ni', smoother, residual)
        result[~self._free] = 0.0
        coarse = self._body.solver.stiffness.apply_factor(fine_from_coarse.T @ residual)
        return result + fine_from_coarse @ coarse

    def _find_coarse_places(self) -> NDArray[np.int64]:
        """Return the fine node at each coarse node."""
        interpolation = self._enrichment.fine_from_coarse.tocoo()
        indices = np.full(interpolation.shape[1], -1, dtype=np.int64)
        exact = interpolation.data == 1.0
        indices[interpolation.col[exact]] = interpolation.row[exact]
        return indices


def _cables_through(body: StaticBody, fine: Discretisation) -> tuple[CableTerm, ...]:
    """Lead a body's cables through finer elements."""
    mesh = TetMesh(fine.rest_nodes, fine.nodes[:, :4])
    routes = [
        route_through(
            mesh, cable.via_positions(body.own_discretisation.rest_nodes), may_cross_gaps=True
        )
        for cable in body.cables
    ]
    return tuple(CableTerm(route, fine) for route in routes)


def _largest_fraction(moves: FloatArray, further: FloatArray, limit: float) -> float:
    """Return how much of a further move takes the first node to a limit [m], shape (N, 3) each.

    Args:
        moves: within the limit.
        further: not zero everywhere.
        limit: length that no node's move is to exceed.
    """
    square = (further**2).sum(axis=1)
    half = (moves * further).sum(axis=1)
    room = limit**2 - (moves**2).sum(axis=1)
    is_moved = square > 0.0
    square, half, room = square[is_moved], half[is_moved], room[is_moved]
    return float(((np.sqrt(half**2 + square * room) - half) / square).min())


def _depends_on_free(
    fine_from_coarse: csr_matrix, is_free: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Tell which fine nodes hang on at least one free coarse node."""
    return np.asarray(abs(fine_from_coarse) @ is_free.astype(np.float64) > 0.0)
