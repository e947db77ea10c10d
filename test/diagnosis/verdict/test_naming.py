# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A name says what the library says of it: what is far from that has none."""

from collections.abc import Sequence
from dataclasses import replace

from diffcal_ros.calibration.parameters.form_parameters import (
    form_parameters,
    knot_parameter,
    posture_parameter,
)
from diffcal_ros.calibration.parameters.parameters import Parameter
from diffcal_ros.diagnosis.answers import Verdict
from diffcal_ros.diagnosis.detection.disagreement import measure_disagreement
from diffcal_ros.diagnosis.model_comparison import absence
from diffcal_ros.diagnosis.model_comparison.choice import Choice
from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects
from diffcal_ros.diagnosis.model_comparison.hypothesis import FARTHEST_FORM, Hypothesis
from diffcal_ros.diagnosis.patches.patch_gap import patch_gap
from diffcal_ros.diagnosis.patches.patch_group import with_columns
from diffcal_ros.diagnosis.patches.smooth_sizes import with_larger_error
from diffcal_ros.diagnosis.patches.whitened import Part
from diffcal_ros.diagnosis.screening.candidates import Candidate
from diffcal_ros.diagnosis.verdict import doubts, naming
from diffcal_ros.diagnosis.verdict.doubts import doubts_about
from diffcal_ros.diagnosis.verdict.field_witness import FieldWitness
from diffcal_ros.diagnosis.verdict.unknown import FAR_ABOVE, is_unexplained, Unknown
from diffcal_ros.diagnosis.verdict.verdict_figures import closed_in_its_form, closure_of
from diffcal_ros.time_knot import knots_between
import numpy as np
import pytest
from support.judged_models import refitted_with, with_judgement


@pytest.fixture(scope='module')
def tilted(clearly_screened) -> Hypothesis:
    return refitted_with(clearly_screened, 'gravity_tilt')


@pytest.fixture(scope='module')
def bent(clearly_screened) -> Hypothesis:
    return refitted_with(clearly_screened, 'rest_curvature')


def test_an_effect_in_about_its_form_has_its_name(clearly_screened, tilted):
    _, nominal, _ = clearly_screened
    assert doubts_about(with_judgement(tilted), nominal) == ()
    assert doubts_about(with_judgement(tilted, fraction=0.45, by_pose=0.15), nominal) == ()


@pytest.mark.parametrize(
    ('changes', 'words'),
    [
        ({'fraction': 0.8}, 'in a form that is off by 80% of what it does'),
        ({'by_pose': 0.9}, 'in a form that is another one in each pose'),
        ({'fraction': 0.4, 'by_pose': 0.4}, 'in a form that is another one in each pose'),
    ],
)
def test_what_is_far_from_the_form_of_the_library_has_none(
    clearly_screened, tilted, changes, words
):
    _, nominal, _ = clearly_screened
    (doubt,) = doubts_about(with_judgement(tilted, **changes), nominal)
    assert words in doubt
    assert doubt.endswith('no name for it')


def test_where_the_form_of_the_library_leaves_noise_none_is_asked_for(clearly_screened, tilted):
    _, nominal, _ = clearly_screened
    other = replace(with_judgement(tilted, fraction=0.8), fit=tilted.fit)
    assert tilted.fit.chance_of_noise > 0.05
    assert doubts_about(other, nominal) == ()


def test_where_next_to_nothing_is_owed_to_other_forms_none_is_asked_for(clearly_screened, tilted):
    _, nominal, _ = clearly_screened
    exact = tilted.fit.log_evidence - 30.0
    assert doubts_about(with_judgement(tilted, fraction=0.8, exact=exact), nominal) == ()
    (doubt,) = doubts_about(with_judgement(tilted, by_pose=0.9, exact=exact), nominal)
    assert 'another one in each pose' in doubt


@pytest.mark.parametrize(('floors', 'is_named'), [(1.5, True), (2.0, False)])
def test_what_leaves_far_more_than_the_floors_asks_for_its_form(
    clearly_screened, tilted, floors, is_named
):
    _, nominal, _ = clearly_screened
    judged = with_judgement(tilted, fraction=0.8, exact=tilted.fit.log_evidence - 30.0)
    left = floors * patch_gap(tilted.fit.groups, Part.REPORT).whole_floor
    groups = [
        replace(one, patches=replace(one.patches, values=np.full(len(one.mesh), left)))
        for one in tilted.fit.groups
    ]
    assert patch_gap(nominal.groups, Part.REPORT).rms > 4.0 * left
    doubts = doubts_about(replace(judged, fit=replace(judged.fit, groups=groups)), nominal)
    assert (doubts == ()) == is_named
    assert is_named or 'off by 80%' in doubts[0]


