# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effects put to work on one body: its terms, its shape without stress, and how forces follow."""

from collections.abc import Sequence
from dataclasses import dataclass

from diffcal_ros.fem.body_axes import BodyAxes
from diffcal_ros.fem.cable import CableTerm
from diffcal_ros.fem.conditions import CableState, Conditions, NO_CONDITIONS
from diffcal_ros.fem.equilibrium import EquilibriumSolver
from diffcal_ros.fem.potential_terms import ContactTerm, FibreTerm, PotentialTerm, StiffeningTerm
from diffcal_ros.fem.rest_shape import bent_discretisation
from diffcal_ros.material import NeoHookeanNumbers
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Step of a finite difference by curvature, as a bend of the whole body [rad].
_BEND_STEP = 1e-4


@dataclass(frozen=True)
class ConditionsChange:
    """A direction in the space of effects.

    Attributes:
        clamp_motion: per unit of the parameter, shape (6,).
        clamp_compliance: [rad/(N m)].
        added_masses: [kg], shape (N,).
        forces: on the nodes [N], world frame, shape (N, 3).
        rest_curvature: [1/m], shape (2,).
        strain_stiffening: change of C2 / C1.
        fibre_ratio: of fibres' stiffness to the shear modulus.
        fibre_direction: where they run; must be that of the conditions where these have any,
            shape (3,).
        plane_height: [m].
        plane_normal: change of the plane's normal, shape (3,).
        cable_rest_lengths: [m], shape (c,), one a cable of the body.
        cable_stiffnesses: [N/m], shape (c,).
        air_drag: [m^2].
    """

    clamp_motion: FloatArray | None = None
    clamp_compliance: float = 0.0
    added_masses: FloatArray | None = None
    forces: FloatArray | None = None
    rest_curvature: FloatArray | None = None
    strain_stiffening: float = 0.0
    fibre_ratio: float = 0.0
    fibre_direction: FloatArray | None = None
    plane_height: float = 0.0
    plane_normal: FloatArray | None = None
    cable_rest_lengths: FloatArray | None = None
    cable_stiffnesses: FloatArray | None = None
    air_drag: float = 0.0


