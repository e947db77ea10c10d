# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Stable neo-Hookean elasticity with a Yeoh term, in numbers that mean E and nu at rest.

    psi = a/2 (I - 3) - a/2 log((I + 1)/4) + b/2 (J - 1)^2 - 3/4 a (J - 1) + c (I - 3)^2

with I = tr F^T F, J = det F (Smith et al. 2018, eq. 13; Arnavaz et al. 2023, eq. 12). For small
strain the shear modulus is 3/4 a and Lame's lambda is b - 5/8 a; `constants` inverts that.
"""

from dataclasses import dataclass

import numpy as np

from benchmarks.blind.shapes import FloatArray


@dataclass(frozen=True)
class Constants:
    """Numbers of the energy; shapes (C, 8) or broadcastable to it.

    Attributes:
        shear: a [Pa].
        bulk: b [Pa].
        yeoh: c [Pa].
    """

    shear: FloatArray
    bulk: FloatArray
    yeoh: FloatArray


def constants(
    youngs_modulus: FloatArray, poissons_ratio: float, yeoh_ratio: float = 0.0
) -> Constants:
    """Return the energy's numbers.

    Args:
        youngs_modulus: [Pa].
        poissons_ratio: dimensionless.
        yeoh_ratio: C2 / C1 [-], where C1 is half the shear modulus at rest.
    """
    mu = youngs_modulus / (2.0 * (1.0 + poissons_ratio))
    lam = 2.0 * mu * poissons_ratio / (1.0 - 2.0 * poissons_ratio)
    shear = mu / 0.75
    return Constants(shear, lam + 0.625 * shear, 0.5 * yeoh_ratio * mu)


@dataclass(frozen=True)
class Response:
    """Energy and its derivatives by F, written with F and its cofactor C.

    stress = along F + pressure C; its derivative along dF is
    along dF + stretch (F:dF) F + bulk (C:dF) C + pressure dC.
    """

    energy: FloatArray
    along: FloatArray
    pressure: FloatArray
    stretch: FloatArray
    bulk: FloatArray
    cofactor: FloatArray


def respond(F: FloatArray, numbers: Constants) -> Response:
    """Evaluate the law at deformation gradients, shape (..., 3, 3)."""
    cofactor = cofactors(F)
    growth = np.einsum('...j,...j->...', F[..., 0, :], cofactor[..., 0, :]) - 1.0
    strain = np.einsum('...ij,...ij->...', F, F) - 3.0
    a, b, c = numbers.shear, numbers.bulk, numbers.yeoh
    energy = (
        0.5 * a * (strain - np.log1p(0.25 * strain))
        + 0.5 * b * growth**2
        - 0.75 * a * growth
        + c * strain**2
    )
    return Response(
        energy=energy,
        along=a * (1.0 - 1.0 / (strain + 4.0)) + 4.0 * c * strain,
        pressure=b * growth - 0.75 * a,
        stretch=2.0 * a / (strain + 4.0) ** 2 + 8.0 * c,
        bulk=np.broadcast_to(b, strain.shape),
        cofactor=cofactor,
    )


def cofactors(F: FloatArray) -> FloatArray:
    """Return dJ/dF, shape (..., 3, 3): each row the cross product of the other two."""
    rows = [np.cross(F[..., (i + 1) % 3, :], F[..., (i + 2) % 3, :]) for i in range(3)]
    return np.stack(rows, axis=-2)
