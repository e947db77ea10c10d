# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A second effect is one that no form of the first explains, in every pose."""

from collections.abc import Sequence
from dataclasses import replace

from diffcal_ros.diagnosis.model_comparison import any_form, second_effect
from diffcal_ros.diagnosis.model_comparison import choice as choice_module
from diffcal_ros.diagnosis.model_comparison import selection as selection_module
from diffcal_ros.diagnosis.model_comparison.absence import has_doubtful_effect
from diffcal_ros.diagnosis.model_comparison.any_form import Sight, Tolerated
from diffcal_ros.diagnosis.model_comparison.choice import choose
from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects
from diffcal_ros.diagnosis.model_comparison.form_basis import FormBasis
from diffcal_ros.diagnosis.model_comparison.form_places import Places, places_of
from diffcal_ros.diagnosis.model_comparison.form_ways import Ways, ways_at
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.model_comparison.second_effect import Explained, explained
from diffcal_ros.diagnosis.model_comparison.selection import _believable_first, Selection
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
            own = np.eye(len(_POSES))[view]
            places.append(replace(place, own=own, pose=view, pose_count=len(_POSES)))
    return replace(fit, groups=groups), places


def _by(
    fit: Refit,
    places: Sequence[Places],
    pair: Hypothesis,
    kept: Sequence[Candidate],
    basis: FormBasis,
) -> Explained:
    return explained(fit, pair.added, kept, ways_at(places, fit, basis, kept))


def _adds(pair: Hypothesis, basis: FormBasis, amounts: Sequence[float], bias: float) -> Explained:
    fit, places = _in_poses(pair, amounts, bias)
    alone = [_by(fit, places, pair, [own], basis) for own in pair.added]
    return _by(fit, places, pair, pair.added, basis).above(alone)


def test_without_tolerances_it_is_the_evidence_of_the_fit(tilted, basis, monkeypatch):
    monkeypatch.setattr(any_form, 'OF_FORM', np.zeros(1))
    monkeypatch.setattr(any_form, 'BY_POSE', np.zeros(1))
    fit = tilted.fit
    places = places_of(tilted.evaluator.model, fit.groups, basis.points)
    found = _by(fit, places, tilted, tilted.added, basis)
    # The fit came to rest: what is left of its slope is worth a few hundredths.
    assert found.log_evidence == pytest.approx(fit.log_evidence, abs=0.1)
    assert found.log_transfer == 0.0, 'a single pose tells nothing of others'


def test_transfer_is_the_density_of_each_pose_given_the_others(monkeypatch):
    monkeypatch.setattr(any_form, 'OF_FORM', np.array([0.3]))
    monkeypatch.setattr(any_form, 'BY_POSE', np.array([0.5]))
    random = np.random.default_rng(4)
    own, by_pose, form = random.normal(size=(3, 9, 6))
    views = np.array([0, 1, 2, 0, 1, 2, 2, 1, 0])
    values = random.normal(size=9)
    known = own @ own.T + np.eye(9)
    volumes = random.random(9)
    sight = Sight(values, own, np.eye(6), by_pose, form, views, volumes)
    covariance = known + 0.25 * by_pose @ by_pose.T + 0.09 * form @ form.T
    for view in range(3):
        here, others = views == view, views != view
        gain = covariance[np.ix_(here, others)] @ np.linalg.inv(covariance[np.ix_(others, others)])
        spread = covariance[np.ix_(here, here)] - gain @ covariance[np.ix_(others, here)]
        expected = multivariate_normal.logpdf(values[here], gain @ values[others], spread)
        found = sight.level() - sight.without(view).level()
        expected -= 0.5 * volumes[here].sum()
        assert found == pytest.approx(expected + 1.5 * np.log(2.0 * np.pi))


@pytest.mark.parametrize('bias', [0.0, 0.003])
def test_a_second_effect_that_is_there_is_seen_beside_the_first(pair, basis, bias):
    added = _adds(pair, basis, (0.0, 0.0, 0.0), bias)
    assert (added.log_evidence > 8.0) == (bias > 0.0)
    assert (added.log_transfer > 4.0) == (bias > 0.0)


