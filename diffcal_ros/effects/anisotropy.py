# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The material is stiffer along one direction: fibres beside the elastic energy.

No diagnosis looks for it: one load of one body cannot tell it from another modulus.
"""

from collections.abc import Hashable
from dataclasses import dataclass, replace

from diffcal_ros.effects.effect import Component, Effect, FloatArray, Numbers
from diffcal_ros.effects.site import Site
from diffcal_ros.fem.elements.element import Discretisation
from diffcal_ros.fem.elements.sparse_pattern import SparsePattern
from diffcal_ros.fem.terms.conditions import Conditions
from diffcal_ros.fem.terms.potential_terms import Potential, ShearRatioTerm
import numpy as np


class Anisotropy(Effect):
    """Stiffness that fibres add, over the shear modulus."""

    identifier = 'anisotropy'
    group = 'material'
    components = (Component('ratio', '1', 0.0, 100.0, 3.0, 'added stiffness / G', 1.0),)
    sentence = 'the material is stiffer along one direction'
    settles = ('a twist besides the bend', 'loads along and across that direction')
    twins = ('stiffness_contrast',)
    # Of the object frame; all zero: along the body.
    settings = {'x': 0.0, 'y': 0.0, 'z': 0.0}  # noqa: RUF012
    setting_limits = (-1.0, 1.0)
    variants = ()

    def conditions(self, own: Numbers, site: Site) -> Conditions:
        """Return the fibres."""
        return Conditions(potentials=(Fibres(own['ratio'], _direction(own, site)),))


def _direction(own: Numbers, site: Site) -> FloatArray:
    """Return where fibres run at rest in the world frame; along the body by default."""
    given = np.array([own.get(name, 0.0) for name in 'xyz'])
    if not given.any():
        return site.axes.axes[0]
    return site.to_world(given / np.linalg.norm(given))


@dataclass(frozen=True)
class Fibres(Potential):
    """Fibres along one direction of the body at rest.

    Attributes:
        ratio: of their stiffness to the shear modulus.
        direction: world frame, shape (3,).
    """

    ratio: float
    direction: FloatArray

    @property
    def kind(self) -> Hashable:
        """One a direction."""
        return 'fibres', *self.direction.tolist()

    def term(
        self, discretisation: Discretisation, pattern: SparsePattern, device: str
    ) -> 'FibreTerm':
        """Prepare the term."""
        return FibreTerm(discretisation, pattern, device, self.direction)


class FibreTerm(ShearRatioTerm):
    """The term of `Fibres`."""

    def __init__(
        self,
        discretisation: Discretisation,
        pattern: SparsePattern,
        device: str,
        direction: FloatArray,
    ) -> None:
        # Its kernels, and Warp with them, are not needed to read a scene.
        from diffcal_ros.fem.terms import fibre_stiffening

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
