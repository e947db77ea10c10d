# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A name is no surer than what else could look like it allows."""

from types import SimpleNamespace
from typing import Any

from diffcal_ros.diagnosis.detection.limits import drawn_parameters
from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects
from diffcal_ros.diagnosis.patches.whitened import Part
from diffcal_ros.diagnosis.screening.candidates import Candidate
from diffcal_ros.diagnosis.verdict import verdict_figures
from diffcal_ros.diagnosis.verdict.verdict_figures import (
    drawn_beside,
    judged_part,
    named_effects,
    parameter_table,
    weight_doubt,
)
from diffcal_ros.effects.registry import EFFECTS
import numpy as np
import pytest

SURE = 0.99


@pytest.mark.parametrize('name', ['gravity_tilt', 'added_mass'])
def test_no_name_is_surer_than_names_have_been_right(screened, name):
    evaluator, fit, scores = screened
    candidate = next(s.candidate for s in scores.scores if s.candidate.identifier == name)
    found = try_effects(evaluator, fit, [candidate], {}, max_iterations=1)
    (effect,) = named_effects(found, {name: SURE})
    assert effect.confidence == EFFECTS[name].most_confidence < SURE
    # What is not sure already does not become less so.
    assert named_effects(found, {name: 0.3})[0].confidence == 0.3
    assert named_effects(found, {}) == ()


def test_of_a_form_what_is_most_of_its_usual_size_is_told():
    """Whatever the units: a focal length has another one than a distortion."""
    candidate = Candidate('camera_offset', ('x', 'y', 'z', 'rx', 'ry', 'rz'))
    first, second, *_ = candidate.effect.forms
    form = {first.name: 2.0 * first.scale, second.name: -3.0 * second.scale}
    most = f'{-3.0 * second.scale * second.shown_factor:.2g} {second.shown_unit}'
    assert verdict_figures._largest_part(candidate, form) == f'{second.name} {most}'


def test_what_a_known_cause_outside_the_library_imitates_is_less_sure_than_others():
    assert EFFECTS['gravity_tilt'].most_confidence < EFFECTS['added_mass'].most_confidence


@pytest.mark.parametrize(
    ('values', 'is_wider'), [({'gravity_tilt.a': 0.2, 'gravity_tilt.b': -0.1}, True), ({}, False)]
)
def test_a_modulus_beside_a_tilt_is_no_surer_than_a_push_allows(screened, values, is_wider):
    evaluator, fit, scores = screened
    name = 'gravity_tilt' if values else 'added_mass'
    candidate = next(s.candidate for s in scores.scores if s.candidate.identifier == name)
    found = try_effects(evaluator, fit, [candidate], values, max_iterations=1)
    own = found.evaluator.model.effects.amplitudes(found.fit.coordinates)[name]
    doubt = weight_doubt(found)
    assert doubt == EFFECTS[name].weight_doubt(own)
    assert (doubt > 0.02) == is_wider
    as_fitted, told = (
        parameter_table(found.fit, fit, weight_doubt=share) for share in (0.0, doubt)
    )
    modulus = told['youngs_modulus']
    before = as_fitted['youngs_modulus']
    assert modulus['std_error'] == pytest.approx(
        np.hypot(before['std_error'], doubt * modulus['value'])
    )
    assert modulus['value'] == before['value']


class _Known(list[Any]):
    """One parameter that was measured as 2 +- 0.1."""

    names = ('known',)
    pose_covariances = ()

    def __init__(self) -> None:
        quantity = SimpleNamespace(prior_mean=2.0, prior_std=0.1)
        own = SimpleNamespace(
            name='known', quantity=quantity, is_nuisance=False, is_logarithmic=False
        )
        own.coordinate = lambda value: value
        super().__init__([own])


@pytest.mark.parametrize(
    ('value', 'is_moving', 'part'),
    [
        (2.2, True, Part.REPORT),
        (2.5, True, Part.ALL),
        (1.5, True, Part.ALL),
        (2.5, False, Part.REPORT),
    ],
)
def test_what_a_motion_hides_in_a_parameter_is_judged_in_all_frames(value, is_moving, part):
    """Frames that are held out may all show the swing where it hides nothing."""
    fit: Any = SimpleNamespace(
        parameters=_Known(), coordinates=np.array([value]), of_the_body=lambda _: (value, 0.1)
    )
    assert judged_part(fit, is_moving=is_moving) is part


def test_a_mass_may_have_drawn_a_modulus_beside_a_named_tilt_as_well(screened):
    evaluator, fit, scores = screened
    tilt = next(s.candidate for s in scores.scores if s.candidate.identifier == 'gravity_tilt')
    found = try_effects(evaluator, fit, [tilt], {'gravity_tilt.b': 0.06})
    drawn = drawn_beside(found, scores)
    before = drawn_parameters(scores, fit.parameters)
    assert list(drawn) == list(before) == ['youngs_modulus']
    others = {s.candidate.identifier for s in scores.scores} - {'gravity_tilt'}
    assert set(drawn['youngs_modulus']) == set(before['youngs_modulus']) & others
    # Refitted with both, the modulus is no farther away than that.
    assert drawn['youngs_modulus']['added_mass'] > 0.05
    with_mass = try_effects(
        evaluator,
        fit,
        [tilt, Candidate('added_mass', ('mass',), 0.75)],
        found.fit.values_by_name(),
    )
    moved = with_mass.fit.coordinates[0] - found.fit.coordinates[0]
    assert abs(np.expm1(moved)) < drawn['youngs_modulus']['added_mass']
