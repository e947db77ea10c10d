# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library of the set `swings_three` do what their labels say."""

from dataclasses import replace

import numpy as np
import pytest
from support.blind_draws import STEPS
from support.blind_swings import moves_by_size, soft_beam

from benchmarks.blind.faults import Faults
from benchmarks.blind.filming import positions_at
from benchmarks.blind.gust import blowing, with_gust
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.ripples import fringes, rippled
from benchmarks.blind.setups import draw_setup, Setup
from benchmarks.blind.shutter import filmed_views
from benchmarks.blind.simulation import make_specimen, Specimen
from benchmarks.blind.smoothing import on_window
from benchmarks.blind.stamping import moments
from benchmarks.blind.swings_three_outside import SWINGS_THREE_OUTSIDE
from benchmarks.blind.timing import draw_swing

GUST = Faults(gust=0.02, gust_from=0.03, gust_time=0.05, gust_way=(0.0, 0.6, -0.8))
RIPPLES = Faults(rippled=20.0, ripple_period=36.0, ripple_phase=0.7)


@pytest.fixture(scope='module')
def setup() -> Setup:
    return soft_beam()


@pytest.fixture(scope='module')
def specimen(setup: Setup) -> Specimen:
    return make_specimen(setup, Faults(), refinement=0.5)


def test_a_gust_comes_and_goes_without_a_jolt() -> None:
    times = np.linspace(0.0, 0.12, 2401)
    blown = np.array([blowing(GUST, time) for time in times])
    is_blowing = (times > 0.03) & (times < 0.08)
    assert np.array_equal(blown > 0.0, is_blowing)
    assert blown.max() == pytest.approx(1.0, abs=1e-6)
    assert times[blown.argmax()] == pytest.approx(0.055, abs=1e-4)
    assert np.trapezoid(blown, times) == pytest.approx(0.5 * 0.05, rel=1e-6)
    assert np.abs(np.diff(blown)).max() < 1.01 * np.pi / 0.05 * (times[1] - times[0])


@pytest.mark.parametrize('step', STEPS)
def test_a_gusts_push_is_the_slope_of_its_work(specimen: Specimen, step: float) -> None:
    """Of the mean move of the free surface along its way: what is held feels nothing."""
    changing = with_gust(None, specimen, GUST)
    assert changing is not None
    pushed, free = changing(0.045), specimen.areas * (specimen.shares > 0.0)
    move = np.random.default_rng(3).standard_normal(specimen.mesh.nodes.shape)

    def work(places: np.ndarray) -> float:
        mean = np.average(places - specimen.mesh.nodes, axis=0, weights=free)
        return 0.02 * float(np.sin(0.3 * np.pi) ** 2 * (mean @ np.array([0.0, 0.6, -0.8])))

    one, other = (work(specimen.mesh.nodes + way * step * move) for way in (1.0, -1.0))
    assert float((pushed * move).sum()) == pytest.approx((one - other) / (2.0 * step), rel=1e-4)
    assert not pushed[specimen.shares == 0.0].any()


def test_a_gust_blows_beside_what_else_acts(specimen: Specimen) -> None:
    def other(time: float) -> np.ndarray:
        return np.full(specimen.mesh.nodes.shape, time)

    assert with_gust(other, specimen, Faults()) is other
    assert with_gust(None, specimen, Faults()) is None
    both, alone = with_gust(other, specimen, GUST), with_gust(None, specimen, GUST)
    assert both is not None
    assert alone is not None
    np.testing.assert_allclose(both(0.05) - alone(0.05), 0.05)


def test_a_gust_moves_a_body_its_way_and_not_before_it_blows(
    setup: Setup, specimen: Specimen
) -> None:
    timing, times = draw_swing(np.random.default_rng(2)), [-0.1, 0.02, 0.045, 0.06]
    blown, quiet = (
        positions_at(specimen, setup, setup.observations[0], each, timing, times)
        for each in (GUST, Faults())
    )
    moved = np.array(blown) - np.array(quiet)
    assert not moved[:2].any()
    end = specimen.shares > 0.99
    along = (moved[:, end] @ np.array(GUST.gust_way)).mean(axis=1)
    assert along[2] > 1e-5
    assert along[3] > 2.0 * along[2]
    # Both of its parts are there: a bar of about even sides goes the way that it is pushed.
    assert moved[3, end, 1].mean() > 0.3 * along[3]
    assert moved[3, end, 2].mean() < -0.4 * along[3]


