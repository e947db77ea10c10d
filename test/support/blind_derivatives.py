# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Slopes and stiffness of the blind generator's potentials and bodies, by differences."""

from collections.abc import Sequence

import numpy as np
import pytest

from benchmarks.blind.body import Body
from benchmarks.blind.equilibrium import PotentialLaw
from benchmarks.blind.fibres import Fibres


def check_derivatives(
    law: PotentialLaw,
    positions: np.ndarray,
    *,
    step: float = 1e-6,
    is_smooth: np.ndarray | None = None,
    share: float = 1e-5,
) -> np.ndarray:
    """Fail where slopes are not those of the energy, or stiffness not those of the slopes.

    Args:
        law: of the energy.
        positions: around which [m], shape (N, 3).
        step: by which nodes are moved to either side, by standard normal draws [m].
        is_smooth: nodes whose stiffness is compared, and not just begins, shape (N,); None: all.
        share: of the largest stiffness by which they may differ.

    Returns:
        By how much the slopes change with such a move, by stiffness [N/m], shape (N, 3).
    """
    move = np.random.default_rng(3).standard_normal(positions.shape)
    here, one, other = (law(positions + way * step * move) for way in (0.0, 1.0, -1.0))
    slope = float((here.gradient * move).sum())
    assert (one.energy - other.energy) / (2.0 * step) == pytest.approx(slope, rel=1e-5)
    change = (one.gradient - other.gradient) / (2.0 * step)
    stiff = np.einsum('nij,nj->ni', here.diagonal, move)
    own = np.ones(len(positions), dtype=bool) if is_smooth is None else is_smooth
    assert np.allclose(change[own], stiff[own], rtol=0.0, atol=share * np.abs(stiff).max())
    return np.asarray(stiff)


def check_body_stiffness(body: Body, positions: np.ndarray, *, step: float = 1e-8) -> None:
    """Fail where a body's stiffness is not the slopes of its forces, drawn longer by 3 %.

    Args:
        body: the elastic body.
        positions: of its nodes before that [m], shape (N, 3).
        step: by which nodes are moved to either side, by standard normal draws [m].
    """
    random = np.random.default_rng(2)
    bent = positions * np.array([1.03, 0.99, 0.99])
    bent = bent + 1e-4 * random.standard_normal(bent.shape)
    move, h = random.standard_normal(bent.shape), step
    one, other = (body.evaluate(bent + way * h * move).gradient for way in (1.0, -1.0))
    blocks = body.evaluate(bent).blocks
    assert blocks is not None
    parts = np.einsum('cij,cj->ci', blocks, move[body.cells].reshape(len(blocks), -1))
    whole = np.zeros_like(bent)
    np.add.at(whole, body.cells, parts.reshape(*body.cells.shape, 3))
    assert np.allclose((one - other) / (2.0 * h), whole, rtol=0.0, atol=1e-4 * np.abs(whole).max())


def check_loose_fibres(
    fibres: Fibres, strained: np.ndarray, step: float, still: Sequence[float]
) -> None:
    """Fail where fibres along x that are loose at first do not resist by their energy.

    Args:
        fibres: that are.
        strained: deformation gradient at which they resist, shape (3, 3).
        step: by which it is moved to either side, by standard normal draws.
        still: stretches along x at which they do not.
    """
    move = np.random.default_rng(2).standard_normal((3, 3))
    one, other = (fibres.energy(strained + way * step * move) for way in (1.0, -1.0))
    slope = float((fibres.stress(strained) * move).sum())
    assert slope != 0.0
    assert (one - other) / (2.0 * step) == pytest.approx(slope, rel=1e-5)
    for stretch in still:
        assert not fibres.stress(np.diag([stretch, 1.0, 1.0])).any()
        assert fibres.energy(np.diag([stretch, 1.0, 1.0])) == 0.0
    # The square of what is beyond where they are no longer loose.
    change = abs(float((strained[:, 0] ** 2).sum()) - 1.0)
    assert fibres.energy(strained) == pytest.approx(
        fibres.stiffness * (change - fibres.loose) ** 2
    )
