# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Models whose noise was not measured are ranked by what most patches say."""

from dataclasses import replace

from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects
from diffcal_ros.diagnosis.model_comparison.guessed_floor import (
    log_density,
    noise_scale,
    predicts_better,
)
from diffcal_ros.diagnosis.screening.shortlist import starts_of
import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from scipy.stats import t


def test_the_size_is_that_which_makes_residuals_likeliest(random):
    residuals = 0.002 * random.standard_t(4.0, size=80)
    sizes = np.geomspace(1e-4, 1e-1, 4000)
    levels = t.logpdf(residuals[:, None], 4.0, scale=sizes).sum(axis=0)
    constant = len(residuals) * t.logpdf(0.0, 4.0)
    assert log_density(residuals) == pytest.approx(levels.max() - constant, abs=0.02)


def test_a_model_in_other_units_of_length_has_the_same_lead(random):
    one, other = 0.001 * random.standard_normal(50), 0.003 * random.standard_normal(50)
    lead = log_density(one) - log_density(other)
    assert lead > 20.0
    assert log_density(5.0 * one) - log_density(5.0 * other) == pytest.approx(lead, abs=0.05)


def test_few_patches_that_are_far_off_do_not_decide(random):
    """One model meets nine tenths to a millimetre and misses the rest by 40; one is 5 mm off."""
    mostly_right = 0.001 * random.standard_normal(50)
    mostly_right[:5] = 0.04
    off = 0.005 * random.standard_normal(50)
    assert np.sum(mostly_right**2) > 3.0 * np.sum(off**2)
    assert log_density(mostly_right) > log_density(off) + 5.0


@pytest.mark.slow
def test_an_amplitude_is_as_sure_as_its_likeliest_values_spread(random):
    """Locations of the greatest likelihood, of samples of one size, against the Fisher figure."""
    size, count = 3.0, 60
    samples = size * random.standard_t(4.0, size=(600, count))
    found = [
        minimize_scalar(
            lambda place, own=own: -t.logpdf(own - place, 4.0, scale=size).sum(),
            bracket=(-1.0, 1.0),
        ).x
        for own in samples
    ]
    spread = count * np.var(found)
    assert noise_scale(samples.ravel()) == pytest.approx(spread, rel=0.15)


def test_few_patches_that_are_far_off_make_no_amplitude_less_sure(random):
    values = 2.0 * random.standard_normal(60)
    sure = noise_scale(values)
    values[:3] = 80.0
    assert noise_scale(values) < 2.0 * sure
    assert np.mean(values**2) > 50.0 * sure
    assert noise_scale(0.01 * values) == 1.0


@pytest.fixture(scope='module')
def fitted(screened):
    evaluator, nominal, scores = screened
    score = next(s for s in scores.scores if s.candidate.identifier == 'depth_affine')
    found = try_effects(evaluator, nominal, [score.candidate], starts_of(score))
    assert found is not None
    return found


def _with_residuals(model, fitted_by: float, held_out_by: float):
    """Return a model that leaves so many times as much on the patches of each part."""
    groups = []
    for group in model.fit.groups:
        factors = np.where(group.is_report, held_out_by, fitted_by)
        values = factors * group.patches.values
        groups.append(replace(group, patches=replace(group.patches, values=values)))
    return replace(model, fit=replace(model.fit, groups=groups))


def test_what_follows_the_fitted_patches_alone_predicts_worse(fitted):
    assert predicts_better(fitted, fitted) == 0.0
    better, overfit = _with_residuals(fitted, 0.5, 0.5), _with_residuals(fitted, 0.2, 1.0)
    gain = predicts_better(fitted, better)
    held_out = sum(int(g.is_report.sum()) for g in fitted.fit.groups if not g.is_rigid)
    assert gain == pytest.approx(held_out * np.log(2.0), rel=0.02)
    assert predicts_better(better, fitted) == pytest.approx(-gain)
    assert predicts_better(fitted, overfit) < -4.0
