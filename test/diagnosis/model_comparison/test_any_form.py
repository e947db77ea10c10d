# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The right effect of another form, against what explains just as well by chance."""

from dataclasses import replace

from diffcal_ros.diagnosis.model_comparison import any_form, form_places
from diffcal_ros.diagnosis.model_comparison.any_form import (
    led_by_form,
    Sight,
    Tolerated,
    tolerated,
)
from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects
from diffcal_ros.diagnosis.model_comparison.form_basis import FormBasis
from diffcal_ros.diagnosis.model_comparison.form_ways import Ways, ways_of
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_gap import patch_gap
from diffcal_ros.diagnosis.patches.patch_group import moved
from diffcal_ros.diagnosis.patches.regularised_prior import regularised_prior
from diffcal_ros.diagnosis.patches.whitened import Part, whiten
from diffcal_ros.diagnosis.screening.shortlist import starts_of
import numpy as np
import pytest


@pytest.fixture(scope='module')
def tilted(screened) -> Hypothesis:
    evaluator, nominal, scores = screened
    score = next(s for s in scores.scores if s.candidate.identifier == 'gravity_tilt')
    return try_effects(evaluator, nominal, [score.candidate], starts_of(score))


def _ways(hypothesis: Hypothesis, fit: Refit, basis: FormBasis) -> Ways:
    return ways_of(hypothesis.evaluator.model, fit, basis, hypothesis.added)


def _judge(hypothesis: Hypothesis, fit: Refit, basis: FormBasis) -> Tolerated:
    return tolerated(fit, _ways(hypothesis, fit, basis))


def _with(hypothesis: Hypothesis, more: list[np.ndarray]) -> Refit:
    """Return the fit as if the patches showed something besides."""
    fit = hypothesis.fit
    groups = [
        replace(b, patches=replace(b.patches, values=b.patches.values + own))
        for b, own in zip(fit.groups, more, strict=True)
    ]
    return replace(fit, groups=groups)


def _warped(hypothesis: Hypothesis, share: float) -> Refit:
    """Return the fit to an effect that grows from the clamp to the tip otherwise than its own."""
    fit, (own,) = hypothesis.fit, hypothesis.added
    places = [fit.parameters.names.index(name) for name in own.names]
    points = hypothesis.evaluator.model.views(fit.coordinates)
    more = []
    for group in fit.groups:
        along = form_places.along_body(
            hypothesis.evaluator.model, group, points[group.view].points
        )[:, 0]
        done = group.patches.jacobian[:, places] @ fit.coordinates[places]
        more.append(share * np.cos(np.pi * along) * done)
    return _with(hypothesis, more)


def test_the_exact_form_hardly_pays_and_is_not_doubted(tilted, basis):
    judged = _judge(tilted, tilted.fit, basis)
    assert judged.fraction < 0.05
    assert abs(judged.log_evidence - tilted.fit.log_evidence) < 5.0
    assert judged.exact == pytest.approx(tilted.fit.log_evidence, abs=0.1)


@pytest.mark.parametrize('share', [0.1, 0.2, 0.4])
def test_another_form_is_tolerated_as_far_as_it_is_off(tilted, basis, share):
    fit = _warped(tilted, share)
    judged, exact = _judge(tilted, fit, basis), _judge(tilted, tilted.fit, basis)
    # Cosines have a size of 0.7.
    assert 0.4 * share < judged.fraction < 2.5 * share
    assert judged.chi_square < 0.6 * whiten(fit.groups, Part.FIT).chi_square
    # On held-out patches it leaves no more than the exact form did where that was true.
    assert judged.left < 1.05 * patch_gap(tilted.fit.groups, Part.REPORT).rms
    # It pays for that, and what it predicts on other patches holds.
    assert judged.log_evidence < exact.log_evidence - 1.0
    assert judged.log_prediction > exact.log_prediction - 30.0


@pytest.mark.parametrize(('share', 'gain'), [(3.0, 5.0), (6.0, 10.0)])
def test_forms_explain_no_more_the_farther_off_a_model_stands(tilted, basis, share, gain):
    """Far-off patches count less, but not in a form that takes the model near them.

    The other route: the likeliest form leaves noise, and so no patch is counted less.
    """
    fit = _warped(tilted, share)
    ways = _ways(tilted, fit, basis)
    naive = whiten(ways.joined(fit.groups), Part.FIT)
    assert naive.has_far_off
    near = [
        replace(own, patches=replace(own.patches, left=np.zeros(len(own.patches.values))))
        for own in ways.joined(fit.groups)
    ]
    seen = whiten(near, Part.FIT)
    assert not seen.has_far_off
    expected = Sight.of(fit, seen, ways.pose_count).level()
    assert tolerated(fit, ways).log_evidence == pytest.approx(expected, abs=0.5)
    # Counted where the model stands, what no form takes near costs what others do not owe.
    assert Sight.of(fit, naive, ways.pose_count).level() < expected - gain


def test_what_no_form_takes_near_the_patches_is_as_good_as_in_its_own(tilted, basis):
    """Counted by what a form leaves of them patches may be farther off than they were."""
    far = [
        np.where(np.arange(len(own.patches.values)) % 2, 0.05, -0.05) for own in tilted.fit.groups
    ]
    judged = _judge(tilted, _with(tilted, far), basis)
    none = any_form.log_prior(any_form.OF_FORM)[0] + any_form.log_prior(any_form.BY_POSE)[0]
    assert judged.log_evidence >= judged.exact + none - 1e-9


