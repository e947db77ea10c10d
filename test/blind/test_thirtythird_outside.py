# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the thirty-third set has do what their labels say."""

import numpy as np
import pytest
from support.blind_draws import draw_sealed, SEALED
from support.blind_rests import COARSE, rubber_volumes
from support.blind_views import spread_of_what_stays, with_and_without

from benchmarks.blind.cases import list_form_cases
from benchmarks.blind.faults import Faults
from benchmarks.blind.rest_shape import true_shape
from benchmarks.blind.setups import Setup
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.thirtythird_outside import THIRTYTHIRD_OUTSIDE


def _drawn(name: str, setup: Setup, size: int = 2) -> Faults:
    return Faults(**THIRTYTHIRD_OUTSIDE[name](size, setup, np.random.default_rng(8)).changes)


def test_each_cause_is_there_once() -> None:
    causes = [case for case in list_form_cases('thirtythird', 'salt') if case.kind == 'outside']
    assert sorted(case.effects for case in causes) == [
        ((name, 2),) for name in sorted(THIRTYTHIRD_OUTSIDE)
    ]
    assert len({(case.family, case.law, case.sensor) for case in causes}) == 3


def test_a_bevelled_body_lacks_rubber_along_one_edge(setup: Setup) -> None:
    shape, half = setup.shape, 0.5 * np.array(setup.shape.section)
    bevelled = true_shape(shape, Faults(bevelled=6.0))
    free = shape.length - shape.clamp
    across = half * np.array([[1, 1], [0.5, 1], [0, 1], [1, 0.5], [1, 0], [0.5, 0.5], [-1, -1]])
    for share, part in ((0.0, 0.0), (0.075, 0.5), (0.5, 1.0), (1.0, 1.0)):
        places = np.column_stack([np.full(7, shape.clamp + share * free), across])
        down = 1e3 * (shape.place(places) - bevelled.place(places))
        assert down[:, :2] == pytest.approx(0.0, abs=1e-12)
        assert down[:, 2] == pytest.approx(part * np.array([6.0, 3.0, 0.0, 3.0, 0.0, 1.5, 0.0]))


def test_what_is_planed_off_is_a_prism(setup: Setup) -> None:
    left, whole = rubber_volumes(setup, Faults(bevelled=6.0))
    free = setup.shape.length - setup.shape.clamp
    # A triangle over half the width, which comes up over 15 % of the length.
    prism = 0.5 * 0.006 * 0.5 * setup.shape.section[0] * free * (1.0 - 0.5 * 0.15)
    assert whole - left == pytest.approx(prism, rel=0.15)


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_as_much_is_planed_off_as_half_the_height_lets(family: str) -> None:
    drawn = draw_sealed(family)
    nodes = make_specimen(drawn, Faults(), COARSE).mesh.lattice
    faults = _drawn('bevelled', drawn)
    lower = 1e3 * np.linalg.norm(
        true_shape(drawn.shape, faults).place(nodes) - drawn.shape.place(nodes), axis=1
    )
    most = min(10.0, 400.0 * drawn.shape.section[1])
    assert faults.bevelled == pytest.approx(most, rel=0.16)
    # What tapers tapers as a whole.
    assert (0.35 if family in ('fin', 'waist') else 0.8) * most < lower.max() < 1.16 * most
    left, whole = rubber_volumes(drawn, faults)
    assert 0.7 * whole < left < whole


def test_errors_rise_over_each_strip_and_fall_back(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    faults, told = _drawn('sawtoothed', setup), dict[tuple[int, int], float]()
    assert faults.sawtoothed == pytest.approx(10.0, rel=0.16)
    for pose in range(4):
        view, right, there = with_and_without(plain, setup, faults, pose, rests[pose])
        _, columns, _ = np.nonzero(there)
        into = (columns + right.column - faults.sawtoothed_from) / faults.sawtoothed_strip
        expected = faults.sawtoothed * (2.0 * (into - np.floor(into)) - 1.0)
        errors = 1e3 * (view.depth[there] - right.depth[there])
        assert errors == pytest.approx(expected, abs=1e-6)
        assert spread_of_what_stays((view, right, there), told) > 15.0


def test_fringes_close_up_away_from_a_column(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    faults, told = _drawn('chirped', setup), dict[tuple[int, int], float]()
    assert faults.chirped == pytest.approx(10.0, rel=0.16)
    for pose in range(4):
        view, right, there = with_and_without(plain, setup, faults, pose, rests[pose])
        _, columns, _ = np.nonzero(there)
        ways = columns + right.column - setup.camera.cx - faults.chirped_at
        # Its phase is the integral of a rate that grows with the way.
        phases = 4.0 * np.pi / faults.chirped_wave**2 * 0.5 * ways**2
        errors = 1e3 * (view.depth[there] - right.depth[there])
        assert errors == pytest.approx(faults.chirped * np.sin(phases), abs=1e-6)
        assert spread_of_what_stays((view, right, there), told) > 12.0


def test_nothing_errs_where_no_strip_or_fringe_is_told(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    none = Faults(sawtoothed=0.0, chirped=0.0, bevelled=0.0)
    view, right, there = with_and_without(plain, setup, none, 0, rests[0])
    assert np.array_equal(view.depth[there], right.depth[there])
