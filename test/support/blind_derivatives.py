# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Slopes and stiffness of the blind generator's potentials, by differences."""

import numpy as np
import pytest

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
