# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which models are fitted with effects that are free to be others, and with what."""

from dataclasses import replace
from types import SimpleNamespace

from diffcal_ros.diagnosis.model_comparison import any_form, freed_effects
from diffcal_ros.diagnosis.model_comparison.any_form import tolerated
from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects
from diffcal_ros.diagnosis.model_comparison.form_ways import ways_of
from diffcal_ros.diagnosis.model_comparison.freed_effects import (
    with_less_freedom,
    with_those_freed,
)
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.screening.candidates import parameters_of
from diffcal_ros.diagnosis.screening.shortlist import starts_of
from diffcal_ros.diagnosis.verdict.verdict_figures import spread_over_poses
from diffcal_ros.effects.registry import EFFECTS
import numpy as np
import pytest


@pytest.fixture(autouse=True)
def as_large_as_they_were(monkeypatch):
    """What is freed here stays as large as it was asked for; see test_form_sizes."""
    monkeypatch.setattr(freed_effects, 'with_favoured_sizes', lambda _, model: model)


def _judged(
    screened, basis, name: str, by_pose: float, fraction: float = 0.0, leaning: float = 80.0
) -> Hypothesis:
    """Return a model with an effect, judged, of which data say by how much it differs."""
    evaluator, nominal, scores = screened
    score = next(s for s in scores.scores if s.candidate.identifier == name)
    model = try_effects(evaluator, nominal, [score.candidate], starts_of(score))
    ways = ways_of(model.evaluator.model, model.fit, basis, model.added)
    found = tolerated(model.fit, ways)
    exact = found.log_evidence - leaning
    return replace(model, judged=replace(found, by_pose=by_pose, fraction=fraction, exact=exact))


@pytest.fixture(scope='module')
def clamp(screened, basis) -> Hypothesis:
    return _judged(screened, basis, 'clamp_offset', 0.3)


def test_amplitudes_get_a_part_of_their_own_as_large_as_data_say(clamp):
    request = freed_effects._request(clamp)
    assert [part.name for part in request.freed] == [f'{n}@0' for n in clamp.added[0].names]
    assert all(part.is_nuisance and part.posture == 0 for part in request.freed)
    names = clamp.fit.parameters.names
    scales = np.array(
        [clamp.added[0].effect.component(c).scale for c in clamp.added[0].components]
    )
    values = clamp.fit.coordinates[[names.index(name) for name in clamp.added[0].names]]
    usual = np.array([part.quantity.prior_std for part in request.freed]) / scales
    np.testing.assert_allclose(usual, 0.3 * np.linalg.norm(values / scales))


def test_an_effect_that_came_to_nothing_is_of_no_other_form(clamp):
    """A prior as large as a share of nothing has no precision."""
    bent = replace(clamp, judged=replace(clamp.judged, fraction=0.3))
    names = clamp.fit.parameters.names
    coordinates = clamp.fit.coordinates.copy()
    coordinates[[names.index(name) for name in clamp.added[0].names]] = 0.0
    nothing = replace(bent, fit=replace(clamp.fit, coordinates=coordinates))
    assert freed_effects._freed(bent)
    assert freed_effects._freed(nothing) == []
    assert freed_effects._freed(nothing, 0.09) == []


def test_only_what_may_be_clamped_or_moved_anew_and_may_win_is_fitted_so(screened, basis, clamp):
    assert freed_effects._may_win(clamp, clamp.level)
    same = replace(clamp, judged=replace(clamp.judged, by_pose=0.05))
    assert not freed_effects._may_win(same, clamp.level)
    noise = 0.5 * max(clamp.chi_square - clamp.judged.freedom, 0.0)
    assert freed_effects._may_win(clamp, clamp.log_evidence + noise - 0.1)
    assert not freed_effects._may_win(clamp, clamp.log_evidence + noise + 0.1)
    exact = clamp.judged.log_evidence - 40.0
    sure = replace(clamp, judged=replace(clamp.judged, exact=exact))
    assert not freed_effects._may_win(sure, clamp.level), 'forms decide nothing'
    load = _judged(screened, basis, 'gravity_tilt', 0.9)
    assert not freed_effects._may_win(load, load.level)


