# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effects that scores put far behind are looked at where the best one leaves too much."""

from dataclasses import replace
from types import SimpleNamespace

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.diagnosis.model_comparison import looks_in_any_form
from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects
from diffcal_ros.diagnosis.model_comparison.form_sizes import with_favoured_sizes
from diffcal_ros.diagnosis.model_comparison.judged_models import judge_by, judged, nominal_basis
from diffcal_ros.diagnosis.model_comparison.looks_in_any_form import others_in_any_form
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.nominal_fit import fit_nominal
from diffcal_ros.diagnosis.screening.candidates import candidates, parameters_of
from diffcal_ros.diagnosis.screening.screening import Screen, screen
from diffcal_ros.diagnosis.screening.shortlist import distinct
from diffcal_ros.effects.registry import EFFECTS
import numpy as np
import pytest
from support.scenes import beam_scene, observation, true_depth
from support.watched import several_frames, watched, with_step

AS_IT_IS = SimpleNamespace(freed=())
# Of the two halves of a length, bent at rest to opposite sides [1/m].
_BENT = {'a': 0.0, 'b': 0.0, 'a_2': 7.0, 'a_5': -7.0}


def test_effects_that_were_not_refitted_are_looked_at_where_much_is_left(too_far, scores):
    pool = RefitPool(*too_far)
    judge = judge_by(nominal_basis(pool))
    listed = {s.candidate.identifier: s.candidate for s in scores.scores[::-1]}
    tried = [try_effects(*too_far, [listed[n]], {}) for n in ('depth_affine', 'gravity_tilt')]
    right, wrong = judge(tried)
    assert right.chance_of_noise > 0.05 > wrong.chance_of_noise
    # Where noise alone is left nothing is looked at.
    assert others_in_any_form(SimpleNamespace(), scores, [right, wrong], judge) == []
    (found,) = others_in_any_form(pool, scores, [wrong], judge)
    assert found.identifiers == ('depth_affine',)
    assert found.fit.log_evidence > wrong.fit.log_evidence + 10.0


def test_what_leaves_noise_by_another_form_than_the_librarys_is_not_the_last_word(
    too_far, scores, monkeypatch
):
    pool, looked = RefitPool(*too_far), []
    judge = judge_by(nominal_basis(pool))
    listed = {s.candidate.identifier: s.candidate for s in scores.scores[::-1]}
    (right,) = judge([try_effects(*too_far, [listed['depth_affine']], {})])

    def are_in_reach(models, rivals, judge):
        looked.extend((model.identifiers, model.fit.evaluations) for model in models)
        return [False] * len(models)

    monkeypatch.setattr(looks_in_any_form, 'are_in_reach', are_in_reach)
    monkeypatch.setattr(looks_in_any_form, '_SEEN_AT_ALL', 0.0)
    for owed in (10.0, 60.0):
        assert looked == []
        lean = replace(right, judged=replace(right.judged, exact=right.log_evidence - owed))
        others_in_any_form(pool, scores, [lean], judge)
    # One step moves the effect, the second lets the parameters that it had drawn go back.
    assert looked == [(('gravity_tilt',), 2)]


@pytest.fixture(scope='module')
def bent():
    """A fit of a beam that is bent as an S at rest, by a model that knows nothing of it."""
    scene = replace(beam_scene((12, 3, 3)), effects={'rest_curvature': _BENT})
    parameters = make_parameters(scene, ('youngs_modulus',), with_edge_bias=False)
    model = ForwardModel(scene, [observation(true_depth())], parameters)
    exact = model.views(parameters.start())[0].trace.full_depth()
    seen = several_frames(exact, np.random.default_rng(1))
    return fit_nominal(beam_scene((8, 2, 2)), [seen], None)


@pytest.fixture(scope='module')
def scores_of_the_bent(bent):
    evaluator, nominal = bent
    wanted = ('rest_curvature', 'added_mass', 'stiffness_contrast')
    listed = [c for c in candidates(evaluator.model.scene) if c.identifier in wanted]
    return distinct(screen(evaluator, nominal.coordinates, listed).scores)


