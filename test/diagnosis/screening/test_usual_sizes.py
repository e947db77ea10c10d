# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""An effect that is many times as large as usual costs little more than one that is usual."""

from diffcal_ros.diagnosis.screening.candidates import Candidate
from diffcal_ros.diagnosis.screening.screening import _as_large_as_seen, expected_amplitudes, gains
from diffcal_ros.diagnosis.screening.usual_sizes import likeliest_size, sized, SIZES
from diffcal_ros.effects.registry import EFFECTS
import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import halfcauchy, norm

DRAG = Candidate('air_drag', ('area',))
USUAL = EFFECTS['air_drag'].component('area').usual_size
NOISE = np.random.default_rng(4).standard_normal(40)


@pytest.mark.parametrize(
    ('amounts', 'size'),
    [
        ([0.0], 1.0),
        ([1.5], 1.0),
        ([-2.5], 3.0),
        ([20.0], 10.0),
        ([60.0], 30.0),
        ([1.5, -1.5, 1.5, 1.5], 1.0),
        ([0.0, 0.0, 6.0, -4.0], 3.0),
        ([1e4], 100.0),
    ],
)
def test_an_effect_is_as_large_as_it_is_likeliest(amounts, size):
    assert likeliest_size(np.array(amounts)) == size


@pytest.mark.parametrize('count', [1, 2, 6])
def test_sizes_grow_with_amounts_and_never_fall_below_the_usual_one(count):
    sizes = [likeliest_size(np.full(count, amount)) for amount in np.geomspace(0.01, 1e3, 60)]
    assert sizes == sorted(sizes)
    assert set(sizes) == set(SIZES)


@pytest.mark.parametrize('amount', [3.0, 12.0, 60.0])
def test_the_likeliest_size_costs_about_what_all_sizes_together_do(amount):
    """The price falls from the square to the logarithm: a half Cauchy mixture's, integrated."""
    size = likeliest_size(np.array([amount]))
    mixed, _ = quad(
        lambda s: norm.pdf(amount, scale=s) * 2.0 * halfcauchy.pdf(s) * (s >= 1.0),
        1.0,
        np.inf,
        limit=400,
    )
    found = norm.logpdf(amount, scale=size) + np.log(2.0 * halfcauchy.pdf(size) * size)
    assert found == pytest.approx(np.log(mixed), abs=0.8)
    assert norm.logpdf(amount) - found < (-1.0 if amount > 3.0 else 1.0)


def test_a_place_or_a_time_has_no_size():
    creep = Candidate('creep', ('share', 'tau'))
    assert sized(creep, {'creep.share': 0.0, 'creep.tau': 1e4}).size == 1.0
    share = EFFECTS['creep'].component('share').usual_size
    assert sized(creep, {'creep.share': 8.0 * share, 'creep.tau': 1.0}).size > 1.0
    plane = Candidate('contact_plane', tuple(p.name for p in EFFECTS['contact_plane'].components))
    assert sized(plane, dict.fromkeys(plane.names, 50.0)) is plane


def test_a_size_is_no_part_of_what_an_effect_is():
    large = sized(DRAG, {'air_drag.area': 60.0 * USUAL})
    assert (large.size, large == DRAG, len({large, DRAG})) == (30.0, True, 1)


def _seen(times: float, sigmas: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the column and the residuals of a drag that a usual one shows by some sigmas."""
    column = np.random.default_rng(3).standard_normal((40, 1))
    column *= sigmas / (USUAL * np.linalg.norm(column))
    return column, column[:, 0] * times * USUAL + NOISE


def test_a_large_effect_is_expected_as_large_as_it_is():
    column, residual = _seen(60.0, 1.0)
    (whole,) = np.linalg.lstsq(column, residual, rcond=None)[0]
    (shrunk,) = expected_amplitudes(DRAG, column, residual)
    large = _as_large_as_seen(DRAG, column, residual)
    (found,) = expected_amplitudes(large, column, residual)
    assert shrunk < 0.6 * whole
    assert found == pytest.approx(whole, rel=0.01)
    fall = float(residual @ residual - np.sum((residual - column[:, 0] * whole) ** 2))
    assert float(gains(DRAG, column, residual)) < 0.6 * fall
    assert fall - 5.0 < float(gains(large, column, residual)) < fall


def test_a_usual_effect_is_of_its_usual_size():
    column, residual = _seen(1.0, 10.0)
    assert _as_large_as_seen(DRAG, column, residual) is DRAG
