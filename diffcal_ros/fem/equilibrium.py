# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Static equilibrium by a guarded Newton iteration, and exact linear solves at it."""

from collections.abc import Sequence
from dataclasses import dataclass

from diffcal_ros.errors import NotSimulatedError
from diffcal_ros.fem.activity import during
from diffcal_ros.fem.conjugate_gradient import conjugate_gradient
from diffcal_ros.fem.elastic_body import ElasticBody
from diffcal_ros.fem.potential_terms import PotentialTerm
from diffcal_ros.fem.rotation_step import RotationStep
from diffcal_ros.fem.rounding import rounding_of_forces
from diffcal_ros.fem.sparse_pattern import make_pattern
from diffcal_ros.fem.sparse_solver import make_solver, NotPositiveDefiniteError
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]

# Largest force left on a node, relative to the mean nodal load: a tip moves by under 1e-5 of
# its sag, and finite differences of the whole chain still agree to 1e-6.
_FORCE_TOLERANCE = 1e-7
# A step that promises less than this share of the energy follows rounding errors: on fine meshes
# those exceed the force tolerance.
_LEAST_PROMISE = 1e-20
_MAX_STEPS = 100
# So many steps on end, each with less than this share of what its slope promises, lead nowhere:
# an element is about to turn inside out.
_POOR_GAIN = 0.01
_MOST_POOR_STEPS = 15
# A factorisation is held while the last step left no more than this share of the force, and
# promised no more than this share of the energy: sooner, volumes that a step has put wrong want a
# new one.
_HELD_CONTRACTION = 0.1
_HELD_PROMISE = 1e-6
_ARMIJO = 1e-4
_SHORTEST_STEP = 1e-6
# A fall of the energy by less than this share may drown in its rounding, which grows with the
# stiffness and not with the strain; then a smaller force tells a good step.
_UNRESOLVED = 1e-7
# Close to the last state a step need not be exact, and a few iterations with the old
# factorisation cost a fraction of a new one.
_STEP_TOLERANCE = 0.03
_MAX_STEP_STEPS = 8
_FORCING = 0.5
# Of derivatives: what they leave is what an adjoint and a tangent differ by.
_LINEAR_TOLERANCE = 1e-10
_LEAST_TOLERANCE = 1e-8
# With a factorisation in single precision each iteration gains two digits.
_ROUNDED_TOLERANCE = 1e-4
_SOLVED_TOLERANCE = 1e-11
_MAX_LINEAR_STEPS = 25
_MAX_PATIENT_STEPS = 200
_MAX_SHIFTS = 12


class EquilibriumError(NotSimulatedError):
    """No equilibrium was found; the message says what to change."""


@dataclass(frozen=True)
class Equilibrium:
    """A state of rest.

    Attributes:
        positions: node positions [m], shape (N, 3).
        reactions: force that the clamp exerts on each node [N], shape (N, 3); zero on free nodes.
        newton_steps: steps with a new factorisation.
        held_steps: steps with an old one, as it is or with iterations.
    """

    positions: FloatArray
    reactions: FloatArray
    newton_steps: int
    held_steps: int


