# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body that is bent in one place at rest: fitted as such, told, and taken into the model."""

from dataclasses import replace

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.diagnosis.diagnose import diagnose, DiagnosisTrace
from diffcal_ros.diagnosis.model_comparison.freedom import freeing_request
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.verdict.acceptance import accept
from diffcal_ros.diagnosis.verdict.verdict import save_verdict
from diffcal_ros.diagnosis.verdict.verdict_figures import (
    details_of,
    named_effects,
    of_another_form,
)
from diffcal_ros.effects.registry import EFFECTS
from diffcal_ros.scene.load import load_scene
import numpy as np
import pytest
from support.scenes import beam_scene, MODULUS, observation, true_depth
from support.watched import several_frames

_SURE = {'rest_curvature': 1.0}
_BENT = 8.0  # In the third of six parts of the length [1/m].

pytestmark = pytest.mark.slow


@pytest.fixture(scope='module')
def trace() -> DiagnosisTrace:
    scene = replace(
        beam_scene((12, 3, 3)), effects={'rest_curvature': {'a': 0.0, 'b': 0.0, 'a_3': _BENT}}
    )
    parameters = make_parameters(scene, ('youngs_modulus',), with_edge_bias=False)
    model = ForwardModel(scene, [observation(true_depth())], parameters)
    exact = model.views(parameters.start())[0].trace.full_depth()
    seen = several_frames(exact, np.random.default_rng(1))
    return diagnose(beam_scene((8, 2, 2)), [seen])


@pytest.fixture(scope='module')
def arc(trace) -> Hypothesis:
    return next(
        h for h in trace.selection.singles if h.identifiers == ('rest_curvature',) and not h.freed
    )


@pytest.fixture(scope='module')
def kink(trace, arc) -> Hypothesis:
    wanted = replace(arc, judged=replace(arc.judged, fraction=1.0))
    pool = RefitPool(trace.evaluator, trace.nominal)
    (found,) = pool.refit_all([freeing_request(wanted)])
    return found


def test_it_is_fitted_where_an_arc_is_not(arc, kink):
    assert kink.fit.log_evidence > arc.fit.log_evidence + 10.0
    assert kink.fit.chi_square < 0.5 * arc.fit.chi_square
    (effect,) = named_effects(kink, _SURE)
    assert set(effect.form) == {part.name for part in EFFECTS['rest_curvature'].forms}
    along = {name: size for name, size in effect.form.items() if name.startswith('a_')}
    assert max(along, key=lambda name: abs(along[name])) in ('a_2', 'a_3', 'a_4')
    (said,) = of_another_form(kink)
    most = max(effect.form, key=lambda name: abs(effect.form[name]))
    share = (int(most[-1]) - 0.5) / 6.0
    assert said == (
        'rest_curvature is of another form than the library has: its curvature is another one '
        f'along the body, or it is twisted (most of all {effect.form[most]:.2g} 1/m about '
        f'{most[0]}, at {share:.0%} of its length)'
    )
    assert named_effects(arc, _SURE)[0].form == {}
    assert of_another_form(arc) == []
    # Free to be of another form, and of the library's all the same.
    free = [part.is_freed for part in kink.fit.parameters]
    coordinates = np.where(free, 1e-6, 1.0) * kink.fit.coordinates
    assert of_another_form(replace(kink, fit=replace(kink.fit, coordinates=coordinates))) == []


def test_the_modulus_heals(arc, kink):
    errors = [abs(np.exp(h.fit.coordinates[0]) / MODULUS - 1.0) for h in (arc, kink)]
    assert errors[1] < min(0.1, errors[0])


def test_the_model_takes_it_as_it_was_fitted(trace, kink, write_scene, tmp_path):
    path = write_scene({})
    (effect,) = named_effects(kink, _SURE)
    details = details_of(trace.nominal, trace.screen, trace.selection, None)
    details['scene'], details['recordings'] = str(path), []
    details['candidates'] = [
        {**details['candidates'][0], **vars(effect)},
    ]
    save_verdict(replace(trace.diagnosis, details=details), tmp_path / 'verdict.json')
    accept(tmp_path, ['rest_curvature'])
    taken = load_scene(path).effects['rest_curvature']
    for name, size in effect.form.items():
        assert taken[name] == pytest.approx(size)
    plain = make_parameters(
        replace(trace.evaluator.model.scene, effects={'rest_curvature': taken}),
        ('youngs_modulus',),
        with_edge_bias=False,
    )
    scene = replace(trace.evaluator.model.scene, effects={'rest_curvature': taken})
    model = ForwardModel(scene, trace.evaluator.model.observations, plain)
    fitted = kink.evaluator.model.worlds(kink.fit.coordinates)[0]
    again = model.worlds(kink.fit.coordinates[:1])[0]
    np.testing.assert_allclose(again, fitted, atol=1e-7)