@pytest.mark.slow
def test_what_no_form_of_the_library_shows_is_fitted_with_its_form_free(bent, scores_of_the_bent):
    pool = RefitPool(*bent)
    requests = looks_in_any_form._led_by_their_freedom(pool, scores_of_the_bent, 0.0, AS_IT_IS)
    by_name = {own.identifier: request for request in requests for own in request.added}
    request = by_name['rest_curvature']
    form = EFFECTS['rest_curvature'].forms
    assert [part.amplitude for part in request.freed] == [part.name for part in form]
    (free,) = pool.refit_all([request])
    (arc,) = pool.refit_all([replace(request, freed=(), max_iterations=12)])
    sized = with_favoured_sizes(pool, free)
    assert free.fit.chi_square < 0.3 * arc.fit.chi_square
    free, arc = judged([free, arc], nominal_basis(pool))
    assert free.level > arc.level + 50.0
    # It is bent about one axis, and not twisted: what it may be about the other costs nothing.
    before, after = (_largest_sizes(model) for model in (free, sized))
    assert after['a'] >= before['a']
    assert after['b'] < 0.2 * before['b']
    assert after['twist'] < 0.2 * before['twist']
    # What is believed to be next to nothing is no number that the data tell.
    own = parameters_of(sized.fit.parameters, sized.added)
    assert len(own) == 15
    assert 2.0 < sized.freedom_of(own) < free.freedom_of(own) - 3.0
    assert free.freedom_of(own) < 15.0
    assert sized.freedom_of(own[:2]) == 2.0, 'those of the library count whole'
    assert sized.chance_of_zero(sized.added[0]) < 1e-6
    (sized,) = judged([sized], nominal_basis(pool))
    assert sized.level > free.level + 5.0
    (ended,) = judged(pool.finish([sized], [-np.inf]), nominal_basis(pool))
    assert ended.level == pytest.approx(sized.level, abs=3.0), 'it is so to first order'
    assert [own.quantity for own in ended.freed] == [own.quantity for own in sized.freed]


def _largest_sizes(model):
    """Return the largest standard deviation of each way of a free form."""
    found = {}
    for own in model.freed:
        way = own.amplitude.partition('_')[0]
        found[way] = max(found.get(way, 0.0), own.quantity.prior_std)
    return found


def test_what_came_to_nothing_in_the_librarys_form_is_looked_at_in_another(
    bent, scores_of_the_bent, monkeypatch
):
    pool, asked = RefitPool(*bent), []
    judge = judge_by(nominal_basis(pool))
    (listed,) = (s for s in scores_of_the_bent if s.candidate.identifier == 'rest_curvature')
    (arc,) = judge([try_effects(*bent, [listed.candidate], {})])
    scores = Screen(tuple(scores_of_the_bent), 0.0, 1.0, 0, lambda columns: columns)

    def led(pool, scores, known_gain, best):
        asked.append({score.candidate.identifier for score in scores})
        return []

    monkeypatch.setattr(looks_in_any_form, '_led_by_their_freedom', led)
    monkeypatch.setattr(looks_in_any_form, '_SEEN_AT_ALL', np.inf)
    for may_be_absent in (False, True):
        monkeypatch.setattr(
            looks_in_any_form, 'has_doubtful_effect', lambda single, base, a=may_be_absent: a
        )
        assert others_in_any_form(pool, scores, [arc], judge) == []
    there, absent = asked
    assert 'rest_curvature' not in there
    assert absent == there | {'rest_curvature'}


def test_what_other_effects_show_as_well_to_first_order_is_not(bent, scores_of_the_bent):
    pool = RefitPool(*bent)
    led = looks_in_any_form._led_by_their_freedom
    assert led(pool, scores_of_the_bent, 1e6, AS_IT_IS) == []
    # Nor is what the library's form shows as well, which is looked at anyway.
    seen = [replace(score, gain=1e6) for score in scores_of_the_bent]
    assert led(pool, seen, 0.0, AS_IT_IS) == []


@pytest.mark.parametrize(('step', 'is_seen'), [(0.008, True), (0.0003, False)])
@pytest.mark.slow_but_first
def test_a_step_that_a_fit_has_left_out_is_looked_at(step, is_seen):
    scene = replace(beam_scene((8, 2, 2)), effects={'depth_bias_by_region': {'at': 0.5}})
    evaluator, nominal = fit_nominal(scene, [with_step(watched(seed=4), 0.5, step)], None)
    listed = {c.identifier: c for c in candidates(evaluator.model.scene)}
    pool = RefitPool(evaluator, nominal)
    seen = looks_in_any_form._is_seen_otherwise(pool, listed['depth_bias_by_region'])
    assert seen == is_seen
    assert not looks_in_any_form._is_seen_otherwise(pool, listed['gravity_tilt'])
