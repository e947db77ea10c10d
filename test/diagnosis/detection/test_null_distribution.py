# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The chance of clean data is one: data drawn from the floors get it evenly from 0 to 1."""

from dataclasses import replace

from diffcal_ros.diagnosis.detection.null_distribution import chance_of_clean
from diffcal_ros.diagnosis.screening.screening import gains
import numpy as np
import pytest
from scipy.stats import kstest

_CASES = 200
# Even numbers would fail so rarely by bad luck.
_LEAST_CHANCE = 0.001


@pytest.fixture
def smooth(screened):
    """The fit and its screen without contact, which has no chi-square of its own."""
    _, fit, screen = screened
    scores = tuple(s for s in screen.scores if s.candidate.identifier != 'contact_plane')
    return fit, replace(screen, scores=scores, noise_scale=1.0)


@pytest.mark.slow
def test_clean_data_get_even_chances(smooth, random):
    fit, screen = smooth
    found = []
    for _ in range(_CASES):
        noise = screen.project(random.standard_normal(screen.patch_count))
        scores = tuple(
            replace(score, plain_gain=float(gains(score.candidate, score.plain_columns, noise)))
            for score in screen.scores
        )
        clean = replace(screen, scores=scores)
        chi_square = float(noise @ noise)
        found.append(chance_of_clean(replace(fit, chi_square=chi_square), clean, draws=500))
    assert kstest(found, 'uniform').pvalue > _LEAST_CHANCE


def test_many_looks_are_paid_for(smooth):
    """The best of many scores is less of a surprise than its own chi-square says."""
    fit, screen = smooth
    calm = replace(fit, chi_square=0.5 * fit.patch_count)
    quiet = [replace(score, plain_gain=0.0) for score in screen.scores]
    loud = replace(quiet[0], plain_gain=9.0)
    one = replace(screen, scores=(loud,))
    many = replace(screen, scores=(loud, *quiet[1:]))
    assert chance_of_clean(calm, one) < chance_of_clean(calm, many)


def test_chances_beyond_the_draws_are_bounded_by_the_looks(screened):
    _, fit, screen = screened
    far = replace(fit, chi_square=50.0 * fit.patch_count)
    assert 0.0 <= chance_of_clean(far, screen) < 1e-12
    assert np.isfinite(chance_of_clean(fit, screen))


def test_errors_that_are_larger_make_the_same_residuals_likelier(smooth):
    """As if residuals were so many times smaller."""
    fit, screen = smooth
    off = replace(fit, chi_square=3.0 * fit.patch_count)
    scores = tuple(replace(score, plain_gain=40.0) for score in screen.scores)
    less = tuple(replace(score, plain_gain=40.0 / 2.25) for score in screen.scores)
    stated = chance_of_clean(off, replace(screen, scores=scores))
    doubted = chance_of_clean(off, replace(screen, scores=scores), misstated=1.5)
    assert stated < 1e-6 < doubted
    smaller = replace(off, chi_square=off.chi_square / 2.25)
    assert doubted == chance_of_clean(smaller, replace(screen, scores=less))


def test_what_nothing_explains_is_no_larger_where_errors_are(smooth):
    """It is there once: where larger errors leave as much, and where they leave less."""
    fit, screen = smooth
    calm = replace(fit, chi_square=0.5 * fit.patch_count)
    scores = tuple(replace(score, plain_gain=90.0) for score in screen.scores)

    def chance(noise_scale, misstated):
        left = replace(screen, scores=scores, noise_scale=noise_scale)
        return chance_of_clean(calm, left, misstated=misstated)

    assert chance(5.0, 2.0) == chance(5.0, 1.0) > chance(4.0, 1.0)
    assert chance(3.0, 2.0) == chance(1.0, 2.0) == chance(4.0, 1.0) > chance(3.0, 1.0)