def _with_a_free_form(model: Hypothesis) -> Hypothesis:
    """Return a model whose effect may be of other forms by its parameters, and is of none."""
    return _with_parts(model, form_parameters(model.added[0].effect, 0.3))


def _with_parts(model: Hypothesis, parts: Sequence[Parameter]) -> Hypothesis:
    """Return a model that knows of further parameters, all of them zero."""
    fit, parameters = model.fit, model.fit.parameters
    covariance = np.eye(len(fit.coordinates) + len(parts))
    covariance[: len(fit.coordinates), : len(fit.coordinates)] = fit.covariance
    fit = replace(
        fit,
        parameters=replace(parameters, parameters=(*parameters.parameters, *parts)),
        coordinates=np.append(fit.coordinates, np.zeros(len(parts))),
        shifts=np.append(fit.shifts, np.zeros(len(parts))),
        covariance=covariance,
    )
    return replace(model, fit=fit)


def _with_poses(model: Hypothesis) -> Hypothesis:
    """Return a model whose effect may be another one in each posture."""
    known = model.fit.parameters
    own = [known.parameters[known.names.index(name)] for name in model.added[0].names]
    return _with_parts(model, [posture_parameter(part, 0, 0.1) for part in own])


def test_what_is_free_in_form_and_in_each_pose_may_be_anything(clearly_screened, bent):
    _, nominal, _ = clearly_screened
    model = with_judgement(bent, fraction=0.0, by_pose=0.0)
    form, poses = _with_a_free_form(model), _with_poses(model)
    free = [own.is_free_in_everything for own in (model, form, poses, _with_poses(form))]
    assert free == [False, False, False, True]
    other = replace(_with_poses(form), added=(Candidate('gravity_tilt', ('a', 'b')),))
    assert not other.is_free_in_everything, 'the parts are of another effect'
    (doubt,) = doubts_about(_with_poses(form), nominal)
    assert 'may be anything' in doubt


@pytest.mark.parametrize(('left', 'is_named'), [(1.5, True), (2.5, False)])
def test_what_is_free_at_any_time_leaves_no_more_than_about_noise(tilted, left, is_named):
    known = tilted.fit.parameters
    own = known.parameters[known.names.index(tilted.added[0].names[0])]
    parts = [knot_parameter(own, knot, 0.1) for knot in knots_between(0.0, 0.4, 3)]
    model = _with_parts(tilted, parts)
    count = model.fit.patch_count - len(model.fit.coordinates)
    model = replace(model, fit=replace(model.fit, chi_square=left * count))
    assert model.is_free_in_time
    assert not tilted.is_free_in_time
    assert not model.is_free_in_form, 'it is of the form of the library at any time'
    said = doubts.freedom_of(model)
    assert (said is None) == is_named
    assert is_named or 'in the course of the recording, and leaves more than noise' in said


def _at_any_time(model: Hypothesis) -> Hypothesis:
    """Return a model whose effect may be another one at any time, and leaves noise."""
    known = model.fit.parameters
    own = known.parameters[known.names.index(model.added[0].names[0])]
    parts = [knot_parameter(own, knot, 0.1) for knot in knots_between(0.0, 0.4, 3)]
    freed = _with_parts(model, parts)
    nothing = [np.zeros((len(group.patches.values), 3)) for group in freed.fit.groups]
    groups = with_columns(freed.fit.groups, nothing)
    fit = replace(freed.fit, groups=groups, chi_square=float(freed.fit.patch_count))
    return replace(freed, fit=fit)


@pytest.mark.parametrize(
    ('name', 'words'),
    [
        ('gravity_tilt', 'which a gust, a mass that runs out, a rig that is accelerated may be'),
        ('camera_offset', 'which a rig that moves before the camera may be as well'),
    ],
)
def test_what_others_do_over_time_has_its_class_alone(clearly_screened, name, words):
    _, nominal, _ = clearly_screened
    model = refitted_with(clearly_screened, name)
    (said,) = doubts_about(_at_any_time(model), nominal)
    assert words in said
    assert not any(words in other for other in doubts_about(model, nominal))