def test_what_the_effect_does_not_move_is_not_tolerated(tilted, basis):
    # The same error of depth everywhere, at the clamp as well, where a tilt moves nothing.
    constant = [
        np.full(len(group.patches.values), 0.004 * (group.kind == 'depth'))
        for group in tilted.fit.groups
    ]
    judged, exact = (_judge(tilted, fit, basis) for fit in (_with(tilted, constant), tilted.fit))
    assert judged.log_evidence < exact.log_evidence - 50.0


@pytest.mark.parametrize(('share', 'fraction'), [(0.0, 0.1), (0.3, 0.0), (0.3, 0.2)])
def test_evidence_is_that_of_a_gaussian_with_all_ways_in_its_covariance(
    tilted, basis, share, fraction
):
    fit = _warped(tilted, 0.05)
    random = np.random.default_rng(3)
    ways = _ways(tilted, fit, basis)
    # One pose has no ways from pose to pose: some that say what columns do with them.
    by_pose = tuple(1e-3 * random.normal(size=(len(own), 3)) for own in ways.form)
    ways = replace(ways, by_pose=by_pose)
    seen = whiten(ways.joined(fit.groups), Part.FIT)
    found = Sight.of(fit, seen, ways.pose_count).densities(share, np.array([fraction]))

    count = len(fit.coordinates)
    own, free = seen.jacobian[:, :count], seen.jacobian[:, count:]
    mean, precision = regularised_prior(fit.parameters)
    offset = fit.coordinates - (mean - fit.shifts)
    # Of all that the priors of parameters and ways let the patches be.
    sizes = np.where(np.arange(free.shape[1]) < 3, share, fraction)
    covariance = np.eye(len(seen)) + own @ np.linalg.solve(precision, own.T)
    covariance += (free * sizes**2) @ free.T
    values = seen.values + own @ offset
    square = values @ np.linalg.solve(covariance, values)
    expected = -0.5 * (square + np.linalg.slogdet(covariance)[1] + seen.volume)
    assert found == pytest.approx([expected], rel=1e-6)
    assert seen.volume > 0.0


def test_what_is_found_is_the_mean_given_the_patches_and_what_it_leaves():
    random = np.random.default_rng(8)
    own, by_pose, form = (random.normal(size=(12, width)) for width in (4, 3, 5))
    values, root = random.normal(size=12), random.normal(size=(6, 4))
    sight = Sight(values, own, root, by_pose, form, np.zeros(12, int), *np.zeros((3, 12)))
    found = sight.at(0.3, 0.7)
    covariance = np.eye(12) + own @ own.T + 0.09 * by_pose @ by_pose.T + 0.49 * form @ form.T
    inverse = np.linalg.inv(covariance)
    told = inverse @ values
    expected = [root @ own.T @ told, 0.09 * by_pose.T @ told, 0.49 * form.T @ told]
    np.testing.assert_allclose(found.weights, np.concatenate(expected), rtol=1e-9)
    assert found.chi_square == pytest.approx(told @ told)
    assert found.freedom == pytest.approx(np.trace(inverse))


def test_a_brief_judgement_says_the_same_of_the_patches_that_were_fitted(tilted, basis):
    ways = _ways(tilted, tilted.fit, basis)
    brief, whole = tolerated(tilted.fit, ways, is_brief=True), tolerated(tilted.fit, ways)
    told, same = vars(whole), vars(brief)
    assert {name for name, value in same.items() if np.isnan(value).any()} == {
        'log_prediction',
        'left',
    }
    for name in told.keys() - {'log_prediction', 'left'}:
        np.testing.assert_array_equal(same[name], told[name])


def test_where_the_form_is_known_parameters_are_led_to_the_optimum(tilted, basis, monkeypatch):
    monkeypatch.setattr(any_form, 'OF_FORM', np.zeros(1))
    monkeypatch.setattr(any_form, 'BY_POSE', np.zeros(1))
    fit = tilted.fit
    step = np.linalg.cholesky(fit.covariance) @ np.linspace(-2.0, 2.0, len(fit.coordinates))
    aside = replace(fit, coordinates=fit.coordinates + step, groups=moved(fit.groups, step))
    led = led_by_form(aside, _ways(tilted, aside, basis))
    errors = np.sqrt(np.diag(fit.covariance))
    assert np.abs((led - fit.coordinates) / errors).max() < 0.1
    assert np.abs(step / errors).max() > 1.0, 'there was a way to go'


def test_a_free_form_leads_the_other_parameters_back(tilted, basis):
    """A form that is another one draws the modulus; known for what it is it lets go."""
    fit = _warped(tilted, 0.3)
    seen, (offset, precision) = whiten(fit.groups, Part.FIT), fit.prior_offset()
    information = seen.jacobian.T @ seen.jacobian + precision
    drawn = np.linalg.solve(information, seen.jacobian.T @ seen.values - precision @ offset)
    led = led_by_form(fit, _ways(tilted, fit, basis)) - fit.coordinates
    modulus = fit.parameters.names.index('youngs_modulus')
    assert abs(led[modulus]) < 0.5 * abs(drawn[modulus])


def test_the_process_has_size_one_and_is_smooth():
    places = np.linspace(0.0, 1.0, 41)[:, None]
    modes = form_places.interpolated(places, form_places.ALONG)
    covariance = modes @ modes.T
    assert np.allclose(covariance, form_places.kernel(places, places), atol=0.05)