def test_what_is_of_another_form_gets_what_it_is_more_in_that(screened, basis):
    bend = _judged(screened, basis, 'rest_curvature', 0.05, 0.4)
    request, effect = freed_effects._request(bend), bend.added[0].effect
    assert [part.amplitude for part in request.freed] == [part.name for part in effect.forms]
    assert all(part.is_freed and part.posture is None for part in request.freed)
    names = bend.fit.parameters.names
    values = bend.fit.coordinates[[names.index(name) for name in bend.added[0].names]]
    size = np.linalg.norm(values / effect.components[0].scale)
    usual = [part.quantity.prior_std / effect.forms[0].scale for part in request.freed]
    np.testing.assert_allclose(usual, 0.4 * size)
    assert freed_effects._may_win(bend, bend.level)
    of_that = replace(bend, judged=replace(bend.judged, fraction=0.05))
    assert not freed_effects._may_win(of_that, bend.level)
    tilt = _judged(screened, basis, 'gravity_tilt', 0.05, 0.9)
    assert not freed_effects._may_win(tilt, tilt.level), 'the library has no other form of it'


def test_a_place_is_freed_by_a_usual_size(screened, basis):
    plane = _judged(screened, basis, 'contact_plane', 0.05, 0.5)
    request = freed_effects._request(plane)
    assert {part.quantity.prior_std for part in request.freed} == {0.5 * 0.010}


def test_where_models_are_judged_as_they_are_they_stay_so(screened, clamp):
    evaluator, nominal, _ = screened
    assert with_those_freed(RefitPool(evaluator, nominal), [clamp], None) == [clamp]


def test_such_a_model_goes_on_with_its_parts_and_needs_no_tolerance_for_them(
    screened, basis, clamp
):
    evaluator, nominal, _ = screened
    pool = RefitPool(evaluator, nominal)
    (found,) = pool.refit_all([freed_effects._request(clamp)])
    assert [part.name for part in found.freed] == [f'{n}@0' for n in clamp.added[0].names]
    ways = ways_of(found.evaluator.model, found.fit, basis, found.added)
    assert ways.pose_count == 0
    brought = parameters_of(found.fit.parameters, found.added)
    assert set(brought) == {*clamp.added[0].names, *(p.name for p in found.freed)}
    (again,) = pool.finish([found], [-np.inf])
    assert again.fit.parameters.names == found.fit.parameters.names
    assert again.fit.log_evidence >= found.fit.log_evidence - 0.1
    once = replace(found, judged=clamp.judged)
    assert not freed_effects._may_win(once, clamp.level), 'it is free already'
    (said,) = spread_over_poses(found)
    assert said.startswith('clamp_offset is another one in each pose: rx by ')
    assert spread_over_poses(clamp) == []


def test_in_the_librarys_form_parameters_are_those_of_the_fit(screened, basis, monkeypatch):
    monkeypatch.setattr(any_form, 'OF_FORM', np.zeros(1))
    monkeypatch.setattr(any_form, 'BY_POSE', np.zeros(1))
    tilt = _judged(screened, basis, 'gravity_tilt', 0.0)
    exact = tilt.in_any_form
    # Two routes: normal equations of the fit, and columns scaled by the root of the prior.
    np.testing.assert_allclose(exact.covariance, tilt.fit.covariance, rtol=1e-6, atol=1e-14)
    errors = np.sqrt(np.diag(tilt.fit.covariance))
    assert np.abs((exact.coordinates - tilt.fit.coordinates) / errors).max() < 0.1


def test_parameters_are_less_sure_beside_an_effect_of_whatever_form(screened, basis):
    tilt = _judged(screened, basis, 'gravity_tilt', 0.0)
    index = tilt.fit.parameters.names.index('youngs_modulus')
    _, alone = tilt.fit.of_the_body(index)
    _, in_any = tilt.in_any_form.of_the_body(index)
    assert in_any > alone
    assert replace(tilt, judged=None).in_any_form is tilt.fit


def _with_parts(model, parts):
    """Return a model that knows of further parameters, all of them zero."""
    before = model.fit
    fit = replace(
        before,
        parameters=replace(before.parameters, parameters=(*before.parameters.parameters, *parts)),
        coordinates=np.append(before.coordinates, np.zeros(len(parts))),
    )
    return replace(model, fit=fit)


