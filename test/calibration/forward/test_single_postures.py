# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What an amplitude is more in one posture acts there alone, and adds to what it is in all."""

from dataclasses import replace

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.parameters.form_parameters import form_parameters
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.calibration.parameters.parameters import ParameterSet
from diffcal_ros.calibration.residuals.objective import RobustObjective
from diffcal_ros.effects.registry import EFFECTS
from diffcal_ros.rigid_transform import rotation_matrix, transform
from diffcal_ros.scene.model import Quantity
import numpy as np
import pytest
from support.scenes import beam_scene, observation, true_depth

# An amplitude of each effect that may be another one in each pose: in all, and more in the second.
_AMPLITUDES = {
    'clamp_offset.x': (0.001, 0.0015),
    'clamp_offset.rz': (0.01, -0.02),
    'compliant_clamp.compliance': (2.0, 1.5),
    'gravity_tilt.a': (0.03, 0.02),
    'rigid_offset.y': (0.002, -0.003),
    'rigid_offset.rx': (0.01, 0.015),
    # A lens that is focused anew.
    'rigid_offset.focal': (0.05, -0.08),
    'rigid_offset.y_xx': (0.1, 0.15),
}
_SECOND = 1


def _two_postures():
    """Hold the beam twice, the second time rolled about its length."""
    scene = beam_scene((4, 1, 1))
    setup = scene.observations[0]
    roll = transform(rotation_matrix(np.array([0.7, 0.0, 0.0])), np.zeros(3))
    rolled = replace(setup, name='rolled', world_from_object=setup.world_from_object @ roll)
    scene = replace(scene, observations=(setup, rolled))
    seen = observation(true_depth())
    return scene, [seen, replace(seen, name='rolled', setup_index=_SECOND)]


def _parameters(scene, name: str) -> ParameterSet:
    """Lay out an amplitude, a modulus, and last what the amplitude is more in the second."""
    head, _, _ = name.partition('.')
    wanted = head if head in ('rigid_offset', 'gravity_tilt') else name
    found = make_parameters(scene, (wanted, 'youngs_modulus'), with_edge_bias=False).parameters
    found = (*found, *form_parameters(EFFECTS['camera_offset'], 1.0))
    kept = [own for own in found if own.name in (name, 'youngs_modulus')]
    own = next(parameter for parameter in kept if parameter.name == name)
    free = Quantity(0.0, -1e3, 1e3, 0.0, 1.0)
    more = replace(own, name=f'{name}@{_SECOND}', quantity=free, posture=_SECOND)
    return ParameterSet((*kept, more))


def _model(name: str) -> tuple[ForwardModel, np.ndarray]:
    scene, seen = _two_postures()
    parameters = _parameters(scene, name)
    here, (whole, more) = parameters.start(), _AMPLITUDES[name]
    here[parameters.names.index(name)], here[-1] = whole, more
    return ForwardModel(scene, seen, parameters), here


def _points(model: ForwardModel, coordinates: np.ndarray) -> list[np.ndarray]:
    return [view.points for view in model.views(coordinates)]


@pytest.mark.parametrize('name', _AMPLITUDES)
def test_it_adds_to_the_amplitude_in_its_posture_and_in_no_other(name):
    model, here = _model(name)
    place = model.parameters.names.index(name)
    first, second = _points(model, here)
    in_all, both = here.copy(), here.copy()
    in_all[-1] = both[-1] = 0.0
    both[place] = sum(_AMPLITUDES[name])
    without, otherwise = _points(model, in_all), _points(model, both)
    np.testing.assert_allclose(first, without[0], atol=1e-9)
    np.testing.assert_allclose(second, otherwise[1], atol=1e-9)
    assert np.abs(second - without[1]).max() > 1e-4


@pytest.mark.parametrize('name', _AMPLITUDES)
def test_points_follow_it(name):
    model, here = _model(name)
    elsewhere, tangent = (own[-1] for own in model.tangents(here))
    assert not elsewhere.any()
    weights = 1.0 + np.arange(tangent.size).reshape(tangent.shape) % 7
    pulled = model.pull_back([np.zeros_like(weights), weights], here)
    assert pulled[-1] == pytest.approx(float((tangent * weights).sum()), rel=1e-6)
    size = abs(_AMPLITUDES[name][1])
    errors = []
    for step in (0.2 * size, 0.1 * size, 0.05 * size):
        ahead, behind = here.copy(), here.copy()
        ahead[-1], behind[-1] = here[-1] + step, here[-1] - step
        slope = (_points(model, ahead)[1] - _points(model, behind)[1]) / (2.0 * step)
        errors.append(np.abs(slope - tangent).max() / np.abs(tangent).max())
    assert errors[-1] < 2e-3
    assert errors[-1] <= max(0.5 * errors[0], 1e-5)


def test_an_amplitude_stays_within_its_bounds_in_each_posture():
    """No clamp pushes back: it gives way, or it does not."""
    model, here = _model('compliant_clamp.compliance')
    here[-1] = -10.0
    stiff = here.copy()
    stiff[model.parameters.names.index('compliant_clamp.compliance')], stiff[-1] = 0.0, 0.0
    np.testing.assert_allclose(_points(model, here)[1], _points(model, stiff)[1], atol=1e-9)


@pytest.mark.parametrize(
    ('name', 'more'), [('depth_affine.bias', 2e-3), ('depth_affine.scale', 0.01)]
)
def test_a_camera_reads_otherwise_in_one_posture(name, more):
    scene, seen = _two_postures()
    parameters = _parameters(scene, name)
    objective = RobustObjective(ForwardModel(scene, seen, parameters))
    here = parameters.start()
    views = objective.model.views(here)
    exact = [objective.read_depth(number, view, here) for number, view in enumerate(views)]
    here[-1] = more
    read = [objective.read_depth(number, view, here) for number, view in enumerate(views)]
    np.testing.assert_array_equal(read[0], exact[0])
    error = more * exact[1] if name.endswith('scale') else np.full_like(exact[1], more)
    shown = np.isfinite(exact[1])
    np.testing.assert_allclose((read[1] - exact[1])[shown], error[shown], rtol=1e-9)
    columns = []
    for number, comparison in enumerate(objective.comparisons(here)):
        tangent = objective.model.tangents(here)[number]
        (_, by_depth), _ = objective.with_jacobians(
            number, comparison, views[number], tangent, here
        )
        columns.append(by_depth[:, -1])
    assert not columns[0].any()
    assert (columns[1] > 0.0).all()
