# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Rest lengths from depth images: data from a finer mesh, far and slack starts, several cables."""

from dataclasses import replace

from diffcal_ros.calibration.calibrate import calibrate
from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.calibration.results.outcome import Outcome
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.calibration.whole_image.image_objective import ImageObjective
from diffcal_ros.errors import SceneError
from diffcal_ros.fem.elements.element import Element
import numpy as np
import pytest
from support.fingers import cable, filmed, finger_scene, via_points

PULL = 0.024
# What the issue asks for: within one percent, or inside the 95 % interval.
CLOSE = 0.01


@pytest.fixture(scope='module')
def seen():
    return filmed(cable('tendon', PULL, via_points()))


def is_found(parameter, truth: float) -> bool:
    error = abs(parameter.value - truth)
    return error <= CLOSE * truth or error <= 1.96 * parameter.std_error


@pytest.mark.parametrize(
    'start', [0.002, *(pytest.param(far, marks=pytest.mark.slow) for far in (0.045, -0.02))]
)
def test_rest_length_is_found_from_far_starts_and_from_slack(seen, start) -> None:
    result = calibrate(finger_scene(cable('tendon', start, via_points())), [seen])
    truth = cable('tendon', PULL, via_points()).rest_length.start
    assert result.outcome is Outcome.CONVERGED
    assert is_found(result['rest_length'], truth)
    # The mesh's own error, and so the interval, must not hide a fit that went elsewhere.
    assert abs(result['rest_length'].value - truth) < 0.15 * PULL
    said = [warning for warning in result.warnings if 'was slack at its start' in warning]
    assert len(said) == (1 if start < 0.0 else 0)


def test_slack_that_the_data_show_stays_slack() -> None:
    """Nothing is made up where no cable pulls: any longer length would do."""
    loose = filmed(cable('tendon', -0.02, via_points()))
    result = calibrate(
        finger_scene(cable('tendon', -0.01, via_points())),
        [loose],
        CalibrationSettings(with_mesh_error=False),
    )
    start = cable('tendon', 0.0, via_points()).rest_length.start
    assert result.outcome is Outcome.NOT_IDENTIFIABLE
    assert result['rest_length'].value > 0.995 * start
    assert result.gap_end.median < 1e-3


@pytest.mark.parametrize('start', [-0.01, pytest.param(0.03, marks=pytest.mark.slow)])
@pytest.mark.slow
def test_cable_that_another_one_slackens_is_not_made_up(start) -> None:
    """The left one bends the finger so far that the right one hangs slack, whatever its length."""
    places = {'left': via_points(0.006), 'right': via_points(0.024)}
    seen = filmed(cable('left', 0.026, places['left']), cable('right', 0.010, places['right']))
    starts = {'left': 0.02, 'right': start}
    scene = finger_scene(*(cable(name, pull, places[name]) for name, pull in starts.items()))
    result = calibrate(scene, [seen])
    assert result.outcome is Outcome.NOT_IDENTIFIABLE
    assert any('rest_length.right' in warning for warning in result.warnings)
    truth = cable('left', 0.026, places['left']).rest_length.start
    assert is_found(result['rest_length.left'], truth)


def test_two_cables_are_told_apart() -> None:
    truths = {'left': 0.020, 'right': 0.012}
    places = {'left': via_points(0.006), 'right': via_points(0.024)}
    seen = filmed(*(cable(name, pull, places[name]) for name, pull in truths.items()))
    # One starts taut, the other slack.
    starts = {'left': 0.01, 'right': -0.01}
    scene = finger_scene(*(cable(name, pull, places[name]) for name, pull in starts.items()))
    result = calibrate(scene, [seen])
    for name, pull in truths.items():
        truth = cable(name, pull, places[name]).rest_length.start
        assert is_found(result[f'rest_length.{name}'], truth), name
        assert abs(result[f'rest_length.{name}'].value - truth) < 0.2 * pull
    assert any('cable right was slack' in warning for warning in result.warnings)