class _Refits:
    """Refits that leave what a model is, each a given amount likelier."""

    def __init__(self, gains):
        self._gains, self.asked, self.ended, self.left = iter(gains), [], 0, 0.9

    def refit_all(self, requests):
        (request,) = requests
        self.asked.append(len(request.freed))
        gain = next(self._gains)
        known = self.model.fit.parameters.names
        better = _with_parts(
            self.model, [part for part in request.freed if part.name not in known]
        )
        self.model = _likelier(better, gain)
        return [self.model]

    def finish(self, models, least):
        self.ended += 1
        chi_square = self.left * models[0].fit.chi_square
        return [replace(models[0], fit=replace(models[0].fit, chi_square=chi_square))]


class _RefitsOf:
    """Refits of several models by the effect of each, that are likelier by a given amount."""

    def __init__(self, known: dict[str, tuple[Hypothesis, float]]) -> None:
        self._known, self.asked = known, list[str]()

    def refit_all(self, requests):
        (request,) = requests
        name = request.added[0].identifier
        self.asked.append(name)
        model, gain = self._known[name]
        return [_likelier(_with_parts(model, request.freed), gain)]


def _likelier(model, gain):
    judged = model.judged
    judged = replace(
        judged, log_evidence=judged.log_evidence + gain, exact=judged.exact + gain, by_pose=0.2
    )
    return replace(model, judged=judged)


@pytest.mark.parametrize(('gains', 'rounds'), [((5.0, 5.0), 2), ((-5.0,), 1)])
def test_what_shows_once_a_form_is_free_is_freed_as_well(
    screened, basis, monkeypatch, gains, rounds
):
    camera = _judged(screened, basis, 'camera_offset', 0.05, 0.4)
    refits = _Refits(gains)
    refits.model = camera
    monkeypatch.setattr(freed_effects, 'judged', lambda models, *_, **__: list(models))
    found = freed_effects._freed_as_it_wants(refits, camera, basis, camera.level)
    forms, parts = len(camera.added[0].effect.forms), len(camera.added[0].names)
    assert refits.asked == [forms, forms + parts][:rounds]
    assert found.level == pytest.approx(max(camera.level, camera.level + sum(gains)))


def test_a_form_that_is_free_and_still_another_one_is_so_in_each_pose(screened, basis):
    camera = _judged(screened, basis, 'camera_offset', 0.05, 0.4)
    form = freed_effects._request(camera).freed
    assert [part.posture for part in form] == [None] * len(form)
    freed = _with_parts(camera, form)
    assert freed_effects._freed(freed) == [], 'of one pose it is told already'
    two = SimpleNamespace(model=SimpleNamespace(bodies={0: None, 1: None}))
    more = freed_effects._freed(replace(freed, evaluator=two))
    assert [part.name for part in more] == [
        f'{part.name}@{posture}' for part in form for posture in (0, 1)
    ]
    # As large as data say that the form is another one yet.
    by_name = {part.name: part.quantity.prior_std for part in form}
    for part in more:
        assert part.quantity.prior_std == pytest.approx(by_name[part.name.partition('@')[0]])
    # A body is bent at rest by one curve, whatever its pose.
    bend = _judged(screened, basis, 'rest_curvature', 0.05, 0.4)
    bent = _with_parts(bend, freed_effects._request(bend).freed)
    assert freed_effects._freed(replace(bent, evaluator=two)) == []


@pytest.mark.parametrize(
    ('is_converged', 'is_freed', 'left', 'is_better'),
    [
        (False, True, 0.9, True),
        (False, True, 1.1, False),
        (True, True, 0.9, False),
        (False, False, 0.9, False),
    ],
)
def test_the_best_is_fitted_to_the_end_where_it_is_free(
    screened, basis, clamp, monkeypatch, is_converged, is_freed, left, is_better
):
    monkeypatch.setattr(freed_effects, 'judged', lambda models, *_, **__: list(models))
    parts = freed_effects._freed(clamp) if is_freed else []
    model = _with_parts(clamp, parts)
    model = replace(model, fit=replace(model.fit, is_converged=is_converged))
    assert bool(model.freed) == is_freed
    refits = _Refits(())
    refits.left = left
    found = freed_effects._to_the_end(refits, model, basis)
    assert refits.ended == (is_freed and not is_converged)
    assert found.fit.chi_square == (left if is_better else 1.0) * model.fit.chi_square


