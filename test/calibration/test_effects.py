# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effects as parameters of a fit: tangents by differences, stated and fitted values agree."""

from dataclasses import replace

from diffcal_ros.calibration.calibrate import calibrate
from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.calibration.residuals.objective import RobustObjective
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.effects.registry import EFFECTS
from diffcal_ros.errors import InputError
from diffcal_ros.rigid_transform import rotation_matrix, transform
import numpy as np
import pytest
from support.scenes import beam_scene, noisy, observation, true_depth

_NAMES = [name for name, effect in EFFECTS.items() if not effect.is_fitted_whole]
# Values away from zero, in usual sizes of each component.
_AWAY = (0.5, -0.3, 0.4, 0.6, -0.4, 0.3)
_PLANE_HEIGHT = -0.060
_BODY_EFFECTS = [n for n in _NAMES if EFFECTS[n].group != 'sensor' and not EFFECTS[n].needs_motion]


def _coordinates(parameters) -> np.ndarray:
    start = parameters.start()
    for place, parameter in enumerate(parameters):
        if parameter.component is not None:
            sign = 1.0 if parameter.component.lower < 0.0 else np.sign(_AWAY[parameter.target])
            start[place] = sign * _AWAY[parameter.target] * parameter.component.scale
        if parameter.name == 'contact_plane.height':
            start[place] = _PLANE_HEIGHT
    return start


def _rolled(scene, angle: float):
    """Turn the body about its length before it is placed."""
    setup = scene.observations[0]
    roll = transform(rotation_matrix(np.array([angle, 0.0, 0.0])), np.zeros(3))
    placed = setup.world_from_object @ roll
    return replace(scene, observations=(replace(setup, world_from_object=placed),))


@pytest.mark.parametrize('roll', [0.0, -2.2])
@pytest.mark.parametrize('effect', _BODY_EFFECTS)
def test_points_follow_amplitudes(effect, roll):
    """A placement that is turned, a modulus that differs along the body, a tilted camera.

    Rolled, the body's axes point to the other side in the world than they do in its own frame.
    """
    scene = _rolled(beam_scene((4, 1, 1), region_count=2), roll)
    parameters = make_parameters(scene, (effect, 'youngs_modulus.part_1'), with_edge_bias=False)
    model = ForwardModel(scene, [observation(true_depth())], parameters)
    here = _coordinates(parameters)
    tangents = model.tangents(here)[0]
    weights = 1.0 + (np.arange(tangents[0].size).reshape(tangents[0].shape) % 7)
    by_adjoint = model.pull_back([weights], here)
    np.testing.assert_allclose(by_adjoint, (tangents * weights).sum(axis=(1, 2)), rtol=1e-6)
    for place, parameter in enumerate(parameters):
        assert np.abs(tangents[place]).max() > 0.0, parameter.name
        usual = 1.0 if parameter.component is None else parameter.component.scale
        errors = []
        for step in (0.02 * usual, 0.01 * usual, 0.005 * usual):
            moved = np.zeros(len(here))
            moved[place] = step
            ahead = model.views(here + moved)[0].points
            behind = model.views(here - moved)[0].points
            slope = (ahead - behind) / (2.0 * step)
            errors.append(
                np.linalg.norm(slope - tangents[place]) / np.linalg.norm(tangents[place])
            )
        assert min(errors) < 2e-3, (parameter.name, errors)
        assert errors[-1] < 0.01, (parameter.name, errors)


def test_depth_follows_the_sensor():
    scene = beam_scene((6, 2, 2), region_count=2)
    names = ('depth_affine', 'depth_bias_by_region')
    parameters = make_parameters(scene, names, with_edge_bias=False)
    model = ForwardModel(scene, [observation(true_depth())], parameters)
    objective = RobustObjective(model)
    here = parameters.start()
    tangent = model.tangents(here)[0]
    comparison, view = objective.comparisons(here)[0], model.views(here)[0]
    _, jacobian = objective.with_jacobians(0, comparison, view, tangent, here)[0]
    for place in range(len(here)):
        moved = here.copy()
        moved[place] += 1e-4
        change = objective.comparisons(moved)[0].difference - comparison.difference
        places = comparison.depth.indices
        np.testing.assert_allclose(-change.ravel()[places], 1e-4 * jacobian[:, place], atol=1e-12)
    assert 0.2 < jacobian[:, 2].mean() < 0.8, 'both materials are in view'


@pytest.mark.parametrize('effect', _NAMES)
def test_a_stated_effect_is_the_fitted_one(effect):
    scene = beam_scene((6, 2, 2), region_count=2)
    parameters = make_parameters(scene, (effect,), with_edge_bias=False)
    seen = [observation(true_depth())]
    here = _coordinates(parameters)
    fitted = ForwardModel(scene, seen, parameters)
    amplitudes = fitted.effects.amplitudes(here)
    stated = replace(scene, effects={effect: dict(amplitudes[effect])})
    plain = make_parameters(stated, ('rigid_offset',), with_edge_bias=False)
    other = ForwardModel(stated, seen, plain)
    np.testing.assert_array_equal(
        other.views(plain.start())[0].points, fitted.views(here)[0].points
    )
    assert other.sensor(plain.start(), 0) == fitted.sensor(here, 0)


def test_amplitudes_of_zero_are_the_model_without():
    scene, seen = beam_scene((6, 2, 2)), [observation(true_depth())]
    plain = make_parameters(scene, ('rigid_offset',), with_edge_bias=False)
    nothing = ForwardModel(scene, seen, plain).views(plain.start())[0]
    names = tuple(name for name in _NAMES if name != 'contact_plane')
    zeros = make_parameters(scene, names, with_edge_bias=False)
    there = ForwardModel(scene, seen, zeros).views(zeros.start())[0]
    np.testing.assert_array_equal(nothing.points, there.points)
    np.testing.assert_array_equal(nothing.trace.depth, there.trace.depth)


@pytest.mark.slow
def test_a_hidden_tilt_of_gravity_is_found(random):
    tilt = np.deg2rad(4.0)
    gravity = 9.8 * np.array([0.0, -np.cos(tilt), np.sin(tilt)])
    depth = noisy(true_depth(gravity=gravity), random)
    result = calibrate(
        beam_scene((12, 3, 3)),
        [observation(depth)],
        CalibrationSettings(fit=('youngs_modulus', 'gravity_tilt')),
    )
    values = result.values()
    assert values['gravity_tilt.a'] == pytest.approx(-tilt, abs=np.deg2rad(1.0))
    fitted = result['youngs_modulus']
    assert abs(fitted.value - 60e3) < 2.5 * fitted.std_error < 15e3


def test_image_losses_refuse_effects():
    settings = CalibrationSettings(fit=('youngs_modulus', 'added_mass'), loss='paper')
    with pytest.raises(InputError, match='robust'):
        calibrate(beam_scene(), [observation(true_depth())], settings)


def test_every_effect_has_twins_and_bounds_that_hold_zero():
    for effect in EFFECTS.values():
        assert set(effect.twins) <= set(EFFECTS)
        assert effect.twins
        assert effect.identifier not in effect.twins
        for part in effect.components:
            assert part.lower <= 0.0 < part.upper
            assert part.scale > 0.0
