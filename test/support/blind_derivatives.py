# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Slopes and stiffness of the blind generator's potentials and bodies, by differences."""

import numpy as np
import pytest

from benchmarks.blind.body import Body
from benchmarks.blind.equilibrium import PotentialLaw


def check_derivatives(law: PotentialLaw, positions: np.ndarray) -> None:
    """Fail where slopes are not those of the energy, or stiffness not those of the slopes."""
    random = np.random.default_rng(3)
    move = random.standard_normal(positions.shape)
    h = 1e-6
    one, other = law(positions + h * move), law(positions - h * move)
    here = law(positions)
    slope = float((here.gradient * move).sum())
    assert (one.energy - other.energy) / (2.0 * h) == pytest.approx(slope, rel=1e-5)
    change = (one.gradient - other.gradient) / (2.0 * h)
    stiff = np.einsum('nij,nj->ni', here.diagonal, move)
    assert np.allclose(change, stiff, rtol=0.0, atol=1e-5 * np.abs(stiff).max())


def check_body_stiffness(body: Body, positions: np.ndarray) -> None:
    """Fail where a body's stiffness is not the slopes of its forces, drawn longer by 3 %."""
    random = np.random.default_rng(2)
    bent = positions * np.array([1.03, 0.99, 0.99])
    bent = bent + 1e-4 * random.standard_normal(bent.shape)
    move, h = random.standard_normal(bent.shape), 1e-8
    one, other = (body.evaluate(bent + way * h * move).gradient for way in (1.0, -1.0))
    blocks = body.evaluate(bent).blocks
    assert blocks is not None
    parts = np.einsum('cij,cj->ci', blocks, move[body.cells].reshape(len(blocks), -1))
    whole = np.zeros_like(bent)
    np.add.at(whole, body.cells, parts.reshape(*body.cells.shape, 3))
    assert np.allclose((one - other) / (2.0 * h), whole, rtol=0.0, atol=1e-4 * np.abs(whole).max())