class EquilibriumSolver:
    """Finds where elastic forces balance the loads while some nodes are held."""

    def __init__(
        self,
        body: ElasticBody,
        held_nodes: IntArray,
        *,
        solver: str = 'auto',
        coupled_nodes: Sequence[NDArray[np.integer]] = (),
    ) -> None:
        """Prepare pattern and solver.

        Args:
            body: whose energy is minimised.
            held_nodes: shape (h,).
            solver: name of the sparse solver.
            coupled_nodes: groups of nodes that a term may couple, each with each.
        """
        if len(held_nodes) < 3:
            raise ValueError(
                f'{len(held_nodes)} nodes are held: a body at rest needs at least three that are '
                'not on a line; check the held boxes of the scene'
            )
        self.body = body
        self.held_nodes = np.asarray(held_nodes, dtype=np.int32)
        node_count = body.discretisation.node_count
        with during(f'ordering the unknowns of {node_count:,} nodes', 3 * node_count):
            self.pattern = make_pattern(
                body.discretisation, self.held_nodes, coupled_nodes=coupled_nodes
            )
            self._free = self.pattern.free_nodes
            self._stiffness = body.make_stiffness(self.pattern)
            self._solver = make_solver(self.pattern, solver)
            self._step = RotationStep(body.discretisation, self.pattern, body.device)
        self._factor_positions: FloatArray | None = None
        self._factor_material = -1
        self._has_factor = False
        self._iterations = 0  # Since the last factorisation, or since a solution was begun.
        self._stiffest = 0.0  # Entry of the last stiffness that was factored [N/m].
        self.terms: tuple[PotentialTerm, ...] = ()

    @property
    def solver_name(self) -> str:
        """Name of the sparse solver in use."""
        return self._solver.name

    def solve(
        self,
        loads: FloatArray,
        start: FloatArray,
        *,
        held_positions: FloatArray | None = None,
        is_warm: bool = False,
    ) -> Equilibrium:
        """Find the equilibrium; the body's material must be set before.

        Args:
            loads: external forces [N], shape (N, 3).
            start: node positions to start from [m], shape (N, 3).
            held_positions: where the held nodes are to be [m], shape (H, 3); default: as in
                `start`.
            is_warm: `start` is close, so try the last factorisation before making a new one.

        Raises:
            EquilibriumError: when no equilibrium was found.
        """
        positions = np.array(start, dtype=np.float64)
        if held_positions is not None:
            change = held_positions - positions[self.held_nodes]
            if np.abs(change).max(initial=0.0) > 0.0:
                positions = self._step.advance(positions, self._step.extend(change), 1.0)
        tolerance = self._tolerance(loads)
        with during(f'equilibrium of {self.pattern.size:,} unknowns', self.pattern.size):
            return self._newton(positions, loads, tolerance, is_warm and self._has_factor)

    def advance(self, positions: FloatArray, displacement: FloatArray) -> FloatArray:
        """Add a displacement [m], shape (N, 3), turning elements instead of stretching them."""
        return self._advance(positions, displacement, 1.0)

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
        is_stale = not self._is_factor_new(positions)
        if not self._has_factor or (is_stale and len(right_sides) > self._solver.few_sides):
            self._make_factor(positions)
        solution = np.zeros_like(right_sides)
        if self._solver.is_exact and self._is_factor_new(positions):
            found = self._solver.solve(np.ascontiguousarray(free_sides.T)).T
        else:
            found = np.stack([self._iterate(positions, side) for side in free_sides])
        solution[:, self._free] = found.reshape(len(right_sides), -1, 3)
        return solution

    def factor_at(self, positions: FloatArray) -> None:
        """Factor the stiffness at an equilibrium [m], shape (N, 3), unless that was done."""
        if not self._is_factor_new(positions):
            self._make_factor(positions)

    def apply_factor(self, forces: FloatArray) -> FloatArray:
        """Solve with the last factorisation as it is, for preconditioning; shape (N, 3)."""
        solution = np.zeros_like(forces)
        solution[self._free] = self._solver.solve(forces[self._free].ravel()).reshape(-1, 3)
        return solution

    def _is_factor_new(self, positions: FloatArray) -> bool:
        return (
            self._factor_positions is not None
            and self._factor_material == self.body.material_count
            and np.array_equal(self._factor_positions, positions)
        )

    def _tolerance(self, loads: FloatArray) -> float:
        """Return the largest force [N] that may be left on a node."""
        mean_load = float(np.linalg.norm(loads[self._free], axis=1).mean())
        volumes = self.body.discretisation.weights.sum(axis=1)
        # Without loads (a clamp that only turns the body) the stiffness gives the scale.
        elastic = 1e-4 * self.body.mean_shear_modulus() * float(np.mean(volumes)) ** (2.0 / 3.0)
        return _FORCE_TOLERANCE * max(mean_load, elastic)

    def _unbalanced(self, positions: FloatArray, loads: FloatArray) -> FloatArray:
        """Return the force left on the free nodes [N], shape (3 M,)."""
        return (loads - self.forces(positions))[self._free].ravel()

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

    def stiffness_values(self, positions: FloatArray, *, is_guarded: bool = False) -> FloatArray:
        """Return the stiffness of the body and of all terms in the pattern [N/m], shape (nnz,)."""
        values = self._stiffness.values(positions, is_guarded=is_guarded)
        for term in self.terms:
            values += term.stiffness(positions, is_guarded=is_guarded)
        return values

    def _make_factor(self, positions: FloatArray) -> None:
        """Factor the stiffness; where it is indefinite, its guarded form, shifted if need be."""
        self._factor_positions = None
        values = self.stiffness_values(positions)
        diagonal = self.pattern.diagonal_slots
        self._stiffest = float(values[diagonal].max())
        shift = 0.0
        for attempt in range(_MAX_SHIFTS):
            try:
                self._solver.factor(values)
            except NotPositiveDefiniteError:
                values = self.stiffness_values(positions, is_guarded=True)
                if attempt > 0:
                    shift = max(4.0 * shift, 1e-4 * float(np.abs(values[diagonal]).mean()))
                    values[diagonal] += shift
                continue
            self._has_factor = True
            if attempt == 0:
                self._factor_positions = positions.copy()
                self._factor_material = self.body.material_count
            return
        raise EquilibriumError(
            'the stiffness stays indefinite: the body may be turned inside out; start from a '
            'stiffer material'
        )

    def _newton(
        self, positions: FloatArray, loads: FloatArray, tolerance: float, is_warm: bool
    ) -> Equilibrium:
        """Step until forces balance; a factorisation is held while each step pays."""
        energy = self._potential(positions, loads)
        newton_steps = held_steps = poor_steps = 0
        before, last, is_rounded = float('inf'), positions, False
        promise = float('inf')
        self._iterations = 0
        for _ in range(_MAX_STEPS):
            force = self._unbalanced(positions, loads)
            largest = float(np.abs(force).max())
            if not np.isfinite(largest):
                break
            if largest < tolerance:
                return self._finish(positions, loads, newton_steps, held_steps)
            if is_rounded and largest > 0.5 * before:
                calmer = positions if largest < before else last
                return self._finish(calmer, loads, newton_steps, held_steps)
            is_rounded = largest < rounding_of_forces(self._stiffest, positions)
            step = None
            if is_warm and self._iterations < self._solver.patience:
                # Iterations begin with the old factorisation as it is, and say if that will do.
                goal = _step_goal(largest, before, tolerance)
                step = self._with_old_factor(
                    positions, force, goal, _MAX_STEP_STEPS, enough=_STEP_TOLERANCE
                )
            elif (
                newton_steps
                and largest < _HELD_CONTRACTION * before
                and promise < _HELD_PROMISE * abs(energy)
            ):
                step = self._solver.solve(force)
            if step is None:
                step = self._with_new_factor(positions, force)
                newton_steps += 1
            else:
                held_steps += 1
            before = largest
            direction = np.zeros_like(positions)
            direction[self._free] = step.reshape(-1, 3)
            slope = float(force @ direction[self._free].ravel())
            if slope < _LEAST_PROMISE * abs(energy):
                return self._finish(positions, loads, newton_steps, held_steps)
            if is_rounded:  # The energy tells nothing any more.
                last, positions = positions, self._advance(positions, direction, 1.0)
                continue
            higher, promise = energy, slope
            positions, energy = self._line_search(positions, direction, slope, energy, loads)
            poor_steps = poor_steps + 1 if higher - energy < _POOR_GAIN * slope else 0
            if poor_steps == _MOST_POOR_STEPS:
                break
        raise EquilibriumError(
            f'no equilibrium after {newton_steps + held_steps} Newton steps: the body may be too '
            "soft for its load (raise the start of Young's modulus) or its held part too small"
        )

    def _with_new_factor(self, positions: FloatArray, force: FloatArray) -> FloatArray:
        """Return a Newton step by a factorisation made for it; shape (3 M,)."""
        self._make_factor(positions)
        self._iterations = 0
        if self._solver.is_exact or not self._is_factor_new(positions):
            return self._solver.solve(force)
        found = self._with_old_factor(positions, force, _ROUNDED_TOLERANCE, _MAX_STEP_STEPS)
        return self._solver.solve(force) if found is None else found

    def _line_search(
        self,
        positions: FloatArray,
        direction: FloatArray,
        slope: float,
        energy: float,
        loads: FloatArray,
    ) -> tuple[FloatArray, float]:
        """Halve the step until the energy falls as its slope promises."""
        rounding = 1e-12 * abs(energy)
        length = 1.0
        while True:
            trial = self._advance(positions, direction, length)
            trial_energy = self._potential(trial, loads)
            if trial_energy <= energy - _ARMIJO * length * slope + rounding:
                return trial, trial_energy
            if slope < _UNRESOLVED * abs(energy) and self._is_calmer(trial, positions, loads):
                return trial, trial_energy
            length *= 0.5
            if length < _SHORTEST_STEP:
                raise EquilibriumError(
                    'the line search found no lower energy: the mesh may have degenerate '
                    "tetrahedra, or the body may be too soft (raise the start of Young's modulus)"
                )

    def _is_calmer(self, trial: FloatArray, positions: FloatArray, loads: FloatArray) -> bool:
        """Tell whether a trial leaves less force."""
        left = [float(np.abs(self._unbalanced(at, loads)).max()) for at in (trial, positions)]
        return left[0] < left[1]

    def _advance(self, positions: FloatArray, direction: FloatArray, length: float) -> FloatArray:
        if self.body.law.TAKES_TURNING_STEPS:
            return self._step.advance(positions, direction, length)
        return positions + length * direction

    def _potential(self, positions: FloatArray, loads: FloatArray) -> float:
        """Return elastic energy less the work of the loads [J]."""
        moved = positions - self.body.discretisation.rest_nodes
        energy = self.body.energy(positions) + sum(term.energy(positions) for term in self.terms)
        return energy - float((loads * moved).sum())

    def _finish(
        self, positions: FloatArray, loads: FloatArray, newton_steps: int, held_steps: int
    ) -> Equilibrium:
        reactions = np.zeros_like(positions)
        reactions[self.held_nodes] = (self.forces(positions) - loads)[self.held_nodes]
        return Equilibrium(positions, reactions, newton_steps, held_steps)

    def _iterate(self, positions: FloatArray, right_side: FloatArray) -> FloatArray:
        """Solve at `positions` for a right side of any size: the squares of small ones vanish."""
        largest = float(np.abs(right_side).max(initial=0.0))
        if largest == 0.0:
            return np.zeros_like(right_side)
        scaled = right_side / largest
        is_new = self._is_factor_new(positions)
        tolerance = _SOLVED_TOLERANCE if is_new else _LINEAR_TOLERANCE
        found = self._with_old_factor(positions, scaled, tolerance, _MAX_LINEAR_STEPS)
        if found is None:
            self.factor_at(positions)
            found = self._with_old_factor(
                positions, scaled, _SOLVED_TOLERANCE, _MAX_PATIENT_STEPS, _LEAST_TOLERANCE
            )
        return largest * (self._solver.solve(scaled) if found is None else found)

    def _with_old_factor(
        self,
        positions: FloatArray,
        right_side: FloatArray,
        tolerance: float,
        max_steps: int,
        enough: float = 0.0,
    ) -> FloatArray | None:
        """Solve stiffness times x = b at `positions`, see `conjugate_gradient`."""
        direction = np.zeros_like(positions)

        def product(vector: FloatArray) -> FloatArray:
            self._iterations += 1
            direction[self._free] = vector.reshape(-1, 3)
            return self.force_tangent(positions, direction)[self._free].ravel()

        return conjugate_gradient(
            product, self._solver.solve, right_side, tolerance, max_steps, enough
        )


def _step_goal(force: float, before: float, tolerance: float) -> float:
    """Return what share of the force a step may leave: the less the closer it is.

    Eisenstat and Walker (1996), second choice; no step need go far below the tolerance.
    """
    goal = min(_STEP_TOLERANCE, _FORCING * (force / before) ** 2)
    return max(goal, _FORCING * tolerance / force)
