# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Potentials that join a body's elastic energy in the equilibrium."""

from dataclasses import replace
from types import ModuleType
from typing import Protocol

from diffcal_ros.fem import fibre_stiffening, strain_stiffening
from diffcal_ros.fem.conditions import Plane
from diffcal_ros.fem.elastic_body import ElasticBody
from diffcal_ros.fem.element import Discretisation
from diffcal_ros.fem.sparse_pattern import SparsePattern
from diffcal_ros.material import NeoHookeanNumbers
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Pressure of an obstacle on what is in it by so much [Pa/m]: a soft body's weight presses it in
# by hundredths of a millimetre.
_OBSTACLE = 2e8


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


class StiffeningTerm:
    """An energy of the whole body that is a ratio of its shear moduli: strain stiffening."""

    def __init__(
        self,
        discretisation: Discretisation,
        pattern: SparsePattern,
        device: str,
        law: ModuleType = strain_stiffening,
    ) -> None:
        """Prepare the term; `law` is linear in its first number and knows no other."""
        self._body = ElasticBody(discretisation, law=law, device=device)
        self._stiffness = self._body.make_stiffness(pattern)

    def set_numbers(self, shear_moduli: FloatArray, ratio: float) -> None:
        """Set the shear modulus of each tetrahedron [Pa] and the ratio, C2 / C1."""
        mu = ratio * shear_moduli
        self._body.set_numbers(NeoHookeanNumbers(mu, np.zeros_like(mu)))

    def set_rest_shape(self, discretisation: Discretisation) -> None:
        """Follow a change of the shape without stress."""
        self._body.set_rest_shape(discretisation)

    def force_of_ratio(self, positions: FloatArray, shear_moduli: FloatArray) -> FloatArray:
        """Return the derivative of the forces by the ratio [N], shape (N, 3)."""
        unit = NeoHookeanNumbers(shear_moduli, np.zeros_like(shear_moduli))
        return self._body.force_of_numbers(positions, unit)

    def shear_modulus_gradient(self, positions: FloatArray, adjoint: FloatArray) -> FloatArray:
        """Return adjoint . d forces by each tetrahedron's ratio times shear modulus, (T,)."""
        return self._body.number_gradient(positions, adjoint).neo_hookean_mu

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


class FibreTerm(StiffeningTerm):
    """Fibres along one direction of the body at rest; the ratio is theirs to the shear modulus.

    Attributes:
        direction: of the fibres at rest, shape (3,).
    """

    def __init__(
        self,
        discretisation: Discretisation,
        pattern: SparsePattern,
        device: str,
        direction: FloatArray,
    ) -> None:
        """Prepare the term."""
        self.direction = direction
        self._from_fibre = _frame_along(direction)
        super().__init__(self._turned(discretisation), pattern, device, fibre_stiffening)

    def set_rest_shape(self, discretisation: Discretisation) -> None:
        """Follow a change of the shape without stress."""
        super().set_rest_shape(self._turned(discretisation))

    def _turned(self, discretisation: Discretisation) -> Discretisation:
        """Return the elements with gradients in the frame whose first axis is the fibre's."""
        return replace(discretisation, gradients=discretisation.gradients @ self._from_fibre)


def _frame_along(direction: FloatArray) -> FloatArray:
    """Return a right-handed frame whose first column is a direction, shape (3, 3)."""
    first = direction / np.linalg.norm(direction)
    across = np.cross(first, np.eye(3)[int(np.abs(first).argmin())])
    across /= np.linalg.norm(across)
    return np.stack([first, across, np.cross(first, across)], axis=1)


class ContactTerm:
    """A plane that pushes back in proportion to how deep the surface is in it."""

    def __init__(
        self,
        discretisation: Discretisation,
        pattern: SparsePattern,
        plane: Plane,
        origin: FloatArray,
    ) -> None:
        """Prepare one plane.

        Args:
            discretisation: whose surface may touch.
            pattern: of the stiffness.
            plane: the obstacle, world frame.
            origin: where positions are counted from in the world [m], shape (3,).
        """
        self.plane = plane
        self._origin = origin
        self._height = plane.height - float(origin @ plane.normal)
        self._weights = _OBSTACLE * surface_areas(discretisation)
        self._pattern = pattern

    def energy(self, positions: FloatArray) -> float:
        """Return the energy [J]."""
        depth = self._depth(positions)
        return 0.5 * float(self._weights @ depth**2)

    def forces(self, positions: FloatArray) -> FloatArray:
        """Return its gradient [N], shape (N, 3)."""
        return -np.outer(self._weights * self._depth(positions), self.plane.normal)

    def force_tangent(self, positions: FloatArray, direction: FloatArray) -> FloatArray:
        """Return its Hessian times a direction [N], shape (N, 3)."""
        rates = self._rates(positions) * (direction @ self.plane.normal)
        return np.outer(rates, self.plane.normal)

    def force_of_height(self, positions: FloatArray) -> FloatArray:
        """Return the derivative of the forces by the plane's height [N/m], shape (N, 3)."""
        return -np.outer(self._rates(positions), self.plane.normal)

    def force_of_normal(self, positions: FloatArray, change: FloatArray) -> FloatArray:
        """Return the derivative of the forces along a change of the normal [N], shape (N, 3)."""
        deeper = -(positions @ change + self._origin @ change)
        turned = np.outer(self._weights * self._depth(positions), change)
        return -np.outer(self._rates(positions) * deeper, self.plane.normal) - turned

    def stiffness(self, positions: FloatArray, *, is_guarded: bool) -> FloatArray:
        """Return its Hessian's entries in the pattern, shape (nnz,)."""
        pattern, normal = self._pattern, self.plane.normal
        values = np.zeros(pattern.entry_count)
        rates = self._rates(positions)[pattern.free_nodes]
        for column in range(3):
            starts = pattern.column_starts[column:-1:3]
            for row in range(column, 3):
                values[starts + row - column] += rates * normal[row] * normal[column]
        return values

    def _depth(self, positions: FloatArray) -> FloatArray:
        return np.maximum(self._height - positions @ self.plane.normal, 0.0)

    def _rates(self, positions: FloatArray) -> FloatArray:
        return self._weights * (self._depth(positions) > 0.0)


def surface_areas(discretisation: Discretisation) -> FloatArray:
    """Return each node's share of the surface at rest [m^2], shape (N,)."""
    triangles = discretisation.surface_triangles
    corners = discretisation.rest_nodes[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(normals, axis=1) / 6.0
    shares = np.zeros(discretisation.node_count)
    np.add.at(shares, triangles.ravel(), np.repeat(areas, 3))
    return shares
