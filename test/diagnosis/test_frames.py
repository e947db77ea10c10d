# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Points and axes of a verdict are those that the model uses."""

from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.diagnosis.verdict.verdict_figures import frame_of
from diffcal_ros.rigid_transform import rotation_matrix
import numpy as np


def _moved(evaluator, fit, names, values):
    """Return the model with some more parameters, and its points at their values."""
    scene = evaluator.model.scene
    parameters = make_parameters(scene, names, with_edge_bias=False)
    model = evaluator.model.with_parameters(scene, parameters)
    start = parameters.start()
    for name, value in values.items():
        start[parameters.names.index(name)] = value
    return model, start, model.views(start)[0].points


def test_a_turned_camera_turns_about_the_point_that_is_told(screened):
    evaluator, fit, _ = screened
    names = ('youngs_modulus', 'rigid_offset')
    _, _, plain = _moved(evaluator, fit, names, {})
    turn = {'rigid_offset.rx': 0.03, 'rigid_offset.rz': -0.05}
    model, there, points = _moved(evaluator, fit, names, turn)
    about = np.array(frame_of('camera_offset', model, there)['about'])
    turned = (plain - about) @ rotation_matrix(np.array([0.03, 0.0, -0.05])).T + about
    np.testing.assert_allclose(points, turned, atol=1e-7)


def test_axes_are_unit_vectors_across_each_other(screened):
    evaluator, fit, _ = screened
    for name in ('gravity_tilt', 'rest_curvature'):
        frame = frame_of(name, evaluator.model, fit.coordinates)
        axes = np.array([frame['a'], frame['b']])
        np.testing.assert_allclose(axes @ axes.T, np.eye(2), atol=1e-7)


def test_effects_without_a_frame_have_none(screened):
    evaluator, fit, _ = screened
    assert frame_of('added_mass', evaluator.model, fit.coordinates) == {}
