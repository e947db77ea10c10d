# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The stiffness of a body and of all that acts on it at some positions, and solves with it."""

from collections.abc import Sequence
from functools import partial

from diffcal_ros.errors import NotSimulatedError
from diffcal_ros.fem.activity import during
from diffcal_ros.fem.elements.elastic_body import ElasticBody
from diffcal_ros.fem.elements.sparse_pattern import make_pattern
from diffcal_ros.fem.linear_solvers import make_solver, NotPositiveDefiniteError
from diffcal_ros.fem.linear_solvers.conjugate_gradient import conjugate_gradient
from diffcal_ros.fem.terms.potential_terms import PotentialTerm
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]

# Of derivatives: what they leave is what an adjoint and a tangent differ by.
_LINEAR_TOLERANCE = 1e-10
_LEAST_TOLERANCE = 1e-8
# With a factorisation in single precision each iteration gains two digits.
_ROUNDED_TOLERANCE = 1e-4
# Far from equilibrium a step's own model leaves more.
_FAR_TOLERANCE = 1e-2
_MAX_ROUNDED_STEPS = 8
_SOLVED_TOLERANCE = 1e-11
_MAX_LINEAR_STEPS = 25
_MAX_PATIENT_STEPS = 200
_MAX_SHIFTS = 12
# Since a factorisation the body has moved by less of its length: so few iterations will do.
_CLOSE = 1e-3
_CLOSE_STEPS = 5


class EquilibriumError(NotSimulatedError):
    """No equilibrium was found; the message says what to change."""