class AppliedConditions:
    """Keeps a body's equilibrium solver up to date with the effects on it.

    Attributes:
        now: the effects.
        count: how often they were applied.
        cables: that run through the body.
    """

    def __init__(
        self,
        mesh: TetMesh,
        solver: EquilibriumSolver,
        axes: BodyAxes,
        cables: Sequence[CableTerm],
        origin: FloatArray,
    ) -> None:
        """Prepare a body without effects.

        Args:
            mesh: the body at rest, like all positions here in the body's own frame.
            solver: of its equilibria.
            axes: of the body.
            cables: that run through it.
            origin: of its own frame in the world [m], shape (3,): planes are given there.
        """
        self.now = NO_CONDITIONS
        self.count = 0
        self.cables = tuple(cables)
        self._mesh = mesh
        self._solver = solver
        self._origin = origin
        self._stiffening: StiffeningTerm | None = None
        self._fibres: FibreTerm | None = None
        self._contact: ContactTerm | None = None
        self._shear_moduli = np.zeros(0)
        self._shape = solver.body.discretisation  # Without stress.
        self._axes = axes
        self._curvature = np.zeros(2)

    @property
    def axes(self) -> BodyAxes:
        """The body's axes, about which it bends."""
        return self._axes

    @axes.setter
    def axes(self, axes: BodyAxes) -> None:
        self._axes = axes
        if self._curvature.any():
            self._bend(self._curvature)

    def apply(self, conditions: Conditions, numbers: NeoHookeanNumbers) -> None:
        """Put effects to work; the material is set already."""
        self.now = conditions
        self.count += 1
        self._shear_moduli = numbers.neo_hookean_mu
        terms: list[PotentialTerm] = []
        if conditions.strain_stiffening != 0.0:
            stiffening = self._stiffening_term()
            stiffening.set_numbers(self._shear_moduli, conditions.strain_stiffening)
            terms.append(stiffening)
        if conditions.fibre_ratio != 0.0:
            fibres = self._fibre_term(conditions.fibre_direction)
            fibres.set_numbers(self._shear_moduli, conditions.fibre_ratio)
            terms.append(fibres)
        self._contact = None
        if conditions.plane is not None:
            body = self._solver.body
            self._contact = ContactTerm(
                body.discretisation, self._solver.pattern, conditions.plane, self._origin
            )
            terms.append(self._contact)
        terms += self._pulling_cables(conditions)
        self._solver.terms = tuple(terms)
        if not np.array_equal(conditions.rest_curvature, self._curvature):
            self._bend(conditions.rest_curvature)

    def force_change(
        self, positions: FloatArray, change: ConditionsChange, gravity: FloatArray
    ) -> FloatArray:
        """Return how the force on each node changes [N], shape (N, 3); the clamp stays."""
        force = np.zeros_like(positions)
        if change.added_masses is not None:
            force += change.added_masses[:, None] * gravity
        if change.forces is not None:
            force += change.forces
        if change.strain_stiffening != 0.0:
            term = self._stiffening_term()
            force -= change.strain_stiffening * term.force_of_ratio(positions, self._shear_moduli)
        if change.fibre_ratio != 0.0:
            direction = change.fibre_direction
            fibres = self._fibre_term(self.now.fibre_direction if direction is None else direction)
            force -= change.fibre_ratio * fibres.force_of_ratio(positions, self._shear_moduli)
        if change.plane_height != 0.0 and self._contact is not None:
            force -= change.plane_height * self._contact.force_of_height(positions)
        if change.plane_normal is not None and self._contact is not None:
            force -= self._contact.force_of_normal(positions, change.plane_normal)
        if change.rest_curvature is not None:
            force -= self._force_of_curvature(positions, change.rest_curvature)
        if change.cable_rest_lengths is not None:
            for cable, rate in zip(self.cables, change.cable_rest_lengths, strict=True):
                force -= rate * cable.force_of_rest_length(positions)
        if change.cable_stiffnesses is not None:
            for cable, rate in zip(self.cables, change.cable_stiffnesses, strict=True):
                force -= rate * cable.force_of_stiffness(positions)
        return force

    def force_of_shear_moduli(self, positions: FloatArray, change: FloatArray) -> FloatArray:
        """Return how the terms' forces follow the shear moduli [N], shape (N, 3)."""
        forces = np.zeros_like(positions)
        for ratio, term in self._ratios():
            forces += ratio * term.force_of_ratio(positions, change)
        return forces

    def shear_modulus_gradient(
        self, positions: FloatArray, adjoint: FloatArray
    ) -> FloatArray | None:
        """Return adjoint . d terms' forces by each shear modulus, shape (T,); None for zero."""
        parts = [
            ratio * term.shear_modulus_gradient(positions, adjoint)
            for ratio, term in self._ratios()
        ]
        return sum(parts[1:], parts[0]) if parts else None

    def _ratios(self) -> list[tuple[float, StiffeningTerm]]:
        """Return the terms that follow the shear moduli, with their ratios."""
        found: list[tuple[float, StiffeningTerm]] = []
        if self.now.strain_stiffening != 0.0:
            found.append((self.now.strain_stiffening, self._stiffening_term()))
        if self.now.fibre_ratio != 0.0:
            found.append((self.now.fibre_ratio, self._fibre_term(self.now.fibre_direction)))
        return found

    def _fibre_term(self, direction: FloatArray) -> FibreTerm:
        body = self._solver.body
        if self._fibres is None or not np.array_equal(self._fibres.direction, direction):
            self._fibres = FibreTerm(self._shape, self._solver.pattern, body.device, direction)
        return self._fibres

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

    def _stiffening_term(self) -> StiffeningTerm:
        if self._stiffening is None:
            body = self._solver.body
            self._stiffening = StiffeningTerm(self._shape, self._solver.pattern, body.device)
        return self._stiffening

    def _bend(self, curvature: FloatArray) -> None:
        body = self._solver.body
        shape = bent_discretisation(self._mesh, body.discretisation, self._axes, curvature)
        body.set_rest_shape(shape)
        self._shape = shape
        for term in (self._stiffening, self._fibres):
            if term is not None:
                term.set_rest_shape(shape)
        self._curvature = curvature.copy()

    def _force_of_curvature(self, positions: FloatArray, direction: FloatArray) -> FloatArray:
        here, step = self._curvature, _BEND_STEP / self._axes.length
        forces = []
        for sign in (1.0, -1.0):
            self._bend(here + sign * step * direction)
            forces.append(self._solver.forces(positions))
        self._bend(here)
        return (forces[0] - forces[1]) / (2.0 * step)
