# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Elastic constants: Young's modulus and Poisson's ratio in, the energy's constants out."""

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class LameConversion:
    """How the two constants of an energy law follow from Lame's parameters.

    The first is `mu` times Lame's mu, the second is Lame's lambda and `added` times mu, such that
    a small stretch of the law measures E and nu.
    """

    mu: float
    added: float


PLAIN_CONVERSION = LameConversion(1.0, 0.0)
# Smith et al. 2018, section 3.4.
NEO_HOOKEAN_CONVERSION = LameConversion(4.0 / 3.0, 5.0 / 6.0)


class LameConvention(str, Enum):
    """How Young's modulus enters the stable neo-Hookean energy.

    The energy of Smith et al. 2018 (equation 13; Arnavaz et al. 2023, equation 12) has a shear
    stiffness of 3/4 of its mu at rest. With `CONSISTENT` its constants are re-scaled (Smith et
    al., section 3.4) so that a small stretch measures E and nu. With `PAPER` the plain Lame
    parameters are put in, as the authors' simulator does: such a solid is 25 % softer in shear.
    """

    CONSISTENT = 'consistent'
    PAPER = 'paper'


def lame_mu(youngs_modulus: FloatArray, poissons_ratio: FloatArray) -> FloatArray:
    """Return the shear modulus [Pa]."""
    return youngs_modulus / (2.0 * (1.0 + poissons_ratio))


def lame_lambda(youngs_modulus: FloatArray, poissons_ratio: FloatArray) -> FloatArray:
    """Return Lame's other parameter [Pa], which grows without bound towards nu = 0.5."""
    return (
        youngs_modulus * poissons_ratio / ((1.0 + poissons_ratio) * (1.0 - 2.0 * poissons_ratio))
    )


@dataclass(frozen=True)
class LameParameters:
    """Constants of the stable neo-Hookean energy, or of another law, one per tetrahedron.

    Attributes:
        neo_hookean_mu: [Pa], shape (T,).
        neo_hookean_lambda: [Pa], shape (T,).
    """

    neo_hookean_mu: FloatArray
    neo_hookean_lambda: FloatArray


@dataclass(frozen=True)
class Material:
    """Elastic constants and density, one per tetrahedron.

    Attributes:
        youngs_modulus: [Pa], shape (T,).
        poissons_ratio: shape (T,).
        density: [kg/m^3], shape (T,).
        convention: how E and nu enter the energy.
        conversion: of the energy law that the body has.
    """

    youngs_modulus: FloatArray
    poissons_ratio: FloatArray
    density: FloatArray
    convention: LameConvention = LameConvention.CONSISTENT
    conversion: LameConversion = NEO_HOOKEAN_CONVERSION

    def __post_init__(self) -> None:
        if not (np.isfinite(self.youngs_modulus).all() and (self.youngs_modulus > 0).all()):
            raise ValueError("Young's modulus must be positive and finite in every tetrahedron")
        inside = (self.poissons_ratio > -1.0) & (self.poissons_ratio < 0.5)
        if not inside.all():
            given = self.poissons_ratio[~inside][0]
            raise ValueError(
                f"Poisson's ratio is {given:g}: it must lie above -1 and below 0.5; "
                'use 0.49 for silicone'
            )
        if not (np.isfinite(self.density).all() and (self.density > 0).all()):
            raise ValueError('density must be positive and finite in every tetrahedron')

    def lame_parameters(self) -> LameParameters:
        """Return the energy's constants."""
        mu = lame_mu(self.youngs_modulus, self.poissons_ratio)
        lam = lame_lambda(self.youngs_modulus, self.poissons_ratio)
        return self._shared(mu, lam)

    def lame_parameters_by_youngs_modulus(self) -> LameParameters:
        """Return the derivative of the constants by each tetrahedron's own E [-], shape (T,)."""
        lame_parameters = self.lame_parameters()
        return LameParameters(
            lame_parameters.neo_hookean_mu / self.youngs_modulus,
            lame_parameters.neo_hookean_lambda / self.youngs_modulus,
        )

    def lame_parameters_by_poissons_ratio(self) -> LameParameters:
        """Return the derivative of the constants by each tetrahedron's own nu [Pa], shape (T,)."""
        modulus, nu = self.youngs_modulus, self.poissons_ratio
        mu = -modulus / (2.0 * (1.0 + nu) ** 2)
        lam = modulus * (1.0 + 2.0 * nu**2) / ((1.0 + nu) * (1.0 - 2.0 * nu)) ** 2
        return self._shared(mu, lam)

    def require_conversion(self, conversion: LameConversion) -> None:
        """Refuse a material that was made for another law than a body has.

        Raises:
            ValueError: when it was.
        """
        if self.conversion != conversion:
            raise ValueError(
                f"the material's constants are made for a law with {self.conversion}, the body's "
                f'law has {conversion}: give the material the CONVERSION of its law'
            )

    def _shared(self, mu: FloatArray, lam: FloatArray) -> LameParameters:
        plain = self.convention is LameConvention.PAPER
        conversion = PLAIN_CONVERSION if plain else self.conversion
        return LameParameters(conversion.mu * mu, lam + conversion.added * mu)