@pytest.mark.parametrize(('closed', 'is_named'), [(0.97, True), (0.8, False)])
def test_what_is_free_at_any_time_closes_nearly_all(clearly_screened, bent, closed, is_named):
    _, nominal, _ = clearly_screened
    said = doubts._of_what_is_left(_at_any_time(bent), nominal, (closed, closed))
    assert (said is None) == is_named
    assert is_named or f'course of the recording, and closes {closed:.0%} of the gap' in said
    # What is the same at all times may leave more.
    assert doubts._of_what_is_left(bent, nominal, (closed, closed)) is None


@pytest.mark.parametrize(('fraction', 'is_named'), [(0.2, True), (0.4, False)])
def test_what_is_free_in_form_and_still_another_one_has_no_name(bent, fraction, is_named):
    judged = with_judgement(bent, fraction=fraction)
    fixed, free = doubts.freedom_of(judged), doubts.freedom_of(_with_a_free_form(judged))
    assert fixed is None
    assert (free is None) == is_named
    assert is_named or 'off by 40%' in free


@pytest.mark.parametrize(
    ('fraction', 'leaning', 'is_named'),
    [(0.8, 80.0, False), (0.4, 80.0, True), (0.8, 20.0, True)],
)
def test_what_leaves_noise_as_another_one_in_each_pose_is_of_about_its_form(
    bent, fraction, leaning, is_named
):
    judged = with_judgement(bent, fraction=fraction, exact=bent.fit.log_evidence - leaning)
    same = replace(judged, fit=replace(bent.fit, chi_square=0.8 * bent.fit.patch_count))
    assert same.fit.chance_of_noise > 0.05
    assert doubts.freedom_of(same) is None
    assert (doubts.freedom_of(_with_poses(same)) is None) == is_named


@pytest.mark.parametrize(('fraction', 'is_named'), [(0.1, True), (0.2, False)])
def test_two_effects_one_of_which_is_free_in_form_share_what_is_left_to_that(
    bent, fraction, is_named
):
    judged = _with_a_free_form(with_judgement(bent, fraction=fraction))
    assert doubts.freedom_of(judged) is None
    twice = doubts.freedom_of(replace(judged, added=(*judged.added, *judged.added)))
    assert (twice is None) == is_named


@pytest.mark.parametrize(('fraction', 'expected'), [(0.45, 1.0), (0.55, 0.3)])
def test_a_form_that_may_not_be_named_closes_nothing(clearly_screened, tilted, fraction, expected):
    """Where the library's form leaves noise on fitted patches its own closure counts, too."""
    _, nominal, _ = clearly_screened
    judged = with_judgement(tilted, fraction=fraction, left=0.0)
    assert closed_in_its_form(nominal, judged, 0.3) == pytest.approx(expected)
    far = [
        replace(one, patches=replace(one.patches, values=one.patches.values + 3e-3))
        for one in tilted.fit.groups
    ]
    open_gap = replace(judged, fit=replace(tilted.fit, groups=far))
    is_open = is_unexplained(nominal, open_gap, 0.3, 5e-4, is_measured=True)
    assert is_open == (fraction > FARTHEST_FORM)


def test_two_effects_share_what_forms_may_be_off_by(clearly_screened, tilted):
    _, nominal, _ = clearly_screened
    judged = with_judgement(tilted, fraction=0.4)
    twice = replace(judged, added=(*judged.added, *judged.added))
    assert doubts_about(judged, nominal) == ()
    assert 'off by 40%' in doubts_about(twice, nominal)[0]


def test_a_pair_that_leaves_more_than_the_floors_is_not_all(clearly_screened, tilted):
    _, nominal, _ = clearly_screened
    judged = with_judgement(tilted, left=0.004)
    twice = replace(judged, added=(*judged.added, *judged.added))
    assert 'not all that is missing' in doubts_about(twice, nominal)[0]
    assert doubts_about(judged, nominal) == (), 'of one effect its form tells the rest'


