# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whether one effect is enough or two are needed, and how sure each of them is."""

from dataclasses import replace

from diffcal_ros.diagnosis.model_comparison import choice as choice_module
from diffcal_ros.diagnosis.model_comparison import selection as selection_module
from diffcal_ros.diagnosis.model_comparison.absence import has_doubtful_effect
from diffcal_ros.diagnosis.model_comparison.any_form import Tolerated
from diffcal_ros.diagnosis.model_comparison.choice import choose
from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.model_comparison.second_effect import Explained
from diffcal_ros.diagnosis.model_comparison.selection import _believable_first, Selection
from diffcal_ros.diagnosis.patch_fits.refit import AS_NOISE
from diffcal_ros.diagnosis.patches.patch_gap import patch_gap
from diffcal_ros.diagnosis.patches.whitened import Part, precision_of
import numpy as np
import pytest
from support.judged_models import refitted_with


def _judged(
    hypothesis: Hypothesis, log_evidence: float, chi_square: float, leaning: float = 0.0
) -> Hypothesis:
    fit = hypothesis.fit
    judged = Tolerated(
        log_evidence=log_evidence,
        log_prediction=log_evidence,
        fraction=0.1,
        by_pose=0.0,
        left=1e-4,
        chi_square=chi_square,
        freedom=float(fit.patch_count - len(fit.coordinates)),
        exact=log_evidence - leaning,
        coordinates=fit.coordinates,
        covariance=fit.covariance,
    )
    return replace(hypothesis, judged=judged)


@pytest.fixture(scope='module')
def selection(screened, tilted) -> Selection:
    others = refitted_with(screened, 'clamp_offset', 'depth_affine')
    noise = float(tilted.fit.patch_count - len(tilted.fit.coordinates))
    # By what it owes to its form, 100, the single one is behind by 15, which is in doubt itself.
    one, two = _judged(tilted, -100.0, noise, 100.0), _judged(others, -95.0, noise)
    return Selection((one,), (two,), added=Explained(20.0, 10.0))


def test_one_effect_that_leaves_noise_and_two_others_are_left_open(selection, screened):
    assert selection.rival is selection.pairs[0]
    choice = choose(selection, *screened[:2])
    assert choice.hypothesis is selection.singles[0]
    assert choice.confidence <= 0.5
    assert choice.alike == ('gravity_tilt', 'clamp_offset', 'depth_affine')


def test_two_others_that_are_clearly_better_are_needed(selection):
    two = selection.pairs[0]
    clear = replace(selection, pairs=(_judged(two, -85.0, two.chi_square),))
    assert clear.rival is None
    assert clear.best is clear.pairs[0]


def test_what_is_in_doubt_of_one_speaks_against_a_second_one_beside_it(tilted, pair):
    noise = float(tilted.fit.patch_count - len(tilted.fit.coordinates))
    # By what it owes to its form, 60, the single one is behind by 12, and by 6 without a doubt.
    one, added = _judged(tilted, -100.0, 1.5 * noise, 60.0), Explained(20.0, 10.0)
    for level, is_needed in ((-94.0, False), (-90.0, True)):
        two = _judged(pair, level, noise)
        assert two.level - one.level > 8.0
        found = Selection((one,), (two,), added=added)
        assert (found.best is two) == is_needed


def test_beside_what_leaves_noise_there_is_no_second_one(tilted, pair):
    """What it gains is the prior's of poses that are off, and these may be misstated."""
    noise = float(tilted.fit.patch_count - len(tilted.fit.coordinates))
    assert tilted.fit.leaves_noise
    two, added = _judged(pair, -80.0, 0.9 * noise), Explained(20.0, 10.0)
    for chi_square, is_needed in ((noise, False), (1.5 * noise, True)):
        one = _judged(tilted, -100.0, chi_square)
        assert one.leaves_noise != is_needed
        found = Selection((one,), (two,), added=added)
        assert (found.best is two) == is_needed


def _another_one(model: Hypothesis, by_pose: float) -> Hypothesis:
    judged = replace(model.judged, by_pose=by_pose)
    return replace(model, judged=judged)


