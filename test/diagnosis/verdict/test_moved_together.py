# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A clamp that seems displaced with the fixture around it is none."""

from dataclasses import replace
import re
from types import SimpleNamespace

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.parameters.fixture_offset import fixture_offset_parameters
from diffcal_ros.calibration.parameters.form_parameters import posture_parameters
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.calibration.parameters.parameters import ParameterSet
from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects
from diffcal_ros.diagnosis.nominal_fit import fit_nominal
from diffcal_ros.diagnosis.screening.candidates import Candidate
from diffcal_ros.diagnosis.verdict.doubts import doubts_about
from diffcal_ros.diagnosis.verdict.moved_together import class_with_fixture, words_with_fixture
from diffcal_ros.diagnosis.verdict.naming import _class_of
import numpy as np
import pytest
from support.clamped_anew import beam_in_two_poses
from support.fixtured_beam import BLOCK, scene, seen, SHIFT
from support.scenes import DEPTH_FROM_WORLD, WORLD_FROM_OBJECT

CLAMP = Candidate('clamp_offset', ('x', 'y', 'z'))
TILT = Candidate('gravity_tilt', ('a', 'b'))
# What a clamp is displaced by in all poses, as the fixture is, and by more in each [m].
IN_COMMON, IN_EACH = 0.0008, (0.004, -0.004)


@pytest.fixture(scope='module')
def displaced():
    """Fits of a displaced clamp: the body alone elsewhere, and the block with it."""
    found = {}
    for name, block_shift in (('alone', np.zeros(3)), ('both', SHIFT)):
        observation = seen(body_shift=SHIFT, block_shift=block_shift)
        evaluator, nominal = fit_nominal(scene(), [observation], None)
        found[name] = nominal, try_effects(evaluator, nominal, [CLAMP], {})
    return found


def test_a_body_elsewhere_beside_its_fixture_is_a_displaced_clamp(displaced):
    nominal, model = displaced['alone']
    assert class_with_fixture(model) is None
    assert not any('fixture is displaced' in doubt for doubt in doubts_about(model, nominal))
    assert _class_of(model) == 'boundary'


def test_what_the_fixture_follows_has_no_name_and_is_of_the_class_sensor(displaced):
    nominal, model = displaced['both']
    own = model.fit.parameters.names.index('clamp_offset.z')
    assert abs(model.fit.coordinates[own]) > 0.002
    assert class_with_fixture(model) == 'sensor'
    (doubt,) = doubts_about(model, nominal)
    assert f'fixture is displaced as the clamp is, by {words_with_fixture(model)}' in doubt
    assert _class_of(model) == 'sensor'


@pytest.mark.slow
def test_other_effects_and_scenes_without_a_fixture_are_not_asked():
    for own, has_fixture in ((TILT, True), (CLAMP, False)):
        observation = seen(body_shift=SHIFT, block_shift=SHIFT)
        evaluator, nominal = fit_nominal(scene(has_fixture=has_fixture), [observation], None)
        assert class_with_fixture(try_effects(evaluator, nominal, [own], {})) is None


def test_it_is_told_how_far_and_along_which_axes_the_fixture_is_elsewhere(displaced):
    _, model = displaced['both']
    words = re.fullmatch(
        r'(\S+) mm \((\S+), (\S+), (\S+) along the axes of the object\) and (\S+) degrees',
        words_with_fixture(model),
    )
    size, *axes, turn = map(float, words.groups())
    # The shift is one of the camera's frame. Of one view a fixture's place is known to this.
    turn_of_object = (DEPTH_FROM_WORLD @ WORLD_FROM_OBJECT)[:3, :3]
    np.testing.assert_allclose(axes, 1e3 * turn_of_object.T @ SHIFT, atol=0.5)
    assert size == pytest.approx(np.linalg.norm(axes), abs=0.1)
    assert turn < 1.0


def _clamped_anew(in_each) -> SimpleNamespace:
    """Return a model in two poses whose clamp is displaced as the fixture is, and more in each."""
    known, observations = beam_in_two_poses(4)
    known = replace(known, fixture=BLOCK)
    every = make_parameters(known, ('clamp_offset',), with_edge_bias=False).parameters
    (clamp,) = (own for own in every if own.name.endswith('.z'))
    freed = posture_parameters([clamp], (0, 1), 1.0)
    own = ParameterSet((clamp, *freed, *fixture_offset_parameters()), ())
    model = ForwardModel(known, observations, own)
    values = {clamp.name: IN_COMMON, 'fixture_offset.z': IN_COMMON}
    values |= {part.name: more for part, more in zip(freed, in_each, strict=True)}
    coordinates = np.array([values.get(name, 0.0) for name in own.names])
    assert np.count_nonzero(coordinates) == len([v for v in values.values() if v])
    fit = SimpleNamespace(parameters=own, coordinates=coordinates)
    added = (Candidate('clamp_offset', ('z',)),)
    return SimpleNamespace(evaluator=SimpleNamespace(model=model), fit=fit, added=added)


@pytest.mark.parametrize(('in_each', 'expected'), [((0.0, 0.0), 'sensor'), (IN_EACH, None)])
def test_a_clamp_that_is_elsewhere_in_each_pose_is_not_where_the_fixture_is(in_each, expected):
    """What all poses have in common is as far off as fixtures are."""
    assert class_with_fixture(_clamped_anew(in_each)) == expected