def test_what_a_single_pose_cannot_tell_is_not_asked_of_it(tilted, pair, basis):
    added = second_effect.second_adds([tilted], pair, basis)
    assert added.log_transfer == np.inf
    assert added.log_evidence < 8.0, 'nothing but the tilt is there'


@pytest.mark.parametrize('amounts', [(-0.2, 0.05, 0.15), (0.1, -0.2, 0.1)])
def test_an_amplitude_that_differs_from_pose_to_pose_is_no_second_effect(pair, basis, amounts):
    assert _adds(pair, basis, amounts, 0.0).log_evidence < 8.0
    fit, places = _in_poses(pair, amounts)
    tilt = pair.added[:1]
    ways = ways_at(places, fit, basis, tilt)
    same = replace(ways, by_pose=tuple(own[:, :0] for own in ways.by_pose))
    free, bound = (explained(fit, pair.added, tilt, own) for own in (ways, same))
    assert free.log_evidence > bound.log_evidence + 4.0


def test_a_lens_is_a_form_of_a_camera_that_is_off(screened, basis):
    camera = _found(screened, 'camera_offset')
    fit = camera.fit
    names = [fit.parameters.names.index(name) for name in ('rigid_offset.x', 'rigid_offset.y')]
    coordinates = fit.coordinates.copy()
    coordinates[names] = 0.008, -0.005
    places = places_of(camera.evaluator.model, fit.groups, basis.points)
    bent = []
    for group, place in zip(fit.groups, places, strict=True):
        from_middle = place.across - np.array([0.45, 0.2])
        outwards = 0.03 * (from_middle**2).sum(axis=1)[:, None] * from_middle
        values = (group.patches.jacobian[:, names] * outwards).sum(axis=1)
        bent.append(replace(group, patches=replace(group.patches, values=values)))
    seen = replace(fit, coordinates=coordinates, groups=bent)
    lens = ways_at(places, seen, basis, camera.added)
    count = [len(own) for own in lens.form]
    nothing = tuple(np.zeros((n, 0)) for n in count)
    rigid = Ways(nothing, nothing)
    found = [explained(seen, camera.added, camera.added, own) for own in (rigid, lens)]
    assert found[1].log_evidence > found[0].log_evidence + 8.0


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
    others = _found(screened, 'clamp_offset', 'depth_affine')
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
    moved = _found(screened, 'camera_offset')
    moved = replace(moved, fit=replace(moved.fit, chi_square=3.0 * moved.fit.patch_count))
    assert not _another_one(_judged(moved, -100.0, 3.0 * noise), 0.9).is_unlike_itself


@pytest.mark.parametrize(('level', 'is_first'), [(-83.0, True), (-90.0, False)])
def test_of_pairs_as_good_the_one_that_is_like_itself_comes_first(screened, pair, level, is_first):
    far = replace(pair, fit=replace(pair.fit, chi_square=3.0 * pair.fit.patch_count))
    best = _another_one(_judged(far, -80.0, far.fit.chi_square), 1.0)
    bent = _found(screened, 'clamp_offset', 'depth_affine')
    other = _judged(bent, level, bent.fit.chi_square)
    found = _believable_first([best, other], 1.0)
    assert (found[0] is other) == is_first
    assert {id(model) for model in found} == {id(best), id(other)}
    assert _believable_first([], 1.0) == []


def test_a_pair_that_differs_from_pose_to_pose_comes_last(screened, pair, monkeypatch):
    bent = _found(screened, 'clamp_offset', 'depth_affine')
    best, other = _judged(bent, -80.0, 1.0), _judged(pair, -120.0, 1.0)
    assert selection_module._with_something_in_common_first([best, other]) == [best, other]
    is_bent = best.identifiers
    monkeypatch.setattr(
        selection_module, 'differs_by_pose', lambda model: model.identifiers == is_bent
    )
    assert selection_module._with_something_in_common_first([best, other]) == [other, best]


