# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The fit of a smaller model, told from a larger one's, is the one that is found by fitting."""

from dataclasses import replace

from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects, with_fewer_effects
from diffcal_ros.diagnosis.patch_fits.fewer_parameters import fitted_with_fewer
from diffcal_ros.diagnosis.patch_fits.refit import refit
from diffcal_ros.diagnosis.screening.candidates import candidates
import numpy as np
import pytest


@pytest.fixture(scope='module')
def variants(too_far):
    evaluator, _ = too_far
    listed = [c for c in candidates(evaluator.model.scene) if c.identifier == 'depth_affine']
    by_count = sorted(listed, key=lambda candidate: len(candidate.components))
    return by_count[0], by_count[-1]


@pytest.fixture(scope='module')
def whole(too_far, variants):
    evaluator, nominal = too_far
    return try_effects(evaluator, nominal, [variants[1]], {})


def test_it_is_the_larger_ones_posterior_given_that_amplitudes_are_zero(too_far, variants, whole):
    evaluator, nominal = too_far
    # At the very bottom, where the posterior is known: fits rest a little before it.
    bottom = replace(whole, fit=fitted_with_fewer(whole.fit, whole.evaluator))
    told = with_fewer_effects(evaluator, nominal, bottom, [variants[0]]).fit
    names, covariance = bottom.fit.parameters.names, bottom.fit.covariance
    kept = [names.index(name) for name in told.parameters.names]
    gone = np.setdiff1d(np.arange(len(names)), kept)
    assert len(gone) == 1
    across, own = covariance[np.ix_(kept, gone)], covariance[np.ix_(gone, gone)]
    zeroed = bottom.fit.coordinates[gone]
    expected = bottom.fit.coordinates[kept] - across @ np.linalg.solve(own, zeroed)
    np.testing.assert_allclose(told.coordinates, expected, rtol=1e-6, atol=1e-9)
    given = covariance[np.ix_(kept, kept)] - across @ np.linalg.solve(own, across.T)
    np.testing.assert_allclose(told.covariance, given, rtol=1e-5, atol=1e-14)
    rise = told.chi_square + told.prior_chi_square
    rise -= bottom.fit.chi_square + bottom.fit.prior_chi_square
    assert rise == pytest.approx(float(zeroed @ np.linalg.solve(own, zeroed)), rel=1e-5)


def test_without_an_amplitude_it_is_what_a_fit_without_it_finds(too_far, variants, whole):
    evaluator, nominal = too_far
    part, _ = variants
    told = with_fewer_effects(evaluator, nominal, whole, [part])
    found = try_effects(evaluator, nominal, [part], {})
    assert told.added == (part,)
    assert told.fit.parameters.names == found.fit.parameters.names
    # Fits come to rest where steps are worth a twentieth; the nominal one lost 60.
    assert told.log_evidence == pytest.approx(found.log_evidence, abs=1.0)
    assert found.log_evidence > nominal.log_evidence + 10.0
    errors = np.sqrt(np.diag(found.fit.covariance))
    assert (np.abs(told.fit.coordinates - found.fit.coordinates) < 0.5 * errors).all()
    np.testing.assert_allclose(np.sqrt(np.diag(told.fit.covariance)), errors, rtol=0.02)


@pytest.mark.parametrize('height', [-0.3, -1.0])
@pytest.mark.slow_but_first
def test_a_plane_that_touches_nowhere_stays(too_far, height):
    evaluator, nominal = too_far
    listed = candidates(evaluator.model.scene)
    plane = next(c for c in listed if c.effect.components[0].name == 'height')
    (name, *_) = plane.names
    beside = try_effects(evaluator, nominal, [plane], {}, max_iterations=1)
    here = beside.fit.coordinates.copy()
    place = beside.fit.parameters.names.index(name)
    here[place] = height
    below = refit(beside.evaluator, here, max_iterations=1)
    told = fitted_with_fewer(below, beside.evaluator)
    assert told.coordinates[place] == height
    assert told.log_evidence >= below.log_evidence - 0.1, 'all others have gone on'


def test_a_model_with_more_is_refused(too_far, whole):
    _, nominal = too_far
    with pytest.raises(ValueError, match=r'lacks .*depth_affine'):
        fitted_with_fewer(nominal, whole.evaluator)
