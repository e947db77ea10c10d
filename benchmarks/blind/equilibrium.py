# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Static equilibrium: Newton with a banded Cholesky factor and an energy line search."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.linalg import (
    cho_factor,
    cho_solve,
    cho_solve_banded,
    cholesky_banded,
    LinAlgError,
)

from benchmarks.blind.body import Body
from benchmarks.blind.shapes import FloatArray

_TOLERANCE = 1e-6  # Of the residual force relative to the load; well under a micrometre.
_UNLOADED = 1e-7  # Without a load, of shear modulus times the body's size squared.
_LARGEST_ITERATIONS = 60


@dataclass(frozen=True)
class Potential:
    """Energy of something beside elasticity, at node positions.

    Attributes:
        energy: [J].
        gradient: [N], shape (N, 3).
        diagonal: 3x3 stiffness of single nodes [N/m], shape (N, 3, 3).
        shared: column whose outer product is to be taken from that: by which less all nodes are
            held that move together [(N/m)^(1/2)], shape (N, 3); None: there is none.
    """

    energy: float
    gradient: FloatArray
    diagonal: FloatArray
    shared: FloatArray | None = None


PotentialLaw = Callable[[FloatArray], Potential]


@dataclass(frozen=True)
class Load:
    """What acts on a body, in the object frame.

    Attributes:
        forces: dead forces of nodes [N], shape (N, 3).
        potentials: further energies, such as a contact.
    """

    forces: FloatArray
    potentials: tuple[PotentialLaw, ...] = field(default=())


class NoEquilibriumError(RuntimeError):
    """Newton did not converge."""


def find_equilibrium(body: Body, load: Load, start: FloatArray) -> FloatArray:
    """Return node positions at rest under a load.

    Args:
        body: the elastic body.
        load: acts on it.
        start: first guess [m], shape (N, 3); its held nodes stay.

    Raises:
        NoEquilibriumError: when it does not converge.
    """
    positions = start.copy()
    scale = max(float(np.linalg.norm(load.forces)), _UNLOADED * _typical_force(body))
    shift = 0.0
    for _ in range(_LARGEST_ITERATIONS):
        energy, gradient, blocks, diagonal = _total(body, load, positions)
        free = gradient.ravel()[body.band.numbers]
        if np.linalg.norm(free) < _TOLERANCE * scale:
            return positions
        matrix = _matrix(body, blocks, diagonal)
        columns = shared_columns(body, load.potentials, positions)
        step, shift = _descent(matrix, free, shift, columns)
        move = np.zeros(positions.size)
        move[body.band.numbers] = step
        positions = _search(body, load, positions, move.reshape(-1, 3), energy, float(free @ step))
    raise NoEquilibriumError(f'no equilibrium in {_LARGEST_ITERATIONS} iterations')


def _typical_force(body: Body) -> float:
    volumes = body.quadrature.volumes
    return float(np.mean(body.numbers.shear) * volumes.sum() ** (2.0 / 3.0))


def _total(
    body: Body, load: Load, positions: FloatArray
) -> tuple[float, FloatArray, FloatArray, FloatArray | None]:
    elastic = body.evaluate(positions)
    energy = elastic.energy - float((load.forces * positions).sum())
    gradient = elastic.gradient - load.forces
    diagonal = None
    for law in load.potentials:
        extra = law(positions)
        energy += extra.energy
        gradient = gradient + extra.gradient
        diagonal = extra.diagonal if diagonal is None else diagonal + extra.diagonal
    assert elastic.blocks is not None
    return energy, gradient, elastic.blocks, diagonal


def _matrix(body: Body, blocks: FloatArray, diagonal: FloatArray | None) -> FloatArray:
    matrix = body.band.assemble(blocks)
    return matrix if diagonal is None else with_diagonal(matrix, body, diagonal)


def with_diagonal(matrix: FloatArray, body: Body, diagonal: FloatArray) -> FloatArray:
    """Return a body's banded stiffness with that of single nodes, (N, 3, 3), added to it."""
    for i in range(3):
        for k in range(i + 1):
            rows = body.band.order[i::3]
            free = rows >= 0
            columns = body.band.order[k::3][free]
            matrix[rows[free] - columns, columns] += diagonal[free, i, k]
    return matrix


def shared_columns(
    body: Body, laws: tuple[PotentialLaw, ...], positions: FloatArray
) -> FloatArray | None:
    """Return what laws have of `Potential.shared` at the free numbers, (n, M); None: nothing."""
    found = [shared for law in laws if (shared := law(positions).shared) is not None]
    if not found:
        return None
    return np.stack([shared.ravel()[body.band.numbers] for shared in found], axis=1)


def solve_shared(factor: FloatArray, right: FloatArray, columns: FloatArray | None) -> FloatArray:
    """Solve with a banded Cholesky factor less the outer products of columns (Woodbury).

    Args:
        factor: lower, of a matrix of n numbers.
        right: side, shape (n,).
        columns: shape (n, M); None: there are none.

    Raises:
        LinAlgError: where what is left is not positive.
    """
    found = cho_solve_banded((factor, True), right, check_finite=False)
    if columns is None:
        return np.asarray(found)
    solved = cho_solve_banded((factor, True), columns, check_finite=False)
    left = cho_factor(np.eye(columns.shape[1]) - columns.T @ solved)
    return np.asarray(found + solved @ cho_solve(left, columns.T @ found))


def _descent(
    matrix: FloatArray, gradient: FloatArray, shift: float, columns: FloatArray | None
) -> tuple[FloatArray, float]:
    """Solve for the Newton step; a shift of the diagonal makes the matrix positive."""
    typical = float(matrix[0].mean())
    shift = shift / 10.0 if shift > 1e-7 * typical else 0.0
    while True:
        shifted = matrix.copy()
        shifted[0] += shift
        try:
            factor = cholesky_banded(shifted, lower=True, overwrite_ab=True, check_finite=False)
            return -solve_shared(factor, gradient, columns), shift
        except LinAlgError:
            shift = max(10.0 * shift, 1e-5 * typical)


def _search(
    body: Body,
    load: Load,
    positions: FloatArray,
    move: FloatArray,
    energy: float,
    slope: float,
) -> FloatArray:
    """Halve the step until the energy falls as its slope promises."""
    # Near the minimum, differences of energies drown in the rounding of their terms.
    rounding = 1e-14 * float((body.numbers.shear * body.quadrature.volumes).sum())
    length = 1.0
    for _ in range(30):
        tried = positions + length * move
        value = body.evaluate(tried, with_stiffness=False).energy
        value -= float((load.forces * tried).sum())
        value += sum(law(tried).energy for law in load.potentials)
        if value <= energy + 1e-4 * length * slope + rounding:
            return tried
        length *= 0.5
    return positions + length * move
