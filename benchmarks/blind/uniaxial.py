# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How stiff a rubber is along a body when its sides are free, whatever its law."""

import numpy as np

from benchmarks.blind.material import Constants, respond, squares_stress
from benchmarks.blind.rubber import Rubber
from benchmarks.blind.shapes import FloatArray

_STEP = 1e-5  # Strain either way, of which a stiffness is the difference.
# Entries of a symmetric strain, that along the object's x first.
_ENTRIES = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))


def modulus_along(rubber: Rubber, youngs_modulus: float, poissons_ratio: float) -> float:
    """Return Young's modulus of small strains along the object's x [Pa], to eight digits.

    It is the slope of the stress along a bar whose other stresses are none: all other strains come
    as they will, those of shear as well, which oblique fibres bring about.

    Args:
        rubber: what the bar is of.
        youngs_modulus: of small strains, without fibres [Pa].
        poissons_ratio: as the scene states it.
    """
    numbers = rubber.numbers(np.array([youngs_modulus]), poissons_ratio)
    compliance = np.linalg.inv(_stiffness(numbers))
    return float(f'{1.0 / compliance[0, 0]:.8g}')


def _stiffness(numbers: Constants) -> FloatArray:
    """Return stresses by strains where nothing is strained yet [Pa], shape (6, 6)."""
    columns = []
    for row, column in _ENTRIES:
        strain = np.zeros((3, 3))
        strain[row, column] = strain[column, row] = _STEP
        change = (_stress(strain, numbers) - _stress(-strain, numbers)) / (2.0 * _STEP)
        columns.append([change[entry] for entry in _ENTRIES])
    return np.array(columns).T


def _stress(strain: FloatArray, numbers: Constants) -> FloatArray:
    """Return the stress of a strain without a turn [Pa], shape (3, 3)."""
    F = np.eye(3)[None] + strain
    law = respond(F, numbers)
    stress = law.along[..., None, None] * F + law.pressure[..., None, None] * law.cofactor
    stress = stress + squares_stress(F, law.squares)
    for family in numbers.families:
        stress = stress + family.stress(F)
    return np.asarray(stress[0])