class TangentStiffness:
    """Forces and stiffness of a body with its terms, and the last factorisation.

    Attributes:
        pattern: of the free nodes' stiffness.
        terms: that act beside the elements.
        stiffest: entry of the last stiffness that was factored [N/m].
    """

    def __init__(
        self,
        body: ElasticBody,
        held_nodes: IntArray,
        *,
        solver: str = 'auto',
        coupled_nodes: Sequence[NDArray[np.integer]] = (),
    ) -> None:
        """Prepare pattern and sparse solver.

        Args:
            body: whose elements are stiff.
            held_nodes: shape (h,).
            solver: name of the sparse solver.
            coupled_nodes: groups of nodes that a term may couple, each with each.
        """
        self.body = body
        node_count = body.discretisation.node_count
        with during(f'ordering the unknowns of {node_count:,} nodes', 3 * node_count):
            self.pattern = make_pattern(
                body.discretisation, held_nodes, coupled_nodes=coupled_nodes
            )
            self._free = self.pattern.free_nodes
            self._stiffness = body.make_stiffness(self.pattern)
            self._solver = make_solver(self.pattern, solver, device=body.device)
        self._factor_positions: FloatArray | None = None
        self._factor_material = -1
        self._iterations = 0  # Since the last factorisation, or since a solution was begun.
        self.has_factor = False
        self.stiffest = 0.0
        self.terms: tuple[PotentialTerm, ...] = ()

    @property
    def solver_name(self) -> str:
        """Name of the sparse solver in use."""
        return self._solver.name

    def forces(self, positions: FloatArray) -> FloatArray:
        """Return the gradient of the body's energy and of all terms [N], shape (N, 3)."""
        forces = self.body.forces(positions)
        for term in self.terms:
            forces += term.forces(positions)
        return forces

    def force_tangent(self, positions: FloatArray, direction: FloatArray) -> FloatArray:
        """Return stiffness times a direction [N], shape (N, 3)."""
        forces = self.body.force_tangent(positions, direction)
        for term in self.terms:
            forces += term.force_tangent(positions, direction)
        return forces

    def values(
        self, positions: FloatArray, *, is_guarded: bool = False, is_foreseen: bool = False
    ) -> FloatArray:
        """Return the stiffness of the body and of all terms in the pattern [N/m], shape (nnz,)."""
        values = self._stiffness.values(positions, is_guarded=is_guarded, is_foreseen=is_foreseen)
        for term in self.terms:
            values += term.stiffness(positions, is_guarded=is_guarded)
        return values

    def linear_solve(self, positions: FloatArray, right_sides: FloatArray) -> FloatArray:
        """Solve stiffness times x = b at an equilibrium, exactly.

        The last factorisation serves as preconditioner when it was made at other positions.

        Args:
            positions: the equilibrium [m], shape (N, 3).
            right_sides: [N], shape (k, N, 3); entries of held nodes are ignored.

        Returns:
            Displacements [m], shape (k, N, 3), zero on held nodes.
        """
        with during(f'derivatives of {self.pattern.size:,} unknowns', self.pattern.size):
            return self._solve_sides(positions, right_sides)

    def _solve_sides(self, positions: FloatArray, right_sides: FloatArray) -> FloatArray:
        free_sides = right_sides[:, self._free].reshape(len(right_sides), -1)
        is_stale = not self.is_factored_at(positions)
        if not self.has_factor or (is_stale and len(right_sides) > self._few_sides(positions)):
            self.factor(positions)
        solution = np.zeros_like(right_sides)
        if self._solver.is_exact and self.is_factored_at(positions):
            found = self._solver.solve(np.ascontiguousarray(free_sides.T)).T
        else:
            found = np.stack([self._solve_side(positions, side) for side in free_sides])
        solution[:, self._free] = found.reshape(len(right_sides), -1, 3)
        return solution

    def _few_sides(self, positions: FloatArray) -> int:
        """Return for how many sides iterations with the last factorisation take less time."""
        last = self._factor_positions
        if last is None or self._factor_material != self.body.material_count:
            return self._solver.few_sides
        moved = float(np.abs(positions - last).max())
        is_close = moved < _CLOSE * float(np.ptp(positions, axis=0).max())
        return max(self._solver.few_sides, is_close * self._solver.patience // _CLOSE_STEPS)

    def factor_at(self, positions: FloatArray) -> None:
        """Factor the stiffness at an equilibrium [m], shape (N, 3), unless that was done."""
        if not self.is_factored_at(positions):
            self.factor(positions)

    def apply_factor(self, forces: FloatArray) -> FloatArray:
        """Solve with the last factorisation as it is, for preconditioning; shape (N, 3)."""
        solution = np.zeros_like(forces)
        solution[self._free] = self._solver.solve(forces[self._free].ravel()).reshape(-1, 3)
        return solution

    def is_factored_at(self, positions: FloatArray) -> bool:
        """Tell whether the last factorisation is that of the stiffness at some positions."""
        return (
            self._factor_positions is not None
            and self._factor_material == self.body.material_count
            and np.array_equal(self._factor_positions, positions)
        )

    @property
    def foresees(self) -> bool:
        """Tell whether pressures can be foreseen, see `Stiffness.values`."""
        return self._stiffness.foresees

    def foresee(self, before: FloatArray, step: FloatArray) -> None:
        """Keep a step [m] and where it began for the next factorisation, shape (N, 3) each."""
        self._stiffness.foresee(before, step)

    def factor(self, positions: FloatArray, *, is_foreseen: bool = False) -> FloatArray:
        """Factor the stiffness; where it is indefinite, its guarded form, shifted if need be.

        Args:
            positions: [m], shape (N, 3).
            is_foreseen: with the pressures of the last step, see `Stiffness.values`.

        Returns:
            The entries that were factored, shape (nnz,).
        """
        self._factor_positions = None
        self._iterations = 0
        is_foreseen = is_foreseen and self._stiffness.knows_step
        values = self.values(positions, is_foreseen=is_foreseen)
        diagonal = self.pattern.diagonal_slots
        self.stiffest = float(values[diagonal].max())
        shift = 0.0
        for attempt in range(_MAX_SHIFTS):
            try:
                self._solver.factor(values)
            except NotPositiveDefiniteError:
                values = self.values(positions, is_guarded=True)
                if attempt > 0:
                    shift = max(4.0 * shift, 1e-4 * float(np.abs(values[diagonal]).mean()))
                    values[diagonal] += shift
                continue
            self.has_factor = True
            if attempt == 0 and not is_foreseen:
                self._factor_positions = positions.copy()
                self._factor_material = self.body.material_count
            return values
        raise EquilibriumError(
            'the stiffness stays indefinite: the body may be turned inside out; start from a '
            'stiffer material'
        )

    def solve_by_new_factor(
        self, positions: FloatArray, force: FloatArray, *, is_foreseen: bool = False
    ) -> FloatArray:
        """Solve by a factorisation that is made for it, see `factor`; shape (3 M,)."""
        values = self.factor(positions, is_foreseen=is_foreseen)
        if self._solver.is_exact:
            return self._solver.solve(force)
        product = partial(self.pattern.times, values)
        tolerance = _FAR_TOLERANCE if is_foreseen else _ROUNDED_TOLERANCE
        found = conjugate_gradient(
            product, self._solver.solve, force, tolerance, _MAX_ROUNDED_STEPS
        )
        return self._solver.solve(force) if found is None else found

    def begin(self) -> None:
        """Count iterations anew: another solution begins."""
        self._iterations = 0
        self._stiffness.forget_step()

    @property
    def patience(self) -> int:
        """Iterations with the last factorisation that take about as long as a new one."""
        return self._solver.patience

    @property
    def is_patient(self) -> bool:
        """Tell whether iterations with the last factorisation still pay."""
        return self._iterations < self._solver.patience

    def _solve_side(self, positions: FloatArray, right_side: FloatArray) -> FloatArray:
        """Solve at `positions` for a right side of any size: the squares of small ones vanish."""
        largest = float(np.abs(right_side).max(initial=0.0))
        if largest == 0.0:
            return np.zeros_like(right_side)
        scaled = right_side / largest
        is_new = self.is_factored_at(positions)
        tolerance = _SOLVED_TOLERANCE if is_new else _LINEAR_TOLERANCE
        found = self.iterate(positions, scaled, tolerance, _MAX_LINEAR_STEPS)
        if found is None:
            self.factor_at(positions)
            found = self.iterate(
                positions, scaled, _SOLVED_TOLERANCE, _MAX_PATIENT_STEPS, _LEAST_TOLERANCE
            )
        return largest * (self._solver.solve(scaled) if found is None else found)

    def iterate(
        self,
        positions: FloatArray,
        right_side: FloatArray,
        tolerance: float,
        max_steps: int,
        enough: float = 0.0,
        patience: float = np.inf,
    ) -> FloatArray | None:
        """Solve stiffness times x = b at `positions` with the last factorisation, (3 M,).

        See `conjugate_gradient`: None where it does not come to the tolerance in so many steps.
        """
        direction = np.zeros_like(positions)

        def product(vector: FloatArray) -> FloatArray:
            self._iterations += 1
            direction[self._free] = vector.reshape(-1, 3)
            return self.force_tangent(positions, direction)[self._free].ravel()

        return conjugate_gradient(
            product, self._solver.solve, right_side, tolerance, max_steps, enough, patience
        )