def test_of_pairs_as_good_one_that_is_not_free_in_everything_comes_first(
    screened, pair, monkeypatch
):
    best = _judged(pair, -80.0, pair.fit.chi_square)
    bent = _found(screened, 'clamp_offset', 'depth_affine')
    other = _judged(bent, -83.0, bent.fit.chi_square)
    assert _believable_first([best, other], 1.0)[0] is best
    is_free = property(lambda model: model.identifiers == best.identifiers)
    monkeypatch.setattr(Hypothesis, 'is_free_in_everything', is_free)
    assert _believable_first([best, other], 1.0)[0] is other


def test_a_pair_that_is_unlike_itself_is_no_rival_of_one_that_is_not(screened, tilted, pair):
    noise = float(tilted.fit.patch_count - len(tilted.fit.coordinates))
    far = _found(screened, 'clamp_offset', 'rest_curvature')
    far = replace(far, fit=replace(far.fit, chi_square=3.0 * far.fit.patch_count))
    unlike = _another_one(_judged(far, -79.0, 3.0 * noise), 1.0)
    one, two = _judged(tilted, -180.0, noise), _judged(pair, -80.0, noise)
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
    bent = _judged(_found(screened, 'rest_curvature'), -102.0, noise)
    far = _judged(_found(screened, 'clamp_offset'), -130.0, noise)
    one, two = _judged(tilted, -100.0, noise), _judged(pair, -80.0, noise)
    selection = Selection((one, bent, far), (two,), added=Explained(20.0, 10.0))
    choice = choose(selection, *screened[:2])
    assert choice.hypothesis is two
    assert choice.alike == ('depth_affine', 'gravity_tilt', 'rest_curvature')
    assert choice.confidence <= 0.5


def test_of_two_effects_one_may_be_sure_and_the_other_one_not(screened, tilted):
    """Whatever is beside it, a bend at rest is in all that explains the data."""
    noise = float(tilted.fit.patch_count - len(tilted.fit.coordinates))
    levels = {'clamp_offset': -80.0, 'camera_offset': -81.0}
    pairs = [
        _judged(_found(screened, other, 'rest_curvature'), level, noise)
        for other, level in levels.items()
    ]
    one, added = _judged(tilted, -180.0, noise), Explained(80.0, 40.0)
    choice = choose(Selection((one,), tuple(pairs), added=added), *screened[:2])
    assert choice.hypothesis is pairs[0]
    assert choice.confidences['rest_curvature'] == pytest.approx(1.0)
    assert choice.confidences['clamp_offset'] == 0.5 == choice.confidence
    assert choice.alike == ('clamp_offset', 'rest_curvature', 'camera_offset')
    # A third one without it is as good: nothing is sure.
    third = _judged(_found(screened, 'clamp_offset', 'camera_offset'), -81.0, noise)
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
    bent = _at_its_upper_bound(_judged(_found(screened, 'rest_curvature'), level, noise))
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
    one, two = _judged(tilted, -180.0, noise), _judged(pair, -80.0, noise)
    bent = _judged(_found(screened, 'depth_affine', 'rest_curvature'), level, noise)
    is_bent = property(lambda model: model.identifiers == bent.identifiers)
    monkeypatch.setattr(Hypothesis, 'is_at_bound', is_bent)
    monkeypatch.setattr(choice_module, 'differs_by_pose', is_bent.fget)
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


@pytest.mark.parametrize(('left', 'is_needed'), [(9e-5, True), (1.1e-4, False)])
def test_a_second_effect_comes_no_less_near_where_nothing_was_fitted(selection, left, is_needed):
    found = _told(selection, 10.0, -1.0, left)
    assert (found.best is found.pairs[0]) == is_needed


def test_one_and_two_effects_are_compared_where_both_look(selection):
    """What only the better model sees is no reason against it."""
    one, two = selection.singles[0], selection.pairs[0]
    blamed = _judged(two, -110.0, two.chi_square)
    found = replace(selection, pairs=(blamed,))
    assert found.best is one
    side_by_side = replace(found, one_and_two=(one, _judged(two, -85.0, two.chi_square)))
    assert side_by_side.best is blamed
