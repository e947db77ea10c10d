# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A second effect is one that no form of the first explains, in every pose."""

from collections.abc import Sequence
from dataclasses import replace

from diffcal_ros.diagnosis.model_comparison import second_effect
from diffcal_ros.diagnosis.model_comparison.absence import has_doubtful_effect
from diffcal_ros.diagnosis.model_comparison.choice import choose
from diffcal_ros.diagnosis.model_comparison.form_tolerance import Tolerated
from diffcal_ros.diagnosis.model_comparison.form_ways import Places, places_of
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis, try_effects
from diffcal_ros.diagnosis.model_comparison.second_effect import Explained, explained
from diffcal_ros.diagnosis.model_comparison.selection import Selection
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.screening.candidates import Candidate
from diffcal_ros.diagnosis.screening.shortlist import starts_of
import numpy as np
import pytest
from scipy.stats import multivariate_normal

# How far the body of each pose moves by the same tilt: no pose is like another.
_POSES = (1.0, -0.6, 1.4)


def _found(screened, *names: str) -> Hypothesis:
    evaluator, nominal, scores = screened
    added = [next(s for s in scores.scores if s.candidate.identifier == name) for name in names]
    return try_effects(evaluator, nominal, [s.candidate for s in added], starts_of(added[0]))


@pytest.fixture(scope='module')
def tilted(screened) -> Hypothesis:
    return _found(screened, 'gravity_tilt')


@pytest.fixture(scope='module')
def pair(screened) -> Hypothesis:
    return _found(screened, 'gravity_tilt', 'depth_affine')


def _slopes(fit: Refit, own: Candidate) -> list[np.ndarray]:
    """Return what an effect's amplitudes do to the patches of each group [m]."""
    places = [fit.parameters.names.index(name) for name in own.names]
    return [g.patches.jacobian[:, places] @ fit.coordinates[places] for g in fit.groups]


def _in_poses(
    hypothesis: Hypothesis, amounts: Sequence[float], more: float = 0.0
) -> tuple[Refit, list[Places]]:
    """Return a fit of several poses, and where their patches are.

    Args:
        hypothesis: in one pose; its first effect does another share of that in each.
        amounts: of that effect in each pose beyond its amplitude, as shares of it.
        more: bias of depth in all poses that no model has [m].
    """
    fit, first = hypothesis.fit, hypothesis.added[0]
    points = [view.points for view in hypothesis.evaluator.model.views(fit.coordinates)]
    columns = [fit.parameters.names.index(name) for name in first.names]
    slopes, here = _slopes(fit, first), places_of(hypothesis.evaluator.model, fit.groups, points)
    groups, places = [], []
    for view, (share, amount) in enumerate(zip(_POSES, amounts, strict=True)):
        for group, slope, place in zip(fit.groups, slopes, here, strict=True):
            jacobian = group.patches.jacobian.copy()
            jacobian[:, columns] *= share
            values = group.patches.values - amount * share * slope
            values = values + more * (group.kind == 'depth')
            patches = replace(group.patches, jacobian=jacobian, values=values)
            groups.append(replace(group, view=view, recording=view, patches=patches))
            places.append(replace(place, view=view, view_count=len(_POSES)))
    return replace(fit, groups=groups), places


def _adds(pair: Hypothesis, amounts: Sequence[float], bias: float) -> Explained:
    fit, places = _in_poses(pair, amounts, bias)
    both = explained(fit, pair.added, pair.added, places)
    alone = [explained(fit, pair.added, [own], places, in_any_form=True) for own in pair.added]
    return both.above(alone)


def test_without_tolerances_it_is_the_evidence_of_the_fit(tilted, monkeypatch):
    monkeypatch.setattr(second_effect, '_OF_FORM', np.zeros(1))
    monkeypatch.setattr(second_effect, '_BY_POSE', np.zeros(1))
    fit = tilted.fit
    points = [view.points for view in tilted.evaluator.model.views(fit.coordinates)]
    places = places_of(tilted.evaluator.model, fit.groups, points)
    found = explained(fit, tilted.added, tilted.added, places)
    # The fit came to rest: what is left of its slope is worth a few hundredths.
    assert found.log_evidence == pytest.approx(fit.log_evidence, abs=0.1)
    assert found.log_transfer == 0.0, 'a single pose tells nothing of others'


def test_transfer_is_the_density_of_each_pose_given_the_others(monkeypatch):
    monkeypatch.setattr(second_effect, '_OF_FORM', np.array([0.3]))
    monkeypatch.setattr(second_effect, '_BY_POSE', np.array([0.5]))
    random = np.random.default_rng(4)
    known, by_pose, form = (a @ a.T for a in random.normal(size=(3, 9, 6)))
    views = np.array([0, 1, 2, 0, 1, 2, 2, 1, 0])
    values = random.normal(size=9)
    sight = second_effect._Sight(values, known + np.eye(9), by_pose, form, views)
    covariance = known + np.eye(9) + 0.25 * by_pose + 0.09 * form
    for view in range(3):
        own, others = views == view, views != view
        gain = covariance[np.ix_(own, others)] @ np.linalg.inv(covariance[np.ix_(others, others)])
        spread = covariance[np.ix_(own, own)] - gain @ covariance[np.ix_(others, own)]
        expected = multivariate_normal.logpdf(values[own], gain @ values[others], spread)
        found = sight.level() - sight.without(view).level()
        assert found == pytest.approx(expected + 1.5 * np.log(2.0 * np.pi))


