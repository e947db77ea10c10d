# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Solutions are values: whatever bodies are asked for meanwhile, they stay and can be asked."""

from dataclasses import replace

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.forward.solution import Solution
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.scene.model import QUASI_STATIC
import numpy as np
import pytest
from support.moving_beams import moving_model, moving_scene
from support.scenes import beam_scene, observation, true_depth

# On the support, and after it has let go.
TIMES = (0.02, 0.15, 0.3)
# Of what equilibria are found to: a factorisation of another state is iterated with.
_SAME = 1e-6


EFFECTS = {'compliant_clamp': {'compliance': 0.5}, 'rest_curvature': {'a': 0.8, 'b': -0.5}}


def _resting(effects=EFFECTS) -> ForwardModel:
    scene = replace(beam_scene((4, 1, 1)), effects=effects)
    fit = ('youngs_modulus', 'density', 'rigid_offset')
    parameters = make_parameters(scene, fit, with_edge_bias=False)
    return ForwardModel(scene, [observation(true_depth())], parameters)


def _released(**kwargs) -> ForwardModel:
    return moving_model(
        moving_scene((4, 1, 1), fit=('youngs_modulus', 'density'), **kwargs), TIMES
    )


MODELS = {
    'resting': _resting,
    'held load': lambda: _released(modulus=150e3, integrator=QUASI_STATIC),
    'moving': lambda: _released(tolerance=1e-4),
}


@pytest.fixture(params=MODELS)
def model(request) -> ForwardModel:
    return MODELS[request.param]()


def test_a_solution_can_be_asked_after_another_model_has_moved_its_bodies(model) -> None:
    start = model.parameters.start()
    here = model.with_tangents(model.solve(start))
    points = [view.points.copy() for view in here.views]
    weights = np.cos(np.arange(points[0].size)).reshape(points[0].shape)
    before = model.pull_back([weights] * len(points), start)
    other = model.with_parameters(model.scene, model.parameters)
    there = other.with_tangents(other.solve(start + 0.3 * np.eye(len(start))[0]))
    assert np.abs(there.views[-1].points - points[-1]).max() > 1e-4
    for view, kept in zip(here.views, points, strict=True):
        np.testing.assert_array_equal(view.points, kept)
    again = model.with_tangents(replace(here, tangents=None))
    size = np.abs(here.tangents[0]).max()
    assert np.abs(again.tangents[0] - here.tangents[0]).max() < _SAME * size
    assert np.abs(there.tangents[0] - here.tangents[0]).max() > 1e-3 * size
    other.solve(start + 0.3 * np.eye(len(start))[0])
    pulled = model.pull_back([weights] * len(points), start)
    np.testing.assert_allclose(pulled, before, rtol=_SAME, atol=_SAME * np.abs(before).max())


def test_a_warm_start_ends_where_a_cold_one_does(model) -> None:
    start = model.parameters.start()
    there = start + 0.05 * np.eye(len(start))[0]
    # The steps of a motion are those of the start: both begin with it.
    first = model.solve(start)
    cold = model.solve(there, first)
    warm = model.solve(there, model.with_tangents(first))
    for one, other in zip(cold.views, warm.views, strict=True):
        np.testing.assert_allclose(one.points, other.points, atol=1e-7)


def test_tangents_make_a_warm_start_cheaper() -> None:
    # A clamp that gives way is found by several equilibria: the last one costs a step anyway.
    model = _resting({})
    start = model.parameters.start()
    there = start + 0.05 * np.eye(len(start))[0]
    first = model.with_tangents(model.solve(start))
    cold, warm = model.solve(there), model.solve(there, first)
    assert _steps(warm) < _steps(cold)


def _steps(solution: Solution) -> int:
    own = solution.states[0].solved.own
    return own.newton_steps + own.held_steps


def test_kept_and_latest_solutions_are_not_found_again(monkeypatch) -> None:
    model, asked = _resting(), []
    solve = model.solve
    monkeypatch.setattr(model, 'solve', lambda at, warm=None: asked.append(at) or solve(at, warm))
    start, along = model.parameters.start(), np.eye(len(model.parameters))[0]
    model.keep(start)
    points = model.views(start)[0].points
    places = [start + 0.1 * count * along for count in range(1, 5)]
    for at in places:
        model.at(at)
    assert len(asked) == 5
    values = [p.value(own) for p, own in zip(model.parameters, start, strict=True)]
    again = np.array([p.coordinate(v) for p, v in zip(model.parameters, values, strict=True)])
    np.testing.assert_array_equal(model.views(again)[0].points, points)
    model.at(places[-1])
    assert len(asked) == 5
    model.at(places[0])
    assert len(asked) == 6
