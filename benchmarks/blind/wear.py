# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Rubber that is softer wherever it was strained before, as filled silicones are (Mullins)."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from benchmarks.blind.body import Body
from benchmarks.blind.material import softened
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.specimen import Specimen

_WORN = 0.006  # Strain at which two thirds of the chains that can be have come off their filler.


def strains(body: Body, positions: FloatArray) -> FloatArray:
    """Return strains in the mean of all directions, shape (C, 8).

    Args:
        body: the elastic body.
        positions: of its nodes [m], shape (N, 3).
    """
    F = np.swapaxes(positions[body.cells], 1, 2)[:, None] @ body.quadrature.gradients
    growth = np.einsum('...ij,...ij->...', F, F) - 3.0
    return np.asarray(np.sqrt(np.maximum(growth, 0.0) / 3.0))


def worn(
    specimen: Specimen, rests: Callable[[Specimen, int], FloatArray], times: int, most: float
) -> Specimen:
    """Return a body after it rested in some poses, in each as those before it left it.

    Args:
        specimen: as it came out of its mould.
        rests: node positions of a body in a pose, by its number [m].
        times: number of poses.
        most: share of its modulus that it can lose.
    """
    found, reached = specimen, np.zeros(specimen.heights.shape)
    for number in range(times):
        reached = np.maximum(reached, strains(specimen.body, rests(found, number)))
        left = 1.0 - most * -np.expm1(-reached / _WORN)
        numbers = softened(specimen.body.numbers, left)
        found = replace(specimen, body=replace(specimen.body, numbers=numbers))
    return found
