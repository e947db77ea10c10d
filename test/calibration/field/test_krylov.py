# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""One Krylov space against dense solves for every weight."""

from diffcal_ros.calibration.field.krylov import krylov_space
from diffcal_ros.calibration.field.layout import FieldKind, tets_from_unknowns
from diffcal_ros.calibration.field.smoothness import Smoothness
import numpy as np
import pytest
from scipy.linalg import eigh
from support.beams import beam_mesh

_SEEN = 12
# What the process stops at, in the residual.
_RELATIVE = 1e-2


@pytest.fixture
def problem(random):
    """What some data know of a field on a small beam: a few patterns, quickly less."""
    mesh = beam_mesh((5, 2, 2))
    smoothness = Smoothness(mesh, tets_from_unknowns(mesh, FieldKind()))
    jacobian = random.normal(size=(_SEEN, mesh.tet_count)) * 0.5 ** np.arange(_SEEN)[:, None]
    form = np.stack([smoothness.apply(unit) for unit in np.eye(mesh.tet_count)])
    return jacobian.T @ jacobian, form, smoothness, jacobian.T @ random.normal(size=_SEEN)


@pytest.mark.parametrize('share', [1.0, 1e-2, 1e-4])
def test_solves_for_every_weight(problem, share: float) -> None:
    known, form, smoothness, right_side = problem
    space = krylov_space(lambda u: known @ u, smoothness, right_side, 1e-4)
    weight = share * space.strongest
    expected = np.linalg.solve(known + weight * form, right_side)
    error = space.solve(weight) - expected
    assert error @ form @ error < _RELATIVE**2 * (expected @ form @ expected)


def test_ritz_values_are_what_the_data_see(problem) -> None:
    known, form, smoothness, right_side = problem
    space = krylov_space(lambda u: known @ u, smoothness, right_side, 1e-9)
    expected = eigh(known, form, eigvals_only=True)[::-1][:3]
    # The process stops at a residual of 3e-3, and values err by its square.
    np.testing.assert_allclose(space.values[:3], expected, rtol=1e-4)
    vectors = space.ritz_vectors()
    np.testing.assert_allclose(vectors @ form @ vectors.T, np.eye(len(vectors)), atol=1e-8)


def test_nothing_to_ask_for_is_said(problem) -> None:
    known, _, smoothness, right_side = problem
    with pytest.raises(ValueError, match='right-hand side is zero'):
        krylov_space(lambda u: known @ u, smoothness, 0.0 * right_side, 1e-4)