def test_what_stays_and_is_another_one_in_each_pose_is_hardly_it(screened, tilted):
    noise = float(tilted.fit.patch_count - len(tilted.fit.coordinates))
    # A fit that leaves more than noise.
    bad = replace(tilted.fit, chi_square=3.0 * tilted.fit.patch_count)
    wrong = _judged(replace(tilted, fit=bad), -100.0, 3.0 * noise)
    assert _another_one(wrong, 0.9).is_unlike_itself
    assert not _another_one(wrong, 0.3).is_unlike_itself
    assert not tilted.is_unlike_itself
    if_noise = replace(tilted, fit=replace(tilted.fit, chi_square=noise))
    assert not _another_one(_judged(if_noise, -100.0, noise), 0.9).is_unlike_itself
    moved = refitted_with(screened, 'camera_offset')
    moved = replace(moved, fit=replace(moved.fit, chi_square=3.0 * moved.fit.patch_count))
    assert not _another_one(_judged(moved, -100.0, 3.0 * noise), 0.9).is_unlike_itself


@pytest.mark.parametrize(('level', 'is_first'), [(-83.0, True), (-90.0, False)])
def test_of_pairs_as_good_the_one_that_is_like_itself_comes_first(screened, pair, level, is_first):
    far = replace(pair, fit=replace(pair.fit, chi_square=3.0 * pair.fit.patch_count))
    best = _another_one(_judged(far, -80.0, far.fit.chi_square), 1.0)
    bent = refitted_with(screened, 'clamp_offset', 'depth_affine')
    other = _judged(bent, level, bent.fit.chi_square)
    found = _believable_first([best, other], 1.0)
    assert (found[0] is other) == is_first
    assert {id(model) for model in found} == {id(best), id(other)}
    assert _believable_first([], 1.0) == []


def _first_of(identifiers):
    """Return who tells of models with some effects that the first differs from pose to pose."""
    return lambda model: model.added[0] if model.identifiers == identifiers else None


def test_a_pair_that_differs_from_pose_to_pose_comes_last(screened, pair, monkeypatch):
    bent = refitted_with(screened, 'clamp_offset', 'depth_affine')
    best, other = _judged(bent, -80.0, 1.0), _judged(pair, -120.0, 1.0)
    assert selection_module._with_something_in_common_first([best, other]) == [best, other]
    monkeypatch.setattr(selection_module, 'differing_by_pose', _first_of(best.identifiers))
    assert selection_module._with_something_in_common_first([best, other]) == [other, best]


def test_of_pairs_as_good_one_that_is_not_free_in_everything_comes_first(
    screened, pair, monkeypatch
):
    best = _judged(pair, -80.0, pair.fit.chi_square)
    bent = refitted_with(screened, 'clamp_offset', 'depth_affine')
    other = _judged(bent, -83.0, bent.fit.chi_square)
    assert _believable_first([best, other], 1.0)[0] is best
    is_free = property(lambda model: model.identifiers == best.identifiers)
    monkeypatch.setattr(Hypothesis, 'is_free_in_everything', is_free)
    assert _believable_first([best, other], 1.0)[0] is other


def test_a_pair_that_is_unlike_itself_is_no_rival_of_one_that_is_not(screened, tilted, pair):
    noise = float(tilted.fit.patch_count - len(tilted.fit.coordinates))
    far = refitted_with(screened, 'clamp_offset', 'rest_curvature')
    far = replace(far, fit=replace(far.fit, chi_square=3.0 * far.fit.patch_count))
    unlike = _another_one(_judged(far, -79.0, 3.0 * noise), 1.0)
    one, two = _judged(tilted, -180.0, 2.0 * noise), _judged(pair, -80.0, noise)
    choice = choose(Selection((one,), (two, unlike), added=Explained(80.0, 40.0)), *screened[:2])
    assert choice.hypothesis is two
    assert choice.confidence > 0.9
    assert choice.alike == ('depth_affine', 'gravity_tilt')


def test_two_others_are_needed_where_the_one_is_refuted(selection):
    (one,) = selection.singles
    refuted = replace(selection, singles=(_judged(one, -100.0, 2.0 * one.chi_square, 100.0),))
    assert refuted.rival is None
    assert refuted.best is selection.pairs[0]


def test_what_is_as_good_as_the_first_alone_is_told_beside_a_pair(screened, tilted, pair):
    """Whichever the first is, the second one may be beside it."""
    noise = float(tilted.fit.patch_count - len(tilted.fit.coordinates))
    bent = _judged(refitted_with(screened, 'rest_curvature'), -102.0, noise)
    far = _judged(refitted_with(screened, 'clamp_offset'), -130.0, noise)
    one, two = _judged(tilted, -100.0, 2.0 * noise), _judged(pair, -80.0, noise)
    selection = Selection((one, bent, far), (two,), added=Explained(20.0, 10.0))
    choice = choose(selection, *screened[:2])
    assert choice.hypothesis is two
    assert choice.alike == ('depth_affine', 'gravity_tilt', 'rest_curvature')
    assert choice.confidence <= 0.5
    # Where it was refitted beside the second one, too, that tells.
    for level, alike in ((-200.0, two.identifiers), (-82.0, (*two.identifiers, 'rest_curvature'))):
        other = _judged(refitted_with(screened, 'rest_curvature', 'depth_affine'), level, noise)
        choice = choose(replace(selection, pairs=(two, other)), *screened[:2])
        assert choice.alike == alike


