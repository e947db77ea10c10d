# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body that is let go: the trapezoidal rule with consistent masses.

    x' = x + h/2 (v + v'),    M (v' - v) = h/2 (f(x, v) + f(x', v'))

solved by Newton with a banded Cholesky factor that is kept while it serves. No energy is lost but
by damping (stress beta F D, D = sym(F^T dF/dt)) and by the air.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.linalg import cholesky_banded, LinAlgError

from benchmarks.blind.body import Body
from benchmarks.blind.drag import Drag
from benchmarks.blind.equilibrium import (
    PotentialLaw,
    shared_columns,
    solve_shared,
    with_diagonal,
)
from benchmarks.blind.hexahedra import shape_functions, shape_gradients
from benchmarks.blind.shapes import FloatArray

_TOLERANCE = 1e-7  # Of the residual against the weight.
_ROUNDS = 40
_DIVERGED = 1e6
_MOST_HALVINGS = 6
_SLOW = 0.3  # A round that leaves a larger share asks for a new factor.


@dataclass(frozen=True)
class Forces:
    """What acts on a moving body, in the object frame.

    Attributes:
        loads: dead forces of nodes [N], shape (N, 3).
        damping: beta [Pa s].
        drag: of the air.
        modulus: usual Young's modulus, to guess how stiff damping is [Pa].
        changing: further forces [N], shape (N, 3), by the time since the release [s]; None: none.
        laws: energies of what else draws single nodes, by where they are.
        dashpots: what holds single nodes back by their speed [N s/m], shape (N,); None: nothing.
    """

    loads: FloatArray
    damping: float
    drag: Drag
    modulus: float
    changing: Callable[[float], FloatArray] | None = None
    laws: tuple[PotentialLaw, ...] = ()
    dashpots: FloatArray | None = None


class NoMotionError(RuntimeError):
    """Newton did not converge."""


def consistent_masses(nodes: FloatArray, body: Body, density: float) -> FloatArray:
    """Return each element's mass matrix by 27 Gauss points [kg], shape (C, 20, 20).

    Args:
        nodes: at rest [m], shape (N, 3).
        body: of it.
        density: [kg/m^3].
    """
    places, weights = np.polynomial.legendre.leggauss(3)
    points = np.array(list(product(places, repeat=3)))
    shares = np.array([np.prod(triple) for triple in product(weights, repeat=3)])
    values, slopes = shape_functions(points), shape_gradients(points)
    jacobians = np.einsum('cai,gaj->cgij', nodes[body.cells], slopes)
    volumes = shares * np.linalg.det(jacobians)
    return density * np.einsum('cg,ga,gb->cab', volumes, values, values, optimize=True)


def with_lumps(masses: FloatArray, body: Body, lumps: FloatArray) -> FloatArray:
    """Return mass matrices of the elements with masses of single nodes beside them.

    Args:
        masses: see `consistent_masses`, shape (C, 20, 20).
        body: of it.
        lumps: of the nodes [kg], shape (N,); each goes to one element that has the node.
    """
    found = masses.copy()
    nodes, first = np.unique(body.cells, return_index=True)
    cell, corner = np.unravel_index(first, body.cells.shape)
    found[cell, corner, corner] += lumps[nodes]
    return found


def swing(
    body: Body,
    masses: FloatArray,
    forces: Forces,
    start: FloatArray,
    times: Sequence[float],
    step: float,
    then: tuple[float, Body] | None = None,
) -> list[FloatArray]:
    """Return node positions [m], shape (N, 3), at times since the release [s], ascending.

    Args:
        body: held where it stays held.
        masses: of the elements, see `consistent_masses`.
        forces: on it.
        start: node positions at the release [m], shape (N, 3).
        times: none below 0.
        step: of time [s].
        then: when the body becomes another one of the same nodes and masses [s], and which; None:
            it stays the same.

    Raises:
        NoMotionError: when a step does not converge.
    """
    march = _March(body, masses, forces, step)
    positions, velocities, now = start.copy(), np.zeros_like(start), 0.0
    found: list[FloatArray] = []
    for time in times:
        if then is not None and then[0] < time:
            positions, velocities = march.reach(positions, velocities, now, then[0])
            now, march, then = then[0], _March(then[1], masses, forces, step), None
        positions, velocities = march.reach(positions, velocities, now, time)
        now = time
        found.append(positions.copy())
    return found


class _March:
    """Steps of one motion."""

    def __init__(self, body: Body, masses: FloatArray, forces: Forces, step: float) -> None:
        self._body, self._masses, self._forces, self._step = body, masses, forces, step
        blocks = np.zeros((len(masses), 20, 3, 20, 3))
        for axis in range(3):
            blocks[:, :, axis, :, axis] = masses
        self._mass_band = body.band.assemble(blocks.reshape(len(masses), 60, 60))
        self._factor: FloatArray | None = None
        self._columns: FloatArray | None = None
        self._factored_step = 0.0
        self._scale = float(np.abs(forces.loads).sum())

    def reach(
        self, positions: FloatArray, velocities: FloatArray, now: float, time: float
    ) -> tuple[FloatArray, FloatArray]:
        """Take as many steps as there are from one time to another [s]."""
        # Steps end where a frame is wanted: nothing is interpolated.
        count = int(np.ceil((time - now) / self._step * (1.0 - 1e-9)))
        own = (time - now) / count if count else 0.0
        for number in range(count):
            positions, velocities = self.cross(positions, velocities, own, now + number * own)
        return positions, velocities

    def cross(
        self,
        positions: FloatArray,
        velocities: FloatArray,
        step: float,
        now: float,
        halvings: int = 0,
    ) -> tuple[FloatArray, FloatArray]:
        """Take one step, or two halves of it where it does not converge."""
        try:
            return self.advance(positions, velocities, step, now)
        except (NoMotionError, LinAlgError):
            if halvings == _MOST_HALVINGS:
                raise
        half = 0.5 * step
        for begun in (now, now + half):
            positions, velocities = self.cross(positions, velocities, half, begun, halvings + 1)
        return positions, velocities

    def advance(
        self, positions: FloatArray, velocities: FloatArray, step: float, now: float
    ) -> tuple[FloatArray, FloatArray]:
        """Take one step, from a time since the release on [s]."""
        before = self._force(positions, velocities, now)
        place, left = positions + step * velocities, np.inf
        place[self._body.held] = positions[self._body.held]
        for _ in range(_ROUNDS):
            speed = 2.0 / step * (place - positions) - velocities
            pull = self._times_mass(speed - velocities)
            pull -= 0.5 * step * (before + self._force(place, speed, now + step))
            residual = pull.ravel()[self._body.band.numbers]
            size = float(np.abs(residual).sum()) / step
            if size < _TOLERANCE * self._scale:
                return place, speed
            if not size < _DIVERGED * self._scale:
                break
            if size > _SLOW * left or step != self._factored_step:
                self._renew(positions, step)
            left = size
            assert self._factor is not None
            change = solve_shared(self._factor, residual, self._columns)
            flat = place.ravel()
            flat[self._body.band.numbers] -= change
            place = flat.reshape(-1, 3)
        raise NoMotionError(f'a step of {step:g} s does not converge')

    def _renew(self, place: FloatArray, step: float) -> None:
        elastic = self._body.evaluate(place)
        assert elastic.blocks is not None
        # Damping acts on shear as stiffness does: beta against 2 mu, some two thirds of E.
        stiffer = 1.0 + 2.0 * self._forces.damping / (step * self._forces.modulus / 1.5)
        matrix = 2.0 / step * self._mass_band
        matrix = matrix + 0.5 * step * stiffer * self._body.band.assemble(elastic.blocks)
        for law in self._forces.laws:
            matrix = with_diagonal(matrix, self._body, 0.5 * step * law(place).diagonal)
        if self._forces.dashpots is not None:
            # A step's speed goes with twice its way.
            resisting = self._forces.dashpots[:, None, None] * np.eye(3)
            matrix = with_diagonal(matrix, self._body, resisting)
        columns = shared_columns(self._body, self._forces.laws, place)
        self._columns = None if columns is None else np.sqrt(0.5 * step) * columns
        self._factor = cholesky_banded(matrix, lower=True, check_finite=False)
        self._factored_step = step

    def _force(self, positions: FloatArray, velocities: FloatArray, now: float) -> FloatArray:
        """Return loads less internal forces, damping and drag [N], shape (N, 3)."""
        force = self._forces.loads - self._body.evaluate(positions, with_stiffness=False).gradient
        force -= self._viscous(positions, velocities)
        force -= self._forces.drag.forces(velocities)
        if self._forces.dashpots is not None:
            force -= self._forces.dashpots[:, None] * velocities
        if self._forces.changing is not None:
            force += self._forces.changing(now)
        for law in self._forces.laws:
            force -= law(positions).gradient
        return force

    def _viscous(self, positions: FloatArray, velocities: FloatArray) -> FloatArray:
        cells, quadrature = self._body.cells, self._body.quadrature
        F = np.swapaxes(positions[cells], 1, 2)[:, None] @ quadrature.gradients
        L = np.swapaxes(velocities[cells], 1, 2)[:, None] @ quadrature.gradients
        rate = np.swapaxes(F, -1, -2) @ L
        stress = self._forces.damping * F @ (0.5 * (rate + np.swapaxes(rate, -1, -2)))
        scaled = quadrature.volumes[..., None, None] * quadrature.gradients
        return self._gathered((scaled @ np.swapaxes(stress, -1, -2)).sum(axis=1))

    def _times_mass(self, field: FloatArray) -> FloatArray:
        return self._gathered(self._masses @ field[self._body.cells])

    def _gathered(self, parts: FloatArray) -> FloatArray:
        """Sum parts of elements, shape (C, 20, 3), at the nodes."""
        count, cells = self._body.node_count, self._body.cells.ravel()
        columns = [np.bincount(cells, parts[..., axis].ravel(), count) for axis in range(3)]
        return np.stack(columns, axis=1).astype(np.float64)
