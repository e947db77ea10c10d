# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The blind generator's law, put together as its bodies do."""

import numpy as np

from benchmarks.blind.material import (
    cofactors,
    Constants,
    respond,
    squares_stiffness,
    squares_stress,
)


def stress_of(F: np.ndarray, numbers: Constants) -> np.ndarray:
    """Return the first Piola-Kirchhoff stress [Pa], shape (..., 3, 3)."""
    law = respond(F, numbers)
    along, pressure = (np.asarray(own)[..., None, None] for own in (law.along, law.pressure))
    stress = along * F + pressure * law.cofactor + squares_stress(F, law.squares)
    return stress if numbers.fibres is None else stress + numbers.fibres.stress(F)


def stress_change(
    F: np.ndarray, numbers: Constants, direction: np.ndarray, step: float
) -> np.ndarray:
    """Return how the stress without fibres follows F along a direction [Pa], shape (3, 3).

    Args:
        F: shape (3, 3).
        numbers: of the law.
        direction: of the change, shape (3, 3).
        step: to either side, by which the change of the cofactors is found.
    """
    law = respond(F, numbers)
    ends = (cofactors(F + sign * step * direction) for sign in (1.0, -1.0))
    return np.asarray(
        law.along * direction
        + law.stretch * np.sum(F * direction) * F
        + law.bulk * np.sum(law.cofactor * direction) * law.cofactor
        + law.pressure * np.subtract(*ends) / (2.0 * step)
        + np.einsum('iIjJ,jJ->iI', squares_stiffness(F, law.squares), direction)
    )
