# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Shapes that the body takes over its modulus, from stiff to soft.

They are found with linear elements, which bend too little. The body of the fit itself, simulated
once, tells by how much: the linear one is as compliant at another modulus, and that ratio is
taken for all.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.parameters.parameters import Kind, ParameterSet
from diffcal_ros.errors import NotSimulatedError
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Where soft bodies are looked for, unless the scene bounds them closer [Pa].
SOFTEST, STIFFEST = 1e4, 1e7
# Neighbouring shapes of one family: a quarter of what the softer one sags less [log].
_SPACING = 0.45
# Shapes that differ by less are one for a coarse image [m].
_ALIKE = 0.003
# Of two regions, one may be stiffer than it starts beside the other by this [log].
_CONTRASTS = (0.0, -1.4, 1.4)
# Linear elements are taken for at most so much too stiff [log].
_MOST_LOCKING = 1.5


@dataclass(frozen=True)
class Shape:
    """One shape of the body.

    Attributes:
        coordinates: of the fit's own parameters that lead to it, shape (k,).
        world: nodes of the linear body that every observation shows [m], shape (N, 3) each.
        family: which contrast of the regions it belongs to.
    """

    coordinates: FloatArray
    world: tuple[FloatArray, ...]
    family: int


def modulus_indices(parameters: ParameterSet) -> list[int]:
    """Return the places of the moduli."""
    return parameters.find(Kind.YOUNGS_MODULUS)


def make_shapes(model: ForwardModel, centre: FloatArray, compliance: float | None) -> list[Shape]:
    """Simulate shapes over the moduli; what has no equilibrium is left out.

    Args:
        model: simulates, with linear elements.
        centre: coordinates of all else, and of the moduli's ratios, shape (k,).
        compliance: how much the fit's own body sags at `centre`, see `sag`; None: not known.
    """
    indices = modulus_indices(model.parameters)
    if not indices:
        return [Shape(centre, tuple(model.worlds(centre)), 0)]
    lower, upper = model.parameters.bounds()
    shapes = _simulated(model, centre, indices)
    if compliance is None or not shapes:
        return shapes
    shift = _locking(model, centre, shapes, compliance)
    return [
        own
        for own in (_shifted(shape, indices, shift) for shape in shapes)
        if _is_within(own.coordinates[indices], lower[indices], upper[indices])
    ] or shapes


def sag(
    worlds: Sequence[FloatArray], rests: Sequence[FloatArray], pulls: Sequence[FloatArray]
) -> float:
    """Return how far the middle of a body's surface has moved along gravity [m].

    Args:
        worlds: vertices that every observation shows [m], shape (V, 3) each.
        rests: the same at rest.
        pulls: gravity of each, shape (3,).
    """
    total = 0.0
    for world, rest, pull in zip(worlds, rests, pulls, strict=True):
        size = float(np.linalg.norm(pull))
        if size > 0.0:
            total += float((world - rest).mean(axis=0) @ pull) / size
    return total


def _levels(lower: FloatArray, upper: FloatArray) -> FloatArray:
    """Return logarithms of moduli from stiff to soft."""
    low = max(float(lower.max()), np.log(SOFTEST))
    high = min(float(upper.min()), np.log(STIFFEST))
    if high <= low:
        low, high = float(lower.max()), float(upper.min())
    return np.linspace(high, low, max(2, int(np.ceil((high - low) / _SPACING)) + 1))


def _contrasts(centre: FloatArray) -> list[FloatArray]:
    """Return logarithms by which regions differ from their mean.

    Of one or two regions the start does not decide; of more it does, for there is no end of ways.
    """
    if len(centre) == 2:
        return [0.5 * size * np.array([1.0, -1.0]) for size in _CONTRASTS]
    return [centre - centre.mean()]


def _simulated(model: ForwardModel, centre: FloatArray, indices: list[int]) -> list[Shape]:
    """Simulate families of shapes; what hardly differs from the last one is left out."""
    lower, upper = model.parameters.bounds()
    shapes: list[Shape] = []
    for family, contrast in enumerate(_contrasts(centre[indices])):
        last: tuple[FloatArray, ...] | None = None
        for level in _levels(lower[indices], upper[indices]):
            coordinates = centre.copy()
            coordinates[indices] = contrast + level
            try:
                world = tuple(model.worlds(coordinates))
            except NotSimulatedError:
                continue
            if last is not None and _apart(world, last) < _ALIKE:
                continue
            last = world
            shapes.append(Shape(coordinates, world, family))
    return shapes


def _apart(one: Sequence[FloatArray], other: Sequence[FloatArray]) -> float:
    """Return how far two shapes are apart where they are most [m]."""
    return max(float(np.abs(a - b).max()) for a, b in zip(one, other, strict=True))


def _shifted(shape: Shape, indices: list[int], shift: float) -> Shape:
    moved = shape.coordinates.copy()
    moved[indices] -= shift
    return replace(shape, coordinates=moved)


def _is_within(moduli: FloatArray, lower: FloatArray, upper: FloatArray) -> bool:
    return bool((moduli >= lower).all() and (moduli <= upper).all())


def _locking(
    model: ForwardModel, centre: FloatArray, shapes: Sequence[Shape], compliance: float
) -> float:
    """Return by how much softer linear elements sag as far, as a logarithm of the modulus.

    The shapes have one ratio of moduli and the start another, so both are compared by the mean
    of their logarithms, which is what a start needs and no more.
    """
    indices = modulus_indices(model.parameters)
    family = [shape for shape in shapes if shape.family == shapes[0].family]
    rests = [model.body(seen).discretisation.rest_nodes for seen in model.observations]
    pulls = [model.inputs.gravity(seen.setup_index, centre) for seen in model.observations]
    sags = np.array([sag(shape.world, rests, pulls) for shape in family])
    levels = np.array([float(shape.coordinates[indices].mean()) for shape in family])
    order = np.argsort(sags)
    if not sags[order[0]] < compliance < sags[order[-1]]:
        return 0.0
    same = float(np.interp(compliance, sags[order], levels[order]))
    return float(np.clip(same - centre[indices].mean(), -_MOST_LOCKING, 0.0))