@pytest.mark.parametrize('bias', [0.0, 0.003])
def test_a_second_effect_that_is_there_is_seen_beside_the_first(pair, bias):
    added = _adds(pair, (0.0, 0.0, 0.0), bias)
    assert (added.log_evidence > 8.0) == (bias > 0.0)
    assert (added.log_transfer > 4.0) == (bias > 0.0)


def test_what_a_single_pose_cannot_tell_is_not_asked_of_it(screened, tilted, pair):
    points = [view.points for view in tilted.evaluator.model.views(tilted.fit.coordinates)]
    added = second_effect.second_adds(tilted, pair, points)
    assert added.log_transfer == np.inf
    assert added.log_evidence < 8.0, 'nothing but the tilt is there'


@pytest.mark.parametrize('amounts', [(-0.5, 0.1, 0.4), (0.3, -0.4, 0.2)])
def test_an_amplitude_that_differs_from_pose_to_pose_is_no_second_effect(pair, amounts):
    assert _adds(pair, amounts, 0.0).log_evidence < 8.0
    fit, places = _in_poses(pair, amounts)
    tilt = pair.added[:1]
    free = explained(fit, pair.added, tilt, places, in_any_form=True)
    assert free.log_evidence > explained(fit, pair.added, tilt, places).log_evidence + 4.0


def test_a_lens_is_a_form_of_a_camera_that_is_off(screened):
    camera = _found(screened, 'camera_offset')
    fit = camera.fit
    names = [fit.parameters.names.index(name) for name in ('rigid_offset.x', 'rigid_offset.y')]
    coordinates = fit.coordinates.copy()
    coordinates[names] = 0.008, -0.005
    points = [view.points for view in camera.evaluator.model.views(fit.coordinates)]
    places = places_of(camera.evaluator.model, fit.groups, points)
    bent = []
    for group, place in zip(fit.groups, places, strict=True):
        from_middle = place.across - np.array([0.45, 0.2])
        outwards = 0.03 * (from_middle**2).sum(axis=1)[:, None] * from_middle
        values = (group.patches.jacobian[:, names] * outwards).sum(axis=1)
        bent.append(replace(group, patches=replace(group.patches, values=values)))
    seen = replace(fit, coordinates=coordinates, groups=bent)
    rigid, lens = (
        explained(seen, camera.added, camera.added, places, in_any_form=own)
        for own in (False, True)
    )
    assert lens.log_evidence > rigid.log_evidence + 8.0


def _judged(hypothesis: Hypothesis, log_evidence: float, chi_square: float) -> Hypothesis:
    fit = hypothesis.fit
    judged = Tolerated(
        log_evidence, log_evidence / 4.0, 0.1, 1e-4, chi_square, fit.log_evidence, fit.patch_count
    )
    return replace(hypothesis, judged=judged)


@pytest.fixture(scope='module')
def selection(screened, tilted) -> Selection:
    others = _found(screened, 'clamp_offset', 'depth_affine')
    noise = float(tilted.fit.patch_count - len(tilted.fit.coordinates))
    one, two = _judged(tilted, -100.0, noise), _judged(others, -70.0, noise)
    return Selection((one,), (two,), added=Explained(20.0, 10.0))


def test_one_effect_that_leaves_noise_and_two_others_are_left_open(selection, screened):
    assert selection.rival is selection.pairs[0]
    choice = choose(selection, *screened[:2])
    assert choice.hypothesis is selection.singles[0]
    assert choice.confidence <= 0.5
    assert choice.alike == ('gravity_tilt', 'clamp_offset', 'depth_affine')


def test_two_others_are_needed_where_the_one_is_refuted(selection):
    (one,) = selection.singles
    refuted = replace(selection, singles=(_judged(one, -100.0, 2.0 * one.chi_square),))
    assert refuted.rival is None
    assert refuted.best is selection.pairs[0]


@pytest.mark.parametrize('added', [Explained(5.0, 10.0), Explained(20.0, 2.0)])
def test_what_a_form_explains_or_one_pose_alone_wants_is_no_second_name(selection, added):
    kept = replace(selection, added=added)
    assert kept.rival is None
    assert kept.best is selection.singles[0]


def test_what_may_as_well_be_absent_is_no_rival(screened, tilted):
    """A depth error that is not there leaves what the model without it leaves: nobody's twin."""
    evaluator, nominal, scores = screened
    affine = next(s for s in scores.scores if s.candidate.identifier == 'depth_affine').candidate
    absent = try_effects(evaluator, nominal, [affine], {}, max_iterations=1)
    assert has_doubtful_effect(absent, nominal)
    assert not has_doubtful_effect(tilted, nominal)
    close = replace(absent, fit=replace(absent.fit, log_evidence=tilted.log_evidence - 1.0))
    choice = choose(Selection((tilted, close)), *screened[:2])
    assert choice.alike == ('gravity_tilt',)
    assert choice.confidence == pytest.approx(1.0)