def test_of_two_effects_one_may_be_sure_and_the_other_one_not(screened, tilted):
    """Whatever is beside it, a bend at rest is in all that explains the data."""
    noise = float(tilted.fit.patch_count - len(tilted.fit.coordinates))
    levels = {'clamp_offset': -80.0, 'camera_offset': -81.0}
    pairs = [
        _judged(refitted_with(screened, other, 'rest_curvature'), level, noise)
        for other, level in levels.items()
    ]
    one, added = _judged(tilted, -180.0, noise), Explained(80.0, 40.0)
    choice = choose(Selection((one,), tuple(pairs), added=added), *screened[:2])
    assert choice.hypothesis is pairs[0]
    assert choice.confidences['rest_curvature'] == pytest.approx(1.0)
    assert choice.confidences['clamp_offset'] == 0.5 == choice.confidence
    assert choice.alike == ('clamp_offset', 'rest_curvature', 'camera_offset')
    # A third one without it is as good: nothing is sure.
    third = _judged(refitted_with(screened, 'clamp_offset', 'camera_offset'), -81.0, noise)
    choice = choose(Selection((one,), (*pairs, third), added=added), *screened[:2])
    assert set(choice.confidences.values()) == {0.5}


def _at_its_upper_bound(model: Hypothesis) -> Hypothesis:
    """Return a model as if an amplitude had stopped at the most that it may be."""
    place = model.fit.parameters.names.index(model.added[0].names[0])
    _, upper = model.fit.parameters.bounds()
    coordinates = model.fit.coordinates.copy()
    coordinates[place] = upper[place]
    return replace(model, fit=replace(model.fit, coordinates=coordinates))


@pytest.mark.parametrize(('level', 'is_doubt'), [(-60.0, True), (-110.0, False)])
def test_what_is_better_and_would_be_more_than_it_may_be_is_a_doubt(
    screened, tilted, level, is_doubt
):
    noise = float(tilted.fit.patch_count - len(tilted.fit.coordinates))
    bent = _at_its_upper_bound(_judged(refitted_with(screened, 'rest_curvature'), level, noise))
    assert bent.would_be_more
    assert not tilted.would_be_more
    choice = choose(Selection((_judged(tilted, -100.0, noise), bent)), *screened[:2])
    assert choice.hypothesis.identifiers == ('gravity_tilt',)
    assert choice.alike == ('gravity_tilt', *(['rest_curvature'] if is_doubt else []))
    assert (choice.confidence <= 0.5) == is_doubt


@pytest.mark.parametrize(('level', 'is_doubt'), [(-60.0, True), (-95.0, False)])
def test_what_is_better_as_another_one_in_each_pose_is_a_doubt_beside_a_first(
    screened, tilted, pair, monkeypatch, level, is_doubt
):
    """What has nothing in common has no name; what follows it is no surer for that."""
    noise = float(tilted.fit.patch_count - len(tilted.fit.coordinates))
    one, two = _judged(tilted, -180.0, 2.0 * noise), _judged(pair, -80.0, noise)
    bent = _judged(refitted_with(screened, 'depth_affine', 'rest_curvature'), level, noise)
    is_bent = property(lambda model: model.identifiers == bent.identifiers)
    monkeypatch.setattr(Hypothesis, 'is_at_bound', is_bent)
    monkeypatch.setattr(choice_module, 'differing_by_pose', _first_of(bent.identifiers))
    added = Explained(80.0, 40.0)
    choice = choose(Selection((one,), (two, bent), added=added), *screened[:2])
    assert choice.hypothesis is two
    assert ('rest_curvature' in choice.alike) == is_doubt
    assert (choice.confidences['gravity_tilt'] <= 0.5) == is_doubt
    assert choice.confidences['depth_affine'] > 0.9


@pytest.mark.parametrize('added', [Explained(3.0, 10.0), Explained(20.0, 2.0)])
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


