# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effects put to work on one body: its terms, its shape without stress, and how forces follow."""

from collections.abc import Hashable, Sequence

from diffcal_ros.fem.body_axes import BodyAxes
from diffcal_ros.fem.elements.element import Discretisation
from diffcal_ros.fem.statics.tangent_stiffness import TangentStiffness
from diffcal_ros.fem.terms.cable import CableTerm
from diffcal_ros.fem.terms.conditions import CableState, Conditions, NO_CONDITIONS
from diffcal_ros.fem.terms.potential_terms import AddedTerm, Potential
from diffcal_ros.fem.terms.rest_shape import bent_discretisation
from diffcal_ros.material import LameParameters
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Step of a finite difference by curvature, as a bend of the whole body [rad]: forces are exact to
# 1e-15 of stresses by strains of one, so that one side of it is exact to a millionth.
_BEND_STEP = 1e-6
# Bent shapes that are kept: here and a step beside it, for a curvature and for another.
_MOST_SHAPES = 8


class AppliedConditions:
    """Keeps the terms of a body's stiffness up to date with the effects on it.

    Attributes:
        now: the effects.
        axes: of the body, about which it bends.
        cables: that run through the body.
    """

    def __init__(
        self,
        mesh: TetMesh,
        stiffness: TangentStiffness,
        axes: BodyAxes,
        cables: Sequence[CableTerm],
        origin: FloatArray,
    ) -> None:
        """Prepare a body without effects.

        Args:
            mesh: the body at rest, like all positions here in the body's own frame.
            stiffness: of the body and its terms.
            axes: of the body.
            cables: that run through it.
            origin: of its own frame in the world [m], shape (3,): potentials are given there.
        """
        self.now = NO_CONDITIONS
        self._origin = origin
        self.cables = tuple(cables)
        self._mesh = mesh
        self._stiffness = stiffness
        self._terms: dict[Hashable, AddedTerm] = {}
        self._acting: list[AddedTerm] = []
        self._shear_moduli = np.zeros(0)
        self._shape = stiffness.body.discretisation  # Without stress.
        self.axes = axes
        self._rates = np.zeros((1, 3))  # Of the shape without stress.
        self._shapes: dict[bytes, Discretisation] = {}

    def apply(self, conditions: Conditions, lame_parameters: LameParameters) -> None:
        """Put effects to work; the material is set already."""
        self.now = conditions
        self._shear_moduli = lame_parameters.neo_hookean_mu
        terms = {p.kind: self._term(p) for p in conditions.potentials}
        if len(terms) < len(conditions.potentials):
            raise ValueError(f'two potentials of one kind act at once: {conditions.potentials}')
        for potential in conditions.potentials:
            own = potential.seen_from(self._origin)
            terms[potential.kind].take(own, self._shear_moduli)
        self._acting = list(terms.values())
        self._stiffness.terms = (*self._acting, *self._pulling_cables(conditions))
        if not np.array_equal(conditions.rest_rates, self._rates):
            self._bend(conditions.rest_rates)

    def force_change(
        self, positions: FloatArray, change: Conditions, gravity: FloatArray
    ) -> FloatArray:
        """Return how the force on each node changes [N], shape (N, 3); the clamp stays."""
        force = np.zeros_like(positions)
        if change.added_masses is not None:
            force += change.added_masses[:, None] * gravity
        if change.forces is not None:
            force += change.forces
        for direction in change.potentials:
            term = self._term(direction)
            own = direction.seen_from(self._origin)
            force -= term.force_along(positions, own, self._shear_moduli)
        if change.rest_rates.any():
            force -= self._force_of_bends(positions, change.rest_rates)
        if change.cables:
            for cable, rates in zip(self.cables, change.cables, strict=True):
                force -= rates.rest_length * cable.force_of_rest_length(positions)
                force -= rates.stiffness * cable.force_of_stiffness(positions)
        return force

    def force_of_shear_moduli(self, positions: FloatArray, change: FloatArray) -> FloatArray:
        """Return how the terms' forces follow the shear moduli [N], shape (N, 3)."""
        forces = np.zeros_like(positions)
        for term in self._acting:
            forces += term.force_of_shear_moduli(positions, change)
        return forces

    def shear_modulus_gradient(
        self, positions: FloatArray, adjoint: FloatArray
    ) -> FloatArray | None:
        """Return adjoint . d terms' forces by each shear modulus, shape (T,); None for zero."""
        parts = [term.shear_modulus_gradient(positions, adjoint) for term in self._acting]
        there = [part for part in parts if part is not None]
        return np.sum(there, axis=0) if there else None

    def _term(self, potential: Potential) -> AddedTerm:
        """Return the term of a potential's kind, prepared once."""
        if potential.kind not in self._terms:
            body = self._stiffness.body
            term = potential.term(body.discretisation, self._stiffness.pattern, body.device)
            term.set_rest_shape(self._shape)
            self._terms[potential.kind] = term
        return self._terms[potential.kind]

    def _pulling_cables(self, conditions: Conditions) -> list[CableTerm]:
        """Take the cables' states; return those that have any stiffness."""
        states = conditions.cables or [CableState(c.route_length, 0.0) for c in self.cables]
        if len(states) != len(self.cables):
            raise ValueError(
                f'{len(states)} cables are given for a body with {len(self.cables)}: give one '
                'state for each, or none'
            )
        for cable, state in zip(self.cables, states, strict=True):
            cable.state = state
        return [cable for cable in self.cables if cable.state.stiffness != 0.0]

    def _bend(self, rates: FloatArray) -> None:
        body = self._stiffness.body
        shape = self._shape_of(rates)
        body.set_rest_shape(shape)
        self._shape = shape
        for term in self._terms.values():
            term.set_rest_shape(shape)
        self._rates = rates.copy()

    def _shape_of(self, rates: FloatArray) -> Discretisation:
        """Return the elements at rest; a march asks for the same few in each of its steps."""
        key = rates.tobytes()
        if key not in self._shapes:
            if len(self._shapes) >= _MOST_SHAPES:
                del self._shapes[next(iter(self._shapes))]
            body = self._stiffness.body
            self._shapes[key] = bent_discretisation(
                self._mesh, body.discretisation, self.axes, rates
            )
        return self._shapes[key]

    def _force_of_bends(self, positions: FloatArray, direction: FloatArray) -> FloatArray:
        here, step = self._rates, _BEND_STEP / self.axes.length
        before = self._stiffness.forces(positions)
        self._bend(here + step * direction)
        after = self._stiffness.forces(positions)
        self._bend(here)
        return (after - before) / step