@pytest.mark.parametrize('leaves_noise', [True, False])
def test_a_sensor_that_is_worse_beside_a_pair_leaves_more(clearly_screened, tilted, leaves_noise):
    """Where more than noise is left on what was fitted, that is not the sensor's."""
    _, nominal, _ = clearly_screened
    count = tilted.fit.patch_count
    chi_square = (0.8 if leaves_noise else 3.0) * count
    groups, noises = tilted.fit.groups, tilted.evaluator.noises
    floors = [
        patch_gap(with_larger_error(groups, noises, own), Part.REPORT).whole_floor
        for own in (1.0, 3.0)
    ]
    judged = with_judgement(tilted, left=FAR_ABOVE * np.mean(floors), chi_square=chi_square)
    twice = replace(judged, added=(*judged.added, *judged.added))
    assert 'not all that is missing' in doubts_about(twice, nominal)[0]
    doubts = doubts_about(replace(twice, larger=3.0), nominal)
    assert (doubts == ()) == leaves_noise


@pytest.mark.parametrize(
    ('changes', 'closure', 'expected'),
    [
        ({'fraction': 0.1, 'by_pose': 1.0, 'left': 1e-4}, 0.1, True),
        ({'fraction': 0.1, 'by_pose': 1.0, 'left': 1.0}, 0.1, False),
        ({'fraction': 0.4, 'left': 1e-4}, 0.1, False),
        ({'fraction': 0.4, 'left': 1e-4}, 0.6, True),
        ({'fraction': 0.8, 'left': 1e-4}, 0.9, False),
    ],
)
def test_what_closes_the_gap_in_about_its_form_tells_the_class(
    clearly_screened, tilted, changes, closure, expected
):
    _, nominal, _ = clearly_screened
    assert naming._tells_class(nominal, with_judgement(tilted, **changes), closure) is expected


def test_a_free_form_closes_nothing_for_the_class(clearly_screened, bent, monkeypatch):
    evaluator, nominal, scores = clearly_screened
    told = []

    def described(*_, closes, **__):
        told.append(closes)
        return Unknown(('shape',), None)

    monkeypatch.setattr(naming, 'describe_unknown', described)
    judged = measure_disagreement(nominal, scores, margin=1e-5)
    judged = replace(judged, verdict=Verdict.DISAGREE)
    free = try_effects(
        evaluator,
        nominal,
        bent.added,
        bent.fit.values_by_name(),
        max_iterations=1,
        freed=tuple(form_parameters(bent.added[0].effect, 0.3)),
    )
    # By a form that is another thing: it has no name.
    models = [with_judgement(model, fraction=0.9) for model in (bent, free)]
    for own in models:
        choice = Choice(own, dict.fromkeys(own.identifiers, 1.0), own.identifiers, None)
        witness = FieldWitness(evaluator, nominal)
        naming.find_name(evaluator, nominal, scores, judged, choice, (), witness)
    closes, free = told
    assert closes == closure_of(nominal, models[0].fit, is_measured=True)
    assert np.isnan(free)


def test_no_shape_is_another_one_in_each_pose(clearly_screened, tilted, bent):
    _, nominal, _ = clearly_screened
    other = {'by_pose': 1.0, 'left': 1e-4}
    assert naming._tells_class(nominal, with_judgement(bent, left=1e-4), 0.1)
    assert not naming._tells_class(nominal, with_judgement(bent, **other), 0.1)
    assert naming._tells_class(nominal, with_judgement(tilted, **other), 0.1), 'loads may be'


def test_a_clamp_that_gives_way_in_each_pose_by_itself_and_in_none_of_all_has_no_name(
    clearly_screened, monkeypatch
):
    _, nominal, _ = clearly_screened
    clamp = with_judgement(refitted_with(clearly_screened, 'compliant_clamp'))
    monkeypatch.setattr(doubts, 'has_doubtful_effect', lambda *_: False)
    for module in (absence, doubts):
        monkeypatch.setattr(module, 'spread_of_amount', lambda *_: 0.8)
    (doubt,) = doubts_about(clamp, nominal)
    assert 'with a compliant_clamp that is another one in each pose by 80%: no name' in doubt
    monkeypatch.setattr(doubts, 'has_nothing_in_common', lambda *_: True)
    (doubt,) = doubts_about(clamp, nominal)
    assert 'another one in each pose, and may be none in all: no name for it' in doubt
    mass = replace(clamp, added=(replace(clamp.added[0], identifier='added_mass'),))
    assert doubts._differs_by_pose(mass) == (
        'an added_mass that is another one in each pose, and may be none in all'
    )
