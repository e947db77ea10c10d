# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the thirtieth set has do what their labels say."""

import numpy as np
import pytest
from support.blind_draws import draw_sealed, SEALED
from support.blind_rests import COARSE, rubber_volumes, tip_moves
from support.blind_views import spread_of_what_stays, with_and_without

from benchmarks.blind.faults import Faults
from benchmarks.blind.rest_shape import true_shape
from benchmarks.blind.setups import Setup
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.thirtieth_outside import THIRTIETH_OUTSIDE


def _drawn(name: str, setup: Setup, size: int = 2) -> Faults:
    return Faults(**THIRTIETH_OUTSIDE[name](size, setup, np.random.default_rng(8)).changes)


def test_an_underfilled_body_lacks_a_wedge_of_its_upper_side(setup: Setup) -> None:
    shape, half = setup.shape, 0.5 * np.array(setup.shape.section)
    lacking = true_shape(shape, Faults(underfilled=0.6))
    free = shape.length - shape.clamp
    across = half * np.array([[1, 1], [-1, 1], [0.3, 0], [-1, -1], [1, -1]])
    for share in (0.0, 0.3, 0.7, 1.0):
        places = np.column_stack([np.full(5, shape.clamp + share * free), across])
        before, after = shape.place(places), lacking.place(places)
        assert after[:, :2] == pytest.approx(before[:, :2])
        lowered = (before[:, 2] - after[:, 2]) / (2.0 * half[1])
        assert lowered == pytest.approx(0.6 * share * np.array([1, 1, 0.5, 0, 0]), abs=1e-9)


def test_an_underfilled_beam_has_less_rubber(setup: Setup) -> None:
    less, whole = rubber_volumes(setup, Faults(underfilled=0.5))
    width, height = setup.shape.section
    free = (setup.shape.length - setup.shape.clamp) * width * height
    assert whole - less == pytest.approx(0.5 * 0.5 * free, rel=1e-6)


def _lowered(drawn: Setup, faults: Faults) -> float:
    """Return by how much a place of the tip lies lower at most [mm]."""
    nodes = make_specimen(drawn, Faults(), COARSE).mesh.lattice
    tip = nodes[nodes[:, 0] > nodes[:, 0].max() - 1e-9]
    placed = [true_shape(drawn.shape, each).place(tip) for each in (Faults(), faults)]
    return float(1e3 * np.linalg.norm(placed[1] - placed[0], axis=1).max())


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_an_underfilled_tip_is_lower_by_some_4_and_10_mm(family: str) -> None:
    drawn = draw_sealed(family)
    plain = make_specimen(drawn, Faults(), COARSE)
    for size, least, most in ((1, 3.3, 4.7), (2, 5.5, 11.7)):
        faults = _drawn('underfilled', drawn, size)
        assert least < _lowered(drawn, faults) < most
        # What is lighter and softer goes elsewhere by less than that.
        moves = tip_moves(drawn, plain, faults, plain.shares > 0.99)
        assert 0.2 * least < 1e3 * max(moves) < most


@pytest.mark.parametrize(('size', 'most'), [(1, 4.0), (2, 10.0)])
def test_a_window_waves_about_a_place(
    setup: Setup, plain: Specimen, rests: list[np.ndarray], size: int, most: float
) -> None:
    faults, told = _drawn('spoked', setup, size), dict[tuple[int, int], float]()
    assert faults.spoked == pytest.approx(most, rel=0.16)
    spreads = []
    for pose in range(2):
        view, right, there = with_and_without(plain, setup, faults, pose, rests[pose])
        rows, columns, _ = np.nonzero(there)
        ways = columns + right.column - setup.camera.cx - faults.spoked_at[0] + 0j
        ways += 1j * (rows + right.row - setup.camera.cy - faults.spoked_at[1])
        # As a power of a complex number, far enough from the place itself.
        far = np.abs(ways) > 1.0
        waves = (ways[far] / np.abs(ways[far])) ** faults.spoked_count
        expected = faults.spoked * (waves * np.exp(1j * faults.spoked_phase)).real
        errors = 1e3 * (view.depth[there] - right.depth[there])
        assert errors[far] == pytest.approx(expected, abs=1e-6)
        spreads.append(spread_of_what_stays((view, right, there), told))
    assert 1.2 * most < max(spreads) < 2.4 * most
    assert len(told) > 50
