# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Potentials that join a body's elastic energy in the equilibrium."""

from collections.abc import Hashable
from dataclasses import dataclass
from importlib import import_module
from types import ModuleType
from typing import Any, Protocol

from diffcal_ros.fem.elements.element import Discretisation
from diffcal_ros.fem.elements.sparse_pattern import SparsePattern
from diffcal_ros.material import LameParameters
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


class PotentialTerm(Protocol):
    """A potential of the node positions."""

    def energy(self, positions: FloatArray) -> float:
        """Return the energy [J]."""

    def forces(self, positions: FloatArray) -> FloatArray:
        """Return its gradient [N], shape (N, 3)."""

    def force_tangent(self, positions: FloatArray, direction: FloatArray) -> FloatArray:
        """Return its Hessian times a direction [N], shape (N, 3)."""

    def stiffness(self, positions: FloatArray, *, is_guarded: bool) -> FloatArray:
        """Return its Hessian's entries in the pattern, shape (nnz,)."""


class AddedTerm(PotentialTerm, Protocol):
    """The term of a potential that an effect adds; it follows nothing else by default."""

    def take(self, potential: Any, shear_moduli: FloatArray) -> None:
        """Take the numbers of a potential of this kind, and each tetrahedron's mu [Pa], (T,)."""

    def force_along(
        self, positions: FloatArray, direction: Any, shear_moduli: FloatArray
    ) -> FloatArray:
        """Return how the forces follow the numbers of its potential [N], shape (N, 3).

        Args:
            positions: of the nodes [m], shape (N, 3).
            direction: a potential of this kind: what its numbers change by.
            shear_moduli: of the tetrahedra [Pa], shape (T,).
        """

    def set_rest_shape(self, discretisation: Discretisation) -> None:
        """Follow a change of the shape without stress."""
        return None

    def force_of_shear_moduli(self, positions: FloatArray, change: FloatArray) -> FloatArray:
        """Return how the forces follow the shear moduli [N], shape (N, 3)."""
        return np.zeros_like(positions)

    def shear_modulus_gradient(
        self, positions: FloatArray, adjoint: FloatArray
    ) -> FloatArray | None:
        """Return adjoint . d forces by each shear modulus, shape (T,); None for zero."""
        return None


class Potential(Protocol):
    """A potential that an effect adds to the body's energy, as data."""

    @property
    def kind(self) -> Hashable:
        """What it shares its term with, whose numbers alone differ; one of a kind acts."""

    def seen_from(self, origin: FloatArray) -> 'Potential':
        """Return the same where positions are counted from a point in the world [m], (3,)."""
        return self

    def term(
        self, discretisation: Discretisation, pattern: SparsePattern, device: str
    ) -> AddedTerm:
        """Prepare the term on a body, still without numbers."""


@dataclass(frozen=True)
class ShearRatio(Potential):
    """An energy of the whole body in proportion to its shear moduli.

    Attributes:
        ratio: to the shear modulus.
        law: an energy law that is linear in its first number and knows no other.
    """

    ratio: float
    law: ModuleType

    @property
    def kind(self) -> Hashable:
        """One a law."""
        return self.law

    def term(
        self, discretisation: Discretisation, pattern: SparsePattern, device: str
    ) -> AddedTerm:
        """Prepare the term."""
        return ShearRatioTerm(discretisation, pattern, device, self.law)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the law by its name: a module does not go to another process."""
        return _by_name, (self.ratio, self.law.__name__)


def _by_name(ratio: float, law: str) -> ShearRatio:
    return ShearRatio(ratio, import_module(law))


class ShearRatioTerm(AddedTerm):
    """The term of `ShearRatio`."""

    def __init__(
        self,
        discretisation: Discretisation,
        pattern: SparsePattern,
        device: str,
        law: ModuleType,
    ) -> None:
        # Warp is not needed to know what acts.
        from diffcal_ros.fem.elements.elastic_body import ElasticBody

        self._body = ElasticBody(discretisation, law=law, device=device)
        self._stiffness = self._body.make_stiffness(pattern)
        self._ratio = 0.0

    def take(self, potential: Any, shear_moduli: FloatArray) -> None:
        """Take the ratio, and the shear modulus of each tetrahedron [Pa], shape (T,)."""
        self._ratio = potential.ratio
        mu = self._ratio * shear_moduli
        self._body.set_lame_parameters(LameParameters(mu, np.zeros_like(mu)))

    def set_rest_shape(self, discretisation: Discretisation) -> None:
        """Follow a change of the shape without stress."""
        self._body.set_rest_shape(discretisation)

    def force_along(
        self, positions: FloatArray, direction: Any, shear_moduli: FloatArray
    ) -> FloatArray:
        """Return how the forces follow the ratio [N], shape (N, 3)."""
        unit = LameParameters(shear_moduli, np.zeros_like(shear_moduli))
        force: FloatArray = direction.ratio * self._body.force_of_lame_parameters(positions, unit)
        return force

    def force_of_shear_moduli(self, positions: FloatArray, change: FloatArray) -> FloatArray:
        """Return how the forces follow the shear moduli [N], shape (N, 3)."""
        lame_parameters = LameParameters(change, np.zeros_like(change))
        return self._ratio * self._body.force_of_lame_parameters(positions, lame_parameters)

    def shear_modulus_gradient(self, positions: FloatArray, adjoint: FloatArray) -> FloatArray:
        """Return adjoint . d forces by each shear modulus, shape (T,)."""
        return self._ratio * self._body.number_gradient(positions, adjoint).neo_hookean_mu

    def energy(self, positions: FloatArray) -> float:
        """Return the energy [J]."""
        return self._body.energy(positions)

    def forces(self, positions: FloatArray) -> FloatArray:
        """Return its gradient [N], shape (N, 3)."""
        return self._body.forces(positions)

    def force_tangent(self, positions: FloatArray, direction: FloatArray) -> FloatArray:
        """Return its Hessian times a direction [N], shape (N, 3)."""
        return self._body.force_tangent(positions, direction)

    def stiffness(self, positions: FloatArray, *, is_guarded: bool) -> FloatArray:
        """Return its Hessian's entries in the pattern, shape (nnz,)."""
        return self._stiffness.values(positions, is_guarded=is_guarded)


def surface_areas(discretisation: Discretisation) -> FloatArray:
    """Return each node's share of the surface at rest [m^2], shape (N,)."""
    triangles = discretisation.surface_triangles
    corners = discretisation.rest_nodes[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(normals, axis=1) / 6.0
    fractions = np.zeros(discretisation.node_count)
    np.add.at(fractions, triangles.ravel(), np.repeat(areas, 3))
    return fractions
