# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The right effect of a slightly other form, against what explains just as well by chance."""

from dataclasses import replace

from diffcal_ros.diagnosis.model_comparison import form_tolerance, form_ways
from diffcal_ros.diagnosis.model_comparison.form_tolerance import Tolerated, tolerated
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis, try_effects
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_group import PatchGroup
from diffcal_ros.diagnosis.patches.regularised_prior import regularised_prior
from diffcal_ros.diagnosis.patches.whitened import Part, whiten
from diffcal_ros.diagnosis.screening.shortlist import starts_of
import numpy as np
import pytest


@pytest.fixture(scope='module')
def tilted(screened) -> tuple[Hypothesis, Refit]:
    evaluator, nominal, scores = screened
    score = next(s for s in scores.scores if s.candidate.identifier == 'gravity_tilt')
    return try_effects(evaluator, nominal, [score.candidate], starts_of(score)), nominal


def _done(hypothesis: Hypothesis, nominal: Refit) -> list[np.ndarray]:
    return form_tolerance._done_by(hypothesis.fit, nominal)


def _with(hypothesis: Hypothesis, more: list[np.ndarray]) -> Refit:
    """Return the fit as if the patches showed something besides."""
    fit = hypothesis.fit
    groups = [
        replace(b, patches=replace(b.patches, values=b.patches.values + own))
        for b, own in zip(fit.groups, more, strict=True)
    ]
    return replace(fit, groups=groups)


def _warped(hypothesis: Hypothesis, nominal: Refit, share: float) -> Refit:
    """Return the fit to an effect that grows from the clamp to the tip otherwise than its own."""
    done = _done(hypothesis, nominal)
    points = hypothesis.evaluator.model.views(hypothesis.fit.coordinates)
    along = [
        form_ways.along_body(hypothesis.evaluator.model, group, points[group.view].points)[:, 0]
        for group in hypothesis.fit.groups
    ]
    more = [share * np.cos(2.0 * np.pi * s) * moved for s, moved in zip(along, done, strict=True)]
    return _with(hypothesis, more)


def _judge(hypothesis: Hypothesis, fit: Refit, nominal: Refit, group: str = 'load') -> Tolerated:
    model = hypothesis.evaluator.model
    points = [view.points for view in model.views(hypothesis.fit.coordinates)]
    return tolerated(model, fit, nominal, [group], points)


def test_the_exact_form_hardly_pays_and_is_not_doubted(tilted):
    hypothesis, nominal = tilted
    judged = _judge(hypothesis, hypothesis.fit, nominal)
    assert judged.fraction < 0.05
    assert abs(judged.log_evidence - hypothesis.fit.log_evidence) < 5.0


@pytest.mark.parametrize('share', [0.1, 0.2])
def test_another_form_is_tolerated_as_far_as_it_is_off(tilted, share):
    hypothesis, nominal = tilted
    fit = _warped(hypothesis, nominal, share)
    judged = _judge(hypothesis, fit, nominal)
    exact = _judge(hypothesis, hypothesis.fit, nominal)
    # Cosines have a size of 0.7.
    assert 0.4 * share < judged.fraction < 2.0 * share
    assert judged.chi_square < 0.2 * whiten(fit.groups, Part.FIT).chi_square
    # It pays for that, and what it predicts on other patches holds.
    assert judged.log_evidence < exact.log_evidence - 5.0
    assert judged.log_prediction > exact.log_prediction - 30.0


def test_what_the_effect_does_not_move_is_not_tolerated(tilted):
    hypothesis, nominal = tilted
    # The same error of depth everywhere, at the clamp as well, where a tilt moves nothing.
    constant = [
        np.full(len(group.patches.values), 0.004 * (group.kind == 'depth'))
        for group in hypothesis.fit.groups
    ]
    judged = _judge(hypothesis, _with(hypothesis, constant), nominal)
    exact = _judge(hypothesis, hypothesis.fit, nominal)
    assert judged.log_evidence < exact.log_evidence - 50.0


@pytest.mark.parametrize('place', [1, 3])
def test_evidence_is_that_of_a_gaussian_with_the_process_in_its_covariance(
    tilted, monkeypatch, place
):
    hypothesis, nominal = tilted
    fit = _warped(hypothesis, nominal, 0.05)
    share = form_tolerance._FRACTIONS[place]
    monkeypatch.setattr(form_tolerance, '_FRACTIONS', np.array([0.0, share]))
    done = _done(hypothesis, nominal)
    model = hypothesis.evaluator.model
    points = [view.points for view in model.views(fit.coordinates)]
    places = form_ways.places_of(model, fit.groups, points)
    ways = form_tolerance._ways(['load'], done, places)
    wide = [_with_columns(group, way) for group, way in zip(fit.groups, ways, strict=True)]
    found = form_tolerance._levels(fit, wide, Part.FIT).levels

    seen = whiten(wide, Part.FIT)
    count = len(fit.coordinates)
    own, more = seen.jacobian[:, :count], seen.jacobian[:, count:]
    mean, precision = regularised_prior(fit.parameters)
    offset = fit.coordinates - (mean - fit.shifts)
    # Of all that the priors of the parameters and of the process let the patches be.
    plain = np.eye(len(seen)) + own @ np.linalg.solve(precision, own.T)
    values = seen.values + own @ offset
    expected = []
    for size in (0.0, share):
        covariance = plain + size**2 * more @ more.T
        square = values @ np.linalg.solve(covariance, values)
        expected.append(-0.5 * (square + np.linalg.slogdet(covariance)[1]))
    assert found == pytest.approx(expected, rel=1e-6)


def _with_columns(group: PatchGroup, columns: np.ndarray) -> PatchGroup:
    jacobian = np.hstack([group.patches.jacobian, columns])
    return replace(group, patches=replace(group.patches, jacobian=jacobian))


def test_the_process_has_size_one_and_is_smooth():
    places = np.linspace(0.0, 1.0, 41)[:, None]
    modes = form_ways.interpolated(places, form_ways.ALONG)
    covariance = modes @ modes.T
    assert np.allclose(covariance, form_ways.kernel(places, places), atol=0.05)