@pytest.mark.slow
def test_known_pulls_of_several_postures_share_one_rest_length() -> None:
    """Two takes of the same tendon, pulled by 8 and 20 mm from the same unknown length."""
    hidden = 0.004
    films = [
        filmed(cable('tendon', hidden + pull, via_points()), seed=seed)
        for seed, pull in enumerate((0.008, 0.020))
    ]
    takes = [replace(film, setup_index=index) for index, film in enumerate(films)]
    scene = finger_scene(cable('tendon', 0.0, via_points()))
    (setup,) = scene.observations
    setups = tuple(
        replace(setup, name=f'take_{pull}', pulls={'tendon': pull}) for pull in (0.008, 0.020)
    )
    result = calibrate(replace(scene, observations=setups), takes)
    truth = cable('tendon', hidden, via_points()).rest_length.start
    assert is_found(result['rest_length'], truth)
    assert abs(result['rest_length'].value - truth) < 0.004


@pytest.mark.parametrize('element', Element)
@pytest.mark.slow_but_first
def test_whole_chain_derivative_by_rest_length_and_stiffness(seen, element) -> None:
    """Node positions before the camera, at three steps; and the adjoint of an image loss."""
    scene = finger_scene(
        cable('tendon', 0.02, via_points()),
        cable('other', 0.01, via_points(0.007, 0.02)),
        fit=('rest_length', 'cable_stiffness.other', 'youngs_modulus'),
        element=element,
    )
    # Soft, so that its stiffness matters.
    soft = tuple(replace(c, stiffness=replace(c.stiffness, start=300.0)) for c in scene.cables)
    scene = replace(scene, cables=soft)
    parameters = make_parameters(scene, with_edge_bias=False)
    model = ForwardModel(scene, [seen], parameters)
    here = parameters.start()
    (tangents,) = model.tangents(here)
    for place, name in enumerate(parameters.names):
        size = 1e-3 if name.startswith('rest_length') else 2e-2
        direction = np.eye(len(here))[place]
        errors = []
        for step in (size, size / 2.0, size / 4.0):
            ahead = model.views(here + step * direction)[0].points
            behind = model.views(here - step * direction)[0].points
            difference = (ahead - behind) / (2.0 * step)
            errors.append(
                np.linalg.norm(difference - tangents[place]) / np.linalg.norm(tangents[place])
            )
        assert errors[-1] < 2e-3, (name, errors)
        assert errors[-1] < 0.5 * errors[0] or max(errors) < 1e-5, (name, errors)
    weights = np.random.default_rng(8).normal(size=tangents[0].shape)
    model.views(here)
    pulled = model.pull_back([weights], here)
    np.testing.assert_allclose(pulled, np.einsum('kni,ni->k', tangents, weights), rtol=1e-7)


def test_whole_image_losses_know_cables(seen) -> None:
    scene = finger_scene(cable('tendon', 0.02, via_points()))
    parameters = make_parameters(scene, with_edge_bias=False)
    model = ForwardModel(scene, [seen], parameters)
    objective = ImageObjective(model, 'paper')
    here = parameters.start()
    before, after = (objective.cost(here + step) for step in (0.0, -0.002))
    assert after < before


def test_slack_cable_leaves_the_body_where_it_is_without(seen) -> None:
    plain = finger_scene(fit=('youngs_modulus',))
    slack = finger_scene(cable('tendon', -0.05, via_points()), fit=('youngs_modulus',))
    parameters = make_parameters(plain, with_edge_bias=False)
    there, loose = (
        ForwardModel(scene, [seen], parameters).views(parameters.start())[0].points
        for scene in (plain, slack)
    )
    np.testing.assert_allclose(loose, there, atol=1e-9)


def test_unknown_cables_cannot_be_fitted() -> None:
    scene = finger_scene(cable('tendon', 0.01, via_points()))
    with pytest.raises(SceneError, match=r"cannot fit 'rest_length.other': .* are tendon"):
        make_parameters(scene, ('rest_length.other',))
    with pytest.raises(SceneError, match=r"cannot fit 'rest_length': .* are none"):
        make_parameters(finger_scene(), ('rest_length',))