def test_what_data_cannot_do_without_is_a_rival_however_wide_its_interval(screened, tilted):
    """As a stiffening that levels off, 36 +- 20, which explains as much as a mass."""
    evaluator, nominal, scores = screened
    clamp = next(s for s in scores.scores if s.candidate.identifier == 'clamp_offset').candidate
    found = try_effects(evaluator, nominal, [clamp], {})
    places = [found.fit.parameters.names.index(name) for name in clamp.names]
    covariance = found.fit.covariance.copy()
    covariance[np.ix_(places, places)] = np.diag(found.fit.coordinates[places] ** 2)
    level = tilted.fit.log_evidence - 1.0
    wide = replace(found, fit=replace(found.fit, covariance=covariance, log_evidence=level))
    assert has_doubtful_effect(wide, nominal)
    choice = choose(Selection((tilted, wide)), *screened[:2])
    assert choice.alike == ('gravity_tilt', 'clamp_offset')
    assert choice.confidence <= 0.5


def _told(selection: Selection, transfer: float, told: float, left: float = 1e-4) -> Selection:
    """Return a selection whose pair leads by 50 where patches were fitted, and its held-out ones.

    Args:
        selection: of one effect and of two others.
        transfer: what poses say of a second effect.
        told: what held-out patches do.
        left: what the pair leaves of those [m]; the single effect leaves 0.1 mm.
    """
    two = _judged(selection.pairs[0], -60.0, selection.pairs[0].chi_square)
    before = selection.singles[0].judged.log_prediction
    judged = replace(two.judged, log_prediction=before + told, left=left)
    two = replace(two, judged=judged)
    return replace(selection, pairs=(two,), added=Explained(20.0, transfer))


@pytest.mark.parametrize(
    ('transfer', 'told', 'is_needed'),
    [
        (10.0, -1.0, True),
        (10.0, -39.0, True),
        (10.0, -45.0, False),
        (np.inf, -1.0, False),
        (np.inf, 9.0, True),
    ],
)
def test_cells_need_not_ask_for_a_second_effect_that_other_poses_do(
    selection, transfer, told, is_needed
):
    """Cells between those that were fitted are told by these as well without it."""
    found = _told(selection, transfer, told)
    assert (found.best is found.pairs[0]) == is_needed


@pytest.mark.parametrize(
    ('of_one', 'left', 'is_needed'), [(1.2, 1.1, True), (1.2, 1.3, False), (0.5, 0.9, True)]
)
def test_a_second_effect_comes_no_less_near_where_nothing_was_fitted(
    selection, of_one, left, is_needed
):
    """What may be noise is no less near than what is left of it."""
    most = selection_module._most_noise(selection.pairs[0])
    one = selection.singles[0]
    one = replace(one, judged=replace(one.judged, left=of_one * most))
    told = _told(replace(selection, singles=(one,)), 10.0, -1.0, left * most)
    assert (told.best is told.pairs[0]) == is_needed


def test_noise_hardly_leaves_more_than_the_most_of_it(selection, random):
    """Floors are what is to be expected: noise of that size is above them in half of all draws."""
    model = selection.pairs[0]
    groups = [own for own in model.fit.groups if not own.is_rigid and own.patches.standing is None]
    assert len(groups) == len(model.fit.groups) == 2
    fit = replace(model.fit, groups=groups)
    covariance = np.linalg.inv(precision_of(groups))
    chosen = np.flatnonzero(np.concatenate([own.is_report for own in groups]))
    noise = covariance[np.ix_(chosen, chosen)]
    drawn = random.multivariate_normal(np.zeros(len(chosen)), noise, size=20_000)
    left = np.sqrt(np.square(drawn).mean(axis=1))
    floor = patch_gap(groups, Part.REPORT).whole_floor
    assert np.sqrt(np.square(left).mean()) == pytest.approx(floor, rel=0.02)
    most = selection_module._most_noise(replace(model, fit=fit))
    assert (left > floor).mean() > 0.3
    assert (left > most).mean() == pytest.approx(AS_NOISE, abs=0.03)


def test_one_and_two_effects_are_compared_where_both_look(selection):
    """What only the better model sees is no reason against it."""
    one, two = selection.singles[0], selection.pairs[0]
    blamed = _judged(two, -110.0, two.chi_square)
    found = replace(selection, pairs=(blamed,))
    assert found.best is one
    side_by_side = replace(found, one_and_two=(one, _judged(two, -85.0, two.chi_square)))
    assert side_by_side.best is blamed