def _going(time: float, row: int = 30) -> Rendering:
    """Return a view of a slanted wall whose pixels go by speeds and accelerations of their own."""
    rows, columns = np.mgrid[row : row + 6, 100:180]
    depth = 0.3 + 1e-3 * rows + (0.5 - 0.01 * (columns - 100)) * time + 3.0 * time**2
    whole = np.repeat(depth[..., None], 9, axis=2)
    whole[0, 5], whole[3, 70] = np.inf, np.inf
    return Rendering(100, row, whole, np.ones(whole.shape, dtype=np.int64), np.ones(whole.shape))


@pytest.mark.parametrize('near', [1e-2, 1e-3, 1e-4])
def test_a_depth_errs_by_its_slope_over_the_time_in_stripes(near: float) -> None:
    views = [_going(time) for time in (-near, 0.0, near)]
    columns, is_seen = np.arange(100, 180), np.isfinite(views[1].depth)
    error = rippled(views, near, RIPPLES).depth[is_seen] - views[1].depth[is_seen]
    rates = 0.5 - 0.01 * (columns - 100)
    expected = 0.02 * rates * np.sin(2.0 * np.pi * columns / 36.0 + 0.7)
    whole = np.broadcast_to(expected[:, None], is_seen.shape)
    np.testing.assert_allclose(error, whole[is_seen], atol=1e-9)
    assert expected.max() > 5e-3
    assert expected.min() < -5e-3
    assert fringes(np.array([136.0]), RIPPLES) == pytest.approx(
        fringes(np.array([100.0]), RIPPLES)
    )


def test_what_is_seen_for_a_moment_alone_does_not_err() -> None:
    before, then, after = _going(-1e-3, 32), _going(0.0), _going(1e-3)
    shown = rippled([before, then, after], 1e-3, RIPPLES).depth
    # The first two rows of what is there now were not there before.
    assert np.array_equal(shown[:2], then.depth[:2])
    is_seen = np.isfinite(then.depth[2:])
    assert np.abs(shown[2:][is_seen] - then.depth[2:][is_seen]).max() > 5e-3


def test_ripples_are_there_as_long_as_a_body_moves(setup: Setup, specimen: Specimen) -> None:
    timing = replace(draw_swing(np.random.default_rng(2)), release=0.02, frame_count=2)
    errs, quiet = (
        filmed_views(specimen, setup, setup.observations[0], each, timing)
        for each in (RIPPLES, Faults())
    )
    for number, when in enumerate(moments(timing, Faults())):
        one, two = on_window(errs[number], quiet[number]), quiet[number].depth
        both = np.isfinite(one) & np.isfinite(two)
        off = one[both] - two[both]
        assert (off.max() > 2e-4) == (when > 0.0)
        assert (off.min() < -2e-4) == (when > 0.0)


@pytest.mark.parametrize(('family', 'most'), [('beam', (0.6, 1.0)), ('fin', (0.2, 0.35))])
def test_a_gust_blows_in_a_swing_and_across_what_is_flat(
    family: str, most: tuple[float, float]
) -> None:
    drawn = draw_setup(family, is_sealed=True, poses=1, random=np.random.default_rng(5))
    aside = []
    for seed in range(10):
        effect = SWINGS_THREE_OUTSIDE['gust'](2, drawn, np.random.default_rng(seed))
        faults = Faults(**effect.changes)
        assert faults.gust_from > 0.0
        assert faults.gust_from + faults.gust_time < 0.27
        assert np.linalg.norm(faults.gust_way) == pytest.approx(1.0, abs=1e-5)
        aside.append(abs(faults.gust_way[1]))
    assert most[0] < max(aside) < most[1]


@pytest.mark.slow
def test_sizes_of_a_gust_are_seen_and_only_in_a_motion() -> None:
    drawn = draw_setup('beam', is_sealed=True, poses=1, random=np.random.default_rng(5))
    timing = draw_swing(np.random.default_rng(2))
    moves = moves_by_size(drawn, SWINGS_THREE_OUTSIDE['gust'], timing)
    assert 1.0 < moves[0] < 7.0
    assert 1.5 < moves[1] / moves[0] < 3.0
