# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the thirty-second set has do what their labels say."""

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
from benchmarks.blind.thirtysecond_outside import THIRTYSECOND_OUTSIDE


def _drawn(name: str, setup: Setup, size: int = 2) -> Faults:
    return Faults(**THIRTYSECOND_OUTSIDE[name](size, setup, np.random.default_rng(8)).changes)


def test_a_ridge_stands_out_amid_one_side(setup: Setup) -> None:
    shape, half = setup.shape, 0.5 * np.array(setup.shape.section)
    keeled = true_shape(shape, Faults(keeled=8.0))
    free = shape.length - shape.clamp
    across = half * np.array([[1, 0], [1, 0.5], [1, -0.5], [1, 1], [0.5, 0], [0, 0], [-1, 0]])
    for share, part in ((0.0, 0.0), (0.075, 0.5), (0.5, 1.0), (1.0, 1.0)):
        places = np.column_stack([np.full(7, shape.clamp + share * free), across])
        out = 1e3 * (keeled.place(places) - shape.place(places))
        assert out[:, [0, 2]] == pytest.approx(0.0, abs=1e-12)
        assert out[:, 1] == pytest.approx(part * np.array([8.0, 4.0, 4.0, 0.0, 4.0, 0.0, 0.0]))


def test_a_ridge_is_a_prism_of_rubber(setup: Setup) -> None:
    more, whole = rubber_volumes(setup, Faults(keeled=6.0))
    free = setup.shape.length - setup.shape.clamp
    # A triangle over the height, which comes up over 15 % of the length.
    prism = 0.5 * 0.006 * setup.shape.section[1] * free * (1.0 - 0.5 * 0.15)
    assert more - whole == pytest.approx(prism, rel=0.15)


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_ridge_is_some_4_and_10_mm_high(family: str) -> None:
    drawn = draw_sealed(family)
    nodes = make_specimen(drawn, Faults(), COARSE).mesh.lattice
    for size, least, most in ((1, 3.3, 4.7), (2, 8.4, 11.6)):
        faults = _drawn('keeled', drawn, size)
        heights = 1e3 * np.linalg.norm(
            true_shape(drawn.shape, faults).place(nodes) - drawn.shape.place(nodes), axis=1
        )
        # What tapers tapers as a whole.
        assert (0.4 if family in ('fin', 'waist') else 1.0) * least < heights.max() < most
        more, whole = rubber_volumes(drawn, faults)
        assert whole < more < 1.6 * whole


@pytest.mark.parametrize(('size', 'most'), [(1, 4.0), (2, 10.0)])
def test_errors_go_round_as_a_spiral(
    setup: Setup, plain: Specimen, rests: list[np.ndarray], size: int, most: float
) -> None:
    faults = _drawn('spiralled', setup, size)
    assert faults.spiralled == pytest.approx(most, rel=0.16)
    for pose in range(4):
        view, right, there = with_and_without(plain, setup, faults, pose, rests[pose])
        rows, columns, _ = np.nonzero(there)
        ways = columns + right.column - setup.camera.cx - faults.spiralled_at[0] + 0j
        ways += 1j * (rows + right.row - setup.camera.cy - faults.spiralled_at[1])
        # A complex wave that turns once by each turn of the spiral, and once against the angle.
        turned = np.exp(2j * np.pi * np.abs(ways) / faults.spiralled_apart)
        expected = faults.spiralled * (turned * np.conj(ways) / np.abs(ways)).imag
        errors = 1e3 * (view.depth[there] - right.depth[there])
        assert errors == pytest.approx(expected, abs=1e-6)
        assert np.ptp(errors) > 1.5 * most


def test_nothing_errs_where_no_spiral_is_told(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    view, right, there = with_and_without(plain, setup, Faults(spiralled=0.0), 0, rests[0])
    assert np.array_equal(view.depth[there], right.depth[there])
