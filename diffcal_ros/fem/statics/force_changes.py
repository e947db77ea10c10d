# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How the forces on a body at given positions follow its material, its weight and effects."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import ClassVar, TYPE_CHECKING

from diffcal_ros.fem.elements.element import Discretisation
from diffcal_ros.fem.terms.conditions import Conditions
from diffcal_ros.material import LameParameters, Material
import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:  # Warp is not needed to say what changes.
    from diffcal_ros.fem.elements.elastic_body import ElasticBody
    from diffcal_ros.fem.statics.applied_conditions import AppliedConditions

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Change:
    """A direction in the space of parameters; parts left out do not change.

    Attributes:
        youngs_modulus: [Pa] per unit of the parameter, shape (T,).
        poissons_ratio: shape (T,).
        density: [kg/m^3], shape (T,).
        gravity: [m/s^2], shape (3,).
        conditions: of effects.
        beyond_gradient: what a kind of change has that no `StaticGradient` knows of; empty for
            nothing.
    """

    beyond_gradient: ClassVar[str] = ''
    youngs_modulus: FloatArray | None = None
    poissons_ratio: FloatArray | None = None
    density: FloatArray | None = None
    gravity: FloatArray | None = None
    conditions: Conditions | None = None


@dataclass(frozen=True)
class StaticGradient:
    """Derivative of a scalar by every input of the equilibrium.

    Attributes:
        youngs_modulus: by each tetrahedron's own E [1/Pa], shape (T,).
        poissons_ratio: shape (T,).
        density: [m^3/kg], shape (T,).
        gravity: [s^2/m], shape (3,).
        by_effects: returns the derivative along a change of effects, which are too many to have
            one number each; None: not known.
    """

    youngs_modulus: FloatArray
    poissons_ratio: FloatArray
    density: FloatArray
    gravity: FloatArray
    by_effects: Callable[[Conditions], float] | None = field(default=None, kw_only=True)

    def along(self, change: Change) -> float:
        """Return the derivative along a change of the inputs.

        Raises:
            NotImplementedError: for a change of which this gradient knows only a part.
        """
        if change.beyond_gradient:
            raise NotImplementedError(_beyond(change.beyond_gradient))
        pairs = (
            (self.youngs_modulus, change.youngs_modulus),
            (self.poissons_ratio, change.poissons_ratio),
            (self.density, change.density),
            (self.gravity, change.gravity),
        )
        total = sum(float(mine @ theirs) for mine, theirs in pairs if theirs is not None)
        if change.conditions is None:
            return total
        if self.by_effects is None:
            raise NotImplementedError(_beyond('effects'))
        return total + self.by_effects(change.conditions)


def _beyond(what: str) -> str:
    return f'this gradient does not know {what}: use `tangents`, which follow every change'


def gravity_loads(
    discretisation: Discretisation, density: FloatArray, gravity: FloatArray
) -> FloatArray:
    """Return nodal weights [N], shape (N, 3), of a density per tetrahedron [kg/m^3]."""
    fractions = discretisation.load_fractions * density[:, None]
    masses = np.bincount(
        discretisation.nodes.ravel(),
        weights=fractions.ravel(),
        minlength=discretisation.node_count,
    )
    return masses[:, None] * gravity


