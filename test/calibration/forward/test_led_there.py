# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is not found from far away is found by way of what lies between."""

from diffcal_ros.calibration.forward import led_there
from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.forward.led_there import lead_to
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.errors import NotSimulatedError
import numpy as np
import pytest
from support.moving_beams import moving_model, moving_scene
from support.scenes import beam_scene, observation, true_depth

# Curvature at rest [1/m] of a beam 0.1 m long: that of a circle of 16 mm is reached in steps.
BENT, COILED = 60.0, 90.0


def _model(*fit: str) -> ForwardModel:
    scene = beam_scene((4, 1, 1))
    parameters = make_parameters(scene, fit, with_edge_bias=False)
    return ForwardModel(scene, [observation(true_depth())], parameters)


def _counted(model: ForwardModel, monkeypatch) -> list[np.ndarray]:
    asked, solve = [], model.solve
    monkeypatch.setattr(model, 'solve', lambda at, warm=None: asked.append(at) or solve(at, warm))
    return asked


def test_a_far_bend_is_found_in_steps_and_is_an_equilibrium() -> None:
    model = _model('youngs_modulus', 'rest_curvature')
    start = model.parameters.start()
    model.at(start)
    there = start + np.array([0.0, BENT, 0.0])
    with pytest.raises(NotSimulatedError):
        model.at(there)
    lead_to(model, there)
    found = model.at(there)
    np.testing.assert_array_equal(found.coordinates, there)
    # Another way there ends in the same place.
    other = _model('youngs_modulus', 'rest_curvature')
    for bend in np.linspace(0.0, BENT, 13):
        way = other.at(start + np.array([0.0, bend, 0.0]))
    difference = found.states[0].positions - way.states[0].positions
    moved = found.states[0].positions - model.solve(start).states[0].positions
    assert np.abs(difference).max() < 1e-6 < 1e-2 < np.abs(moved).max()


def test_what_is_found_at_once_takes_one_evaluation(monkeypatch) -> None:
    model = _model('youngs_modulus', 'rest_curvature')
    start = model.parameters.start()
    asked = _counted(model, monkeypatch)
    lead_to(model, start + np.array([0.1, 2.0, -1.0]))
    assert len(asked) == 1
    lead_to(model, start + np.array([0.1, 2.0, -1.0]))
    assert len(asked) == 1, 'and none where it is'


@pytest.mark.slow
def test_where_no_way_leads_it_is_said_and_the_model_stays_of_use() -> None:
    model = _model('youngs_modulus', 'rest_curvature')
    start = model.parameters.start()
    before = model.at(start).states[0].positions.copy()
    with pytest.raises(NotSimulatedError):
        lead_to(model, start + np.array([0.0, 0.0, COILED]))
    np.testing.assert_allclose(model.at(start).states[0].positions, before, atol=1e-6)


def test_a_motion_is_not_led(monkeypatch) -> None:
    """It begins from rest, whatever was known before."""
    model = moving_model(moving_scene((4, 1, 1), fit=('youngs_modulus', 'density')), (0.02, 0.1))
    asked = []

    def fail(coordinates, warm=None):
        asked.append(coordinates)
        raise NotSimulatedError('too soft')

    monkeypatch.setattr(model, 'solve', fail)
    with pytest.raises(NotSimulatedError, match='too soft'):
        lead_to(model, model.parameters.start())
    assert len(asked) == 1


def test_a_model_with_other_parameters_begins_where_the_one_before_was() -> None:
    nominal = _model('youngs_modulus')
    softer = nominal.parameters.start() - 0.3
    nominal.at(softer)
    wide = make_parameters(
        nominal.scene, ('rest_curvature', 'youngs_modulus'), with_edge_bias=False
    )
    model = nominal.with_parameters(nominal.scene, wide)
    place = dict(zip(wide.names, model.place, strict=True))
    assert place['youngs_modulus'] == softer[0]
    assert [place['rest_curvature.a'], place['rest_curvature.b']] == [0.0, 0.0]
    there = model.place + [BENT if name == 'rest_curvature.a' else 0.0 for name in wide.names]
    lead_to(model, there)
    np.testing.assert_array_equal(model.place, there)


def test_steps_are_halved_where_one_fails_and_grow_again(monkeypatch) -> None:
    """No step is longer than a third here, so that halves fail."""
    model, reached, failed = _model('youngs_modulus'), [0.0], []
    start = model.parameters.start()
    solve = model.solve

    def near(coordinates, warm=None):
        share = float((coordinates - start)[0]) / 0.6
        if share - reached[-1] > 1.0 / 3.0:
            failed.append(share)
            raise NotSimulatedError('too far')
        reached.append(share)
        return solve(coordinates, warm)

    monkeypatch.setattr(model, 'solve', near)
    lead_to(model, start + 0.6)
    assert failed[:2] == pytest.approx([1.0, led_there._FIRST])
    steps = np.diff(reached)
    assert reached[-1] == pytest.approx(1.0)
    assert steps.max() <= 1.0 / 3.0
    assert steps[0] == pytest.approx(0.5 * led_there._FIRST)
