# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the thirty-first set has do what their labels say."""

import numpy as np
import pytest
from support.blind_draws import draw_sealed, SEALED
from support.blind_rests import COARSE, rubber_volumes
from support.blind_views import with_and_without

from benchmarks.blind.faults import Faults
from benchmarks.blind.rest_shape import true_shape
from benchmarks.blind.setups import Setup
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.thirtyfirst_outside import THIRTYFIRST_OUTSIDE


def _drawn(name: str, setup: Setup, size: int = 2) -> Faults:
    return Faults(**THIRTYFIRST_OUTSIDE[name](size, setup, np.random.default_rng(8)).changes)


def test_a_domed_end_is_lower_all_around(setup: Setup) -> None:
    shape, half = setup.shape, 0.5 * np.array(setup.shape.section)
    domed = true_shape(shape, Faults(domed=8.0))
    free = shape.length - shape.clamp
    across = half * np.array([[0, 0], [0.5, 0], [0, -0.5], [0.5, 0.5], [1, 0], [-1, 1]])
    for share, part in ((0.0, 0.0), (0.7, 0.0), (0.85, 0.5), (1.0, 1.0)):
        places = np.column_stack([np.full(6, shape.clamp + share * free), across])
        back = 1e3 * (shape.place(places) - domed.place(places))
        assert back[:, 1:] == pytest.approx(0.0, abs=1e-12)
        assert back[:, 0] == pytest.approx(part * np.array([0.0, 2.0, 2.0, 3.5, 8.0, 8.0]))


def test_a_domed_beam_lacks_five_ninths_of_its_dome(setup: Setup) -> None:
    left, whole = rubber_volumes(setup, Faults(domed=9.0))
    width, height = setup.shape.section
    # Amid a face no node has the product of both squares.
    assert whole - left == pytest.approx(5.0 / 9.0 * 0.009 * width * height, rel=0.03)


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_domed_end_has_edges_some_4_and_10_mm_back(family: str) -> None:
    drawn = draw_sealed(family)
    nodes = make_specimen(drawn, Faults(), COARSE).mesh.lattice
    tip = nodes[nodes[:, 0] > nodes[:, 0].max() - 1e-9]
    for size, least, most in ((1, 3.3, 4.7), (2, 8.4, 11.6)):
        faults = _drawn('domed', drawn, size)
        placed = [true_shape(drawn.shape, each).place(tip) for each in (Faults(), faults)]
        assert least < 1e3 * np.linalg.norm(placed[1] - placed[0], axis=1).max() < most
        left, whole = rubber_volumes(drawn, faults)
        assert 0.5 * whole < left < whole


@pytest.mark.parametrize(('size', 'most'), [(1, 4.0), (2, 10.0)])
def test_columns_err_by_how_much_they_see(
    setup: Setup, plain: Specimen, rests: list[np.ndarray], size: int, most: float
) -> None:
    faults = _drawn('crosstalk', setup, size)
    assert abs(faults.crosstalk) == pytest.approx(most, rel=0.16)
    for pose in range(4):
        view, right, there = with_and_without(plain, setup, faults, pose, rests[pose])
        errors = np.zeros(there.shape)
        errors[there] = 1e3 * (view.depth[there] - right.depth[there])
        counts = [int(there[:, column].sum()) for column in range(there.shape[1])]
        expected = faults.crosstalk * np.array(counts) / max(counts)
        whole = np.broadcast_to(expected[:, None], there.shape)
        assert errors[there] == pytest.approx(whole[there], abs=1e-6)
        assert np.ptp(errors[there]) > 0.3 * most


def test_columns_do_not_err_where_no_error_is_told(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    view, right, there = with_and_without(plain, setup, Faults(crosstalk=0.0), 0, rests[0])
    assert np.array_equal(view.depth[there], right.depth[there])