class ForceChanges:
    """Derivatives of loads less internal forces at fixed positions."""

    def __init__(self, elastic: 'ElasticBody', conditions: 'AppliedConditions') -> None:
        self._elastic = elastic
        self._conditions = conditions

    def along(
        self, positions: FloatArray, change: Change, material: Material, gravity: FloatArray
    ) -> FloatArray:
        """Return the change of the force on each node [N], shape (N, 3)."""
        force = np.zeros_like(positions)
        if change.youngs_modulus is not None:
            lame_parameters = _scaled(
                material.lame_parameters_by_youngs_modulus(), change.youngs_modulus
            )
            force -= self._elastic.force_of_lame_parameters(positions, lame_parameters)
            force -= self._conditions.force_of_shear_moduli(
                positions, lame_parameters.neo_hookean_mu
            )
        if change.poissons_ratio is not None:
            lame_parameters = _scaled(
                material.lame_parameters_by_poissons_ratio(), change.poissons_ratio
            )
            force -= self._elastic.force_of_lame_parameters(positions, lame_parameters)
            force -= self._conditions.force_of_shear_moduli(
                positions, lame_parameters.neo_hookean_mu
            )
        if change.density is not None:
            force += gravity_loads(self._elastic.discretisation, change.density, gravity)
        if change.gravity is not None:
            force += gravity_loads(self._elastic.discretisation, material.density, change.gravity)
            added = self._conditions.now.added_masses
            if added is not None:
                force += added[:, None] * change.gravity
        if change.conditions is not None:
            force += self._conditions.force_change(positions, change.conditions, gravity)
        return force

    def pull_back(
        self,
        positions: FloatArray,
        adjoint: FloatArray,
        material: Material,
        gravity: FloatArray,
    ) -> StaticGradient:
        """Return adjoint . d (loads less forces) by every input but effects.

        Args:
            positions: node positions [m], shape (N, 3).
            adjoint: weight of each node's force, shape (N, 3).
            material: one value per tetrahedron.
            gravity: [m/s^2], shape (3,).
        """
        return self.collect(
            self.by_lame_parameters(positions, adjoint), adjoint, material, gravity
        )

    def by_lame_parameters(self, positions: FloatArray, adjoint: FloatArray) -> LameParameters:
        """Return adjoint . d internal forces by the energy's constants, shape (T,) each."""
        elastic = self._elastic.number_gradient(positions, adjoint)
        stiffening = self.stiffening_by_mu(positions, adjoint)
        if stiffening is None:
            return elastic
        return LameParameters(elastic.neo_hookean_mu + stiffening, elastic.neo_hookean_lambda)

    def stiffening_by_mu(self, positions: FloatArray, adjoint: FloatArray) -> FloatArray | None:
        """Return the part of strain stiffening in that by mu, shape (T,); None for none."""
        return self._conditions.shear_modulus_gradient(positions, adjoint)

    def collect(
        self,
        by_lame_parameters: LameParameters,
        adjoint: FloatArray,
        material: Material,
        gravity: FloatArray,
    ) -> StaticGradient:
        """Return the gradient of `pull_back` from sums of `by_lame_parameters` and of adjoints."""
        discretisation = self._elastic.discretisation
        nodes, fractions = discretisation.nodes, discretisation.load_fractions
        # Work of a unit acceleration on each tetrahedron's mass, along the adjoint.
        volume_adjoint = np.einsum('ta,tai->ti', fractions, adjoint[nodes])
        by_gravity = material.density @ volume_adjoint
        if self._conditions.now.added_masses is not None:
            by_gravity = by_gravity + self._conditions.now.added_masses @ adjoint
        return StaticGradient(
            youngs_modulus=-_chain(
                by_lame_parameters, material.lame_parameters_by_youngs_modulus()
            ),
            poissons_ratio=-_chain(
                by_lame_parameters, material.lame_parameters_by_poissons_ratio()
            ),
            density=volume_adjoint @ gravity,
            gravity=by_gravity,
        )


def _scaled(lame_parameters: LameParameters, factor: FloatArray) -> LameParameters:
    return LameParameters(
        lame_parameters.neo_hookean_mu * factor, lame_parameters.neo_hookean_lambda * factor
    )


def _chain(by_lame_parameters: LameParameters, lame_parameters_by: LameParameters) -> FloatArray:
    return (
        by_lame_parameters.neo_hookean_mu * lame_parameters_by.neo_hookean_mu
        + by_lame_parameters.neo_hookean_lambda * lame_parameters_by.neo_hookean_lambda
    )