@pytest.mark.parametrize(
    ('behind', 'gain', 'is_asked'), [(10.0, 30.0, True), (10.0, 5.0, True), (60.0, 90.0, False)]
)
def test_the_rival_of_one_that_is_free_is_free_as_well(
    screened, basis, monkeypatch, behind, gain, is_asked
):
    monkeypatch.setattr(freed_effects, 'judged', lambda models, *_, **__: list(models))
    camera = _judged(screened, basis, 'camera_offset', 0.05, 0.4)
    first = _with_parts(camera, freed_effects._request(camera).freed)
    scale = max(1.0, first.chi_square_per_patch)
    # Data say next to nothing of its form.
    bend = _judged(screened, basis, 'rest_curvature', 0.02, 0.03)
    rival = _likelier(bend, first.level - scale * behind - bend.level)
    refits = _Refits((scale * gain,))
    refits.model = rival
    found = freed_effects._with_its_rival_freed(refits, [first, rival], basis)
    assert refits.asked == ([len(EFFECTS['rest_curvature'].forms)] if is_asked else [])
    assert found[0].identifiers == (
        ('rest_curvature',) if is_asked and gain > behind else ('camera_offset',)
    )
    # One that has come to rest with a free form is not fitted again.
    free = _with_parts(rival, freed_effects._request(rival, 0.1).freed)
    for is_converged in (True, False):
        again = _Refits((-90.0,))
        again.model = replace(free, fit=replace(free.fit, is_converged=is_converged))
        freed_effects._with_its_rival_freed(again, [first, again.model], basis)
        assert len(again.asked) == (is_asked and not is_converged)


@pytest.mark.parametrize(
    ('behind', 'leaning', 'left', 'is_asked'),
    [
        (30.0, 80.0, 0.0, True),
        (10.0, 10.0, 0.0, False),
        (45.0, 80.0, 0.0, False),
        (40.0, 0.0, 90.0, True),
        (40.0, 0.0, 60.0, False),
    ],
)
def test_a_rival_is_free_where_a_form_that_is_fitted_may_bring_it_near(
    screened, basis, monkeypatch, behind, leaning, left, is_asked
):
    """By 0.4 of what it owes to forms to first order, or as far as leaving noise alone would."""
    monkeypatch.setattr(freed_effects, 'judged', lambda models, *_, **__: list(models))
    first = _judged(screened, basis, 'camera_offset', 0.05, 0.4)
    scale = max(1.0, first.chi_square_per_patch)
    bend = _judged(screened, basis, 'rest_curvature', 0.02, 0.03, leaning=leaning * scale)
    rival = _likelier(bend, first.level - scale * behind - bend.level)
    more = rival.judged.freedom + left * scale
    rival = replace(rival, judged=replace(rival.judged, chi_square=more))
    refits = _RefitsOf({'rest_curvature': (rival, 60.0 * scale), 'camera_offset': (first, -1.0)})
    found = freed_effects._with_its_rival_freed(refits, [first, rival], basis)
    # What is overtaken is free as well.
    assert refits.asked == (['rest_curvature', 'camera_offset'] if is_asked else [])
    best = ('rest_curvature',) if is_asked else ('camera_offset',)
    assert found[0].identifiers == best


@pytest.mark.parametrize(('gain', 'is_first'), [(30.0, True), (5.0, False)])
def test_what_is_overtaken_by_a_free_form_may_be_the_best_in_its_own(
    screened, basis, monkeypatch, gain, is_first
):
    monkeypatch.setattr(freed_effects, 'judged', lambda models, *_, **__: list(models))
    first = _judged(screened, basis, 'camera_offset', 0.05, 0.03)
    scale = max(1.0, first.chi_square_per_patch)
    bend = _judged(screened, basis, 'rest_curvature', 0.02, 0.03)
    rival = _likelier(bend, first.level - scale * 20.0 - bend.level)
    refits = _RefitsOf(
        {'rest_curvature': (rival, 30.0 * scale), 'camera_offset': (first, gain * scale)}
    )
    found = freed_effects._with_its_rival_freed(refits, [first, rival], basis)
    assert refits.asked == ['rest_curvature', 'camera_offset']
    assert (found[0].identifiers == ('camera_offset',)) == is_first
    assert all(model.freed for model in found)


