# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A load that is held on a body whose stress relaxes: finite viscoelasticity with Prony pairs.

With the elastic second Piola-Kirchhoff stress S0 the stress is (1 - sum g) S0 + sum g H, where
each H follows dH/dt = dS0/dt - H / tau (Simo 1987, the same share of all stresses). Inertia is
left out.
"""

from collections.abc import Sequence

import numpy as np
from scipy.linalg import cho_solve_banded, cholesky_banded

from benchmarks.blind.body import Body
from benchmarks.blind.equilibrium import find_equilibrium, Load
from benchmarks.blind.material import respond, squares_stress
from benchmarks.blind.shapes import FloatArray

_STEPS_PER_TIME = 12.0  # Steps in one relaxation time.
_TOLERANCE = 1e-6  # Of the residual against the load.
_ROUNDS = 60


class NoRestError(RuntimeError):
    """A step found no equilibrium."""


def held_load(
    body: Body,
    load: Load,
    start: FloatArray,
    times: Sequence[float],
    pairs: Sequence[tuple[FloatArray | float, float]],
    *,
    is_graded: bool = False,
) -> list[FloatArray]:
    """Return node positions [m], shape (N, 3), at times since a support was taken away.

    Args:
        body: without the support.
        load: held from then on.
        start: positions at first [m], shape (N, 3); stresses of before are taken for relaxed in
            the same way as those that come.
        times: ascending, above 0 [s].
        pairs: g and tau [s] of each; g is the same all over, or that of Gauss points, shape
            (C, 8, 1, 1).
        is_graded: steps grow with the time: what relaxes faster has done so by then.

    Raises:
        NoRestError: when a step does not converge.
    """
    positions = find_equilibrium(body, load, start)
    pairs = [(share, tau) for share, tau in pairs if np.any(share)]
    if not pairs:
        return [positions for _ in times]
    elastic = _stress(body, positions)
    histories = [elastic for _ in pairs]
    fastest = min(tau for _, tau in pairs)
    now, found = 0.0, []
    for time in times:
        relaxation = max(fastest, now) if is_graded else fastest
        count = max(int(np.ceil((time - now) * _STEPS_PER_TIME / relaxation)), 1)
        step = (time - now) / count
        falls = [float(np.exp(-step / tau)) for _, tau in pairs]
        for _ in range(count):
            # H' = fall H + half (S0' - S0), so that the stress is linear in S0'.
            known, kept = np.zeros_like(elastic), np.ones((1, 1, 1, 1))
            for (share, _), fall, history in zip(pairs, falls, histories, strict=True):
                known += share * (fall * history - np.sqrt(fall) * elastic)
                kept = kept - share * (1.0 - float(np.sqrt(fall)))
            positions = _settle(body, load, positions, kept, known)
            now_elastic = _stress(body, positions)
            histories = [
                fall * history + np.sqrt(fall) * (now_elastic - elastic)
                for fall, history in zip(falls, histories, strict=True)
            ]
            elastic = now_elastic
        now = time
        found.append(positions.copy())
    return found


def _gradients(body: Body, positions: FloatArray) -> FloatArray:
    return np.swapaxes(positions[body.cells], 1, 2)[:, None] @ body.quadrature.gradients


def _stress(body: Body, positions: FloatArray) -> FloatArray:
    """Return the elastic second Piola-Kirchhoff stress [Pa], shape (C, 8, 3, 3)."""
    F = _gradients(body, positions)
    law = respond(F, body.numbers)
    first = law.along[..., None, None] * F + law.pressure[..., None, None] * law.cofactor
    if law.squares.any():
        first = first + squares_stress(F, law.squares)
    for family in body.numbers.families:
        first = first + family.stress(F)
    return np.asarray(np.linalg.solve(F, first))


def _settle(
    body: Body, load: Load, start: FloatArray, kept: FloatArray, known: FloatArray
) -> FloatArray:
    """Find the equilibrium of kept S0 + known [Pa] by Newton with the elastic stiffness."""
    positions, factor, left = start.copy(), None, np.inf
    scale = float(np.linalg.norm(load.forces))
    for _ in range(_ROUNDS):
        stress = _gradients(body, positions) @ (kept * _stress(body, positions) + known)
        scaled = body.quadrature.volumes[..., None, None] * body.quadrature.gradients
        parts = (scaled @ np.swapaxes(stress, -1, -2)).sum(axis=1)
        force = -load.forces.copy()
        for axis in range(3):
            force[:, axis] += np.bincount(
                body.cells.ravel(), parts[..., axis].ravel(), body.node_count
            )
        residual = force.ravel()[body.band.numbers]
        size = float(np.linalg.norm(residual))
        if size < _TOLERANCE * scale:
            return positions
        if factor is None or size > 0.5 * left:
            blocks = body.evaluate(positions).blocks
            assert blocks is not None
            factor = cholesky_banded(body.band.assemble(blocks), lower=True, check_finite=False)
        left = size
        flat = positions.ravel()
        flat[body.band.numbers] -= cho_solve_banded((factor, True), residual, check_finite=False)
        positions = flat.reshape(-1, 3)
    raise NoRestError('a creeping body found no rest')
