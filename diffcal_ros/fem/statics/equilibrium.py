# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Static equilibrium by a guarded Newton iteration."""

from collections.abc import Sequence
from dataclasses import dataclass

from diffcal_ros.fem.activity import during
from diffcal_ros.fem.elements.elastic_body import ElasticBody
from diffcal_ros.fem.statics.rotation_step import RotationStep
from diffcal_ros.fem.statics.rounding import rounding_of_forces
from diffcal_ros.fem.statics.tangent_stiffness import EquilibriumError as EquilibriumError
from diffcal_ros.fem.statics.tangent_stiffness import TangentStiffness
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
# Below this share a step puts volumes wrong by so little that pressures need not be foreseen, and
# derivatives can use the factorisation.
_FORESEEN_PROMISE = 1e-3
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
        self.stiffness = TangentStiffness(
            body, self.held_nodes, solver=solver, coupled_nodes=coupled_nodes
        )
        pattern = self.stiffness.pattern
        self._free, self._size = pattern.free_nodes, pattern.size
        self._step = RotationStep(body.discretisation, pattern, body.device)

    def solve(
        self,
        loads: FloatArray,
        start: FloatArray,
        *,
        held_positions: FloatArray | None = None,
        is_warm: bool = False,
        is_foreseen: bool = True,
    ) -> Equilibrium:
        """Find the equilibrium; the body's material must be set before.

        Args:
            loads: external forces [N], shape (N, 3).
            start: node positions to start from [m], shape (N, 3).
            held_positions: where the held nodes are to be [m], shape (H, 3); default: as in
                `start`.
            is_warm: `start` is close, so try the last factorisation before making a new one.
            is_foreseen: each stiffness has the pressures that the last step foresaw, see
                `Stiffness.values`.

        Raises:
            EquilibriumError: when no equilibrium was found.
        """
        positions = np.array(start, dtype=np.float64)
        if held_positions is not None:
            change = held_positions - positions[self.held_nodes]
            if np.abs(change).max(initial=0.0) > 0.0:
                positions = self._step.advance(positions, self._step.extend(change), 1.0)
        tolerance = self._tolerance(loads)
        with during(f'equilibrium of {self._size:,} unknowns', self._size):
            is_warm = is_warm and self.stiffness.has_factor
            return self._newton(positions, loads, tolerance, is_warm, is_foreseen)

    def advance(self, positions: FloatArray, displacement: FloatArray) -> FloatArray:
        """Add a displacement [m], shape (N, 3), turning elements instead of stretching them."""
        return self._advance(positions, displacement, 1.0)

    def _tolerance(self, loads: FloatArray) -> float:
        """Return the largest force [N] that may be left on a node."""
        mean_load = float(np.linalg.norm(loads[self._free], axis=1).mean())
        volumes = self.body.discretisation.weights.sum(axis=1)
        # Without loads (a clamp that only turns the body) the stiffness gives the scale.
        elastic = 1e-4 * self.body.mean_shear_modulus() * float(np.mean(volumes)) ** (2.0 / 3.0)
        return _FORCE_TOLERANCE * max(mean_load, elastic)

    def _unbalanced(self, positions: FloatArray, loads: FloatArray) -> FloatArray:
        """Return the force left on the free nodes [N], shape (3 M,)."""
        return (loads - self.stiffness.forces(positions))[self._free].ravel()

    def _newton(
        self,
        positions: FloatArray,
        loads: FloatArray,
        tolerance: float,
        is_warm: bool,
        is_foreseen: bool,
    ) -> Equilibrium:
        """Step until forces balance; a factorisation is held while each step pays."""
        energy = self._potential(positions, loads)
        counts = _StepCounts()
        before, last, is_rounded = float('inf'), positions, False
        promise = float('inf')
        self.stiffness.begin()
        for _ in range(_MAX_STEPS):
            force = self._unbalanced(positions, loads)
            largest = float(np.abs(force).max())
            if not np.isfinite(largest):
                break
            if largest < tolerance:
                return self._finish(positions, loads, counts)
            if is_rounded and largest > 0.5 * before:
                return self._finish(positions if largest < before else last, loads, counts)
            is_rounded = largest < rounding_of_forces(self.stiffness.stiffest, positions)
            step = None
            is_close = (
                counts.new > 0
                and promise < _HELD_PROMISE * abs(energy)
                and largest < _HELD_CONTRACTION * before
            )
            if (is_warm or is_close) and self.stiffness.is_patient:
                goal = _step_goal(largest, before, tolerance)
                step = self._step_by_last_factor(positions, force, goal)
            counts.add(is_held=step is not None)
            if step is None:
                is_rough = promise > _FORESEEN_PROMISE * abs(energy)
                step = self.stiffness.solve_by_new_factor(
                    positions, force, is_foreseen=is_foreseen and is_rough
                )
            before, slope = largest, float(force @ step)
            if slope < _LEAST_PROMISE * abs(energy):
                return self._finish(positions, loads, counts)
            direction = np.zeros_like(positions)
            direction[self._free] = step.reshape(-1, 3)
            if is_rounded:  # The energy tells nothing any more.
                last, positions = positions, self._advance(positions, direction, 1.0)
                continue
            higher, promise = energy, slope
            start = positions
            positions, energy, length = self._line_search(
                positions, direction, slope, energy, loads
            )
            self.stiffness.foresee(start, length * direction)
            if counts.lead_nowhere(is_poor=higher - energy < _POOR_GAIN * slope):
                break
        raise EquilibriumError(
            f'no equilibrium after {counts.new + counts.held} Newton steps: the body may be too '
            "soft for its load (raise the start of Young's modulus) or its held part too small"
        )

    def _step_by_last_factor(
        self, positions: FloatArray, force: FloatArray, goal: float
    ) -> FloatArray | None:
        """Iterate with the old factorisation; None: a new one takes less time.

        Iterations begin with it as it is, and say if that will do.
        """
        stiffness = self.stiffness
        return stiffness.iterate(
            positions, force, goal, _MAX_STEP_STEPS, _STEP_TOLERANCE, stiffness.patience
        )

    def _line_search(
        self,
        positions: FloatArray,
        direction: FloatArray,
        slope: float,
        energy: float,
        loads: FloatArray,
    ) -> tuple[FloatArray, float, float]:
        """Halve the step until the energy falls as its slope promises; return its length last."""
        rounding = 1e-12 * abs(energy)
        length = 1.0
        while True:
            trial = self._advance(positions, direction, length)
            trial_energy = self._potential(trial, loads)
            if trial_energy <= energy - _ARMIJO * length * slope + rounding:
                return trial, trial_energy, length
            if slope < _UNRESOLVED * abs(energy) and self._is_calmer(trial, positions, loads):
                return trial, trial_energy, length
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
        energy = self.body.energy(positions) + sum(
            term.energy(positions) for term in self.stiffness.terms
        )
        return energy - float((loads * moved).sum())

    def _finish(
        self, positions: FloatArray, loads: FloatArray, counts: '_StepCounts'
    ) -> Equilibrium:
        reactions = np.zeros_like(positions)
        reactions[self.held_nodes] = (self.stiffness.forces(positions) - loads)[self.held_nodes]
        return Equilibrium(positions, reactions, counts.new, counts.held)


@dataclass
class _StepCounts:
    """Steps so far, with a new factorisation and with an old one, and poor ones on end."""

    new: int = 0
    held: int = 0
    poor: int = 0

    def add(self, *, is_held: bool) -> None:
        """Count a step."""
        self.held += is_held
        self.new += not is_held

    def lead_nowhere(self, *, is_poor: bool) -> bool:
        """Tell whether too many on end gained little, the last one included."""
        self.poor = self.poor + 1 if is_poor else 0
        return self.poor == _MOST_POOR_STEPS


def _step_goal(force: float, before: float, tolerance: float) -> float:
    """Return what share of the force a step may leave: the less the closer it is.

    Eisenstat and Walker (1996), second choice; no step need go far below the tolerance.
    """
    goal = min(_STEP_TOLERANCE, _FORCING * (force / before) ** 2)
    return max(goal, _FORCING * tolerance / force)