def _with_a_lens(screened, basis) -> Hypothesis:
    """Return a camera that is another one in each pose and has another picture."""
    camera = _judged(screened, basis, 'camera_offset', 0.3, 0.4)
    parts = freed_effects._in_each(camera, camera.added[0].names, 0.3)
    lens = freed_effects.form_parameters(camera.added[0].effect, 0.4)
    return _with_parts(camera, [*parts, *lens])


@pytest.mark.parametrize(
    ('behind', 'leaning', 'is_one'),
    [
        ((-20.0, 90.0), 0.0, 'in form'),
        ((4.0, 90.0), 0.0, 'in form'),
        ((6.0, 90.0), 40.0, 'in form'),
        ((6.0, 6.0), 0.0, ''),
        ((90.0, 4.0), 0.0, 'in poses'),
        ((3.0, 1.0), 0.0, 'in poses'),
        ((1.0, 3.0), 0.0, 'in form'),
    ],
)
def test_what_does_as_well_with_one_freedom_has_one(
    screened, basis, monkeypatch, behind, leaning, is_one
):
    monkeypatch.setattr(freed_effects, 'judged', lambda models, *_, **__: list(models))
    free, asked = _with_a_lens(screened, basis), []
    assert free.is_free_in_everything
    scale = max(1.0, free.chi_square_per_patch)

    def refit_all(requests):
        asked.extend(requests)
        plain = _judged(screened, basis, 'camera_offset', 0.0, leaning=leaning * scale)
        models = [_with_parts(plain, request.freed) for request in requests]
        # What is in doubt of what it owes to forms is for it.
        return [
            _likelier(one, free.level - scale * own - one.log_evidence)
            for one, own in zip(models, behind, strict=True)
        ]

    found = freed_effects._free_in_one_way(SimpleNamespace(refit_all=refit_all), free, basis)
    form, poses = (request.freed for request in asked)
    assert {part.posture for part in form} == {None}
    assert {part.name.partition('@')[0] for part in poses} == set(free.added[0].names)
    assert None not in {part.posture for part in poses}
    assert found.freed == {'in form': form, 'in poses': poses, '': free.freed}[is_one]


def test_a_form_that_is_another_one_in_each_pose_belongs_to_no_freedom_of_poses(
    screened, basis, monkeypatch
):
    monkeypatch.setattr(freed_effects, 'judged', lambda models, *_, **__: list(models))
    free, asked = _with_a_lens(screened, basis), []
    names = [part.name for part in free.freed if part.posture is None]
    twice = _with_parts(free, [*free.freed, *freed_effects._in_each(free, names, 0.3)])

    def refit_all(requests):
        asked.extend(requests)
        return []

    found = freed_effects._free_in_one_way(SimpleNamespace(refit_all=refit_all), twice, basis)
    assert found is twice, 'nothing else can be simulated'
    poses = {part.name.partition('@')[0] for part in asked[1].freed}
    assert poses == set(free.added[0].names), 'a lens of each pose is a form'


@pytest.mark.parametrize(('gain', 'is_plain'), [(30.0, True), (-30.0, False)])
def test_a_form_that_stood_in_for_the_second_effect_is_taken_back(
    screened, basis, monkeypatch, gain, is_plain
):
    monkeypatch.setattr(freed_effects, 'judged', lambda models, *_, **__: list(models))
    pair, behind = _with_a_lens(screened, basis), _judged(screened, basis, 'clamp_offset', 0)
    plain, asked = _likelier(pair, gain), []

    def refit_all(requests):
        asked.extend(requests)
        return [plain]

    behind = replace(behind, judged=replace(behind.judged, log_evidence=pair.level - 99.0))
    found = with_less_freedom(SimpleNamespace(refit_all=refit_all), [behind, pair], basis)
    (request,) = asked
    assert {part.name.partition('@')[0] for part in request.freed} == set(pair.added[0].names)
    assert request.added == pair.added
    assert request.starts == pair.fit.values_by_name()
    assert (found[0] is plain) == is_plain
    assert found[1:] == [behind]


def test_what_is_another_one_in_each_pose_only_is_not_fitted_again(screened, basis):
    camera = _judged(screened, basis, 'camera_offset', 0.3)
    parts = freed_effects._in_each(camera, camera.added[0].names, 0.3)
    pairs = [_with_parts(camera, parts)]
    assert with_less_freedom(SimpleNamespace(), pairs, basis) == pairs
    assert with_less_freedom(SimpleNamespace(), pairs, None) == pairs
