# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effects that need motion, as parameters of a fit: slopes, absence and stated values."""

from dataclasses import replace

from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.effects.registry import EFFECTS
from diffcal_ros.scene.fit_names import fit_problems
import numpy as np
import pytest
from support.moving_beams import moving_model, moving_scene
from support.scenes import beam_scene

TIMES = (0.02, 0.06, 0.13, 0.2)
EFFECT_FIT = ('time_offset', 'air_drag')
# Away from zero, SI units.
AWAY = {'time_offset.late': 0.004, 'air_drag.area': 0.03}
_SLOPE = 1e-4


def _scene(fit):
    return moving_scene((4, 1, 1), fit=fit)


def test_points_follow_amplitudes() -> None:
    model = moving_model(_scene(('damping', *EFFECT_FIT)), TIMES)
    here = model.parameters.start()
    for place, name in enumerate(model.parameters.names):
        here[place] = AWAY.get(name, here[place])
    tangents = np.stack(model.tangents(here))
    for place, parameter in enumerate(model.parameters):
        usual = 1.0 if parameter.component is None else parameter.component.scale
        errors = []
        for step in (1e-2 * usual, 1e-3 * usual, 1e-4 * usual):
            change = step * np.eye(len(here))[place]
            ahead = np.stack([view.points for view in model.views(here + change)])
            behind = np.stack([view.points for view in model.views(here - change)])
            slope = (ahead - behind) / (2.0 * step)
            errors.append(np.linalg.norm(slope - tangents[:, place]) / np.linalg.norm(slope))
        assert min(errors) < _SLOPE, (parameter.name, errors)


def test_amplitudes_of_zero_are_the_model_without() -> None:
    plain = moving_model(_scene(('rigid_offset',)), TIMES)
    there = moving_model(_scene(EFFECT_FIT), TIMES)
    nothing = plain.views(plain.parameters.start())
    zeros = there.views(there.parameters.start())
    for one, other in zip(nothing, zeros, strict=True):
        np.testing.assert_array_equal(one.points, other.points)


@pytest.mark.parametrize('name', sorted(AWAY))
def test_a_stated_effect_is_the_fitted_one(name) -> None:
    identifier, _, component = name.partition('.')
    fitted = moving_model(_scene((name,)), TIMES)
    scene = replace(_scene(('rigid_offset',)), effects={identifier: {component: AWAY[name]}})
    stated = moving_model(scene, TIMES)
    first = fitted.views(np.array([AWAY[name]]))
    second = stated.views(stated.parameters.start())
    for one, other in zip(first, second, strict=True):
        np.testing.assert_array_equal(one.points, other.points)


@pytest.mark.parametrize('name', [n for n, effect in EFFECTS.items() if effect.needs_motion])
def test_a_body_at_rest_shows_nothing_of_them(name) -> None:
    scene = beam_scene()
    (problem,) = fit_problems([name], ['part_0'], scene.observations)
    assert f'has {name!r} while the body is at rest in every observation' in problem
    parameters = make_parameters(scene, (name,), with_edge_bias=False)
    assert parameters.names[0].startswith(name)
