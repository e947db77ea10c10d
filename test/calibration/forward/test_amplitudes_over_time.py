# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Amplitudes of effects that are others around a time: slopes of all frames, and what is read."""

from dataclasses import replace

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.parameters.form_parameters import course_parameters, knot_parameter
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.calibration.parameters.parameters import ParameterSet
from diffcal_ros.effects.registry import EFFECTS
from diffcal_ros.scene.model import QUASI_STATIC
from diffcal_ros.time_knot import knots_between, TimeKnot
import numpy as np
import pytest
from support.moving_beams import moving_model, moving_scene, slope_errors

TIMES = (0.02, 0.06, 0.13, 0.2)
KNOTS = knots_between(0.0, 0.2, 3)
# By effect, an amplitude and how much of it there is around each knot, SI units.
COURSES = {
    'gravity_tilt': ('a', (0.03, -0.05, 0.02)),
    'time_offset': ('late', (0.002, 0.006, -0.003)),
    'rigid_offset': ('x', (0.002, -0.001, 0.004)),
    'depth_affine': ('bias', (0.002, -0.001, 0.004)),
}
_SLOPE = 1e-5


def _model(
    effect: str, integrator: str = 'implicit', more_of: str = ''
) -> tuple[ForwardModel, np.ndarray]:
    """Return a model with a course, and its coordinates.

    Args:
        effect: of which.
        integrator: of the motion.
        more_of: an amplitude that it has over time alone, in place of its usual one.
    """
    scene = moving_scene((4, 1, 1), fit=('youngs_modulus',), integrator=integrator)
    name, amounts = COURSES[effect]
    wanted = (effect,) if effect in ('gravity_tilt', 'rigid_offset') else (f'{effect}.{name}',)
    parameters = make_parameters(scene, ('youngs_modulus', *wanted), with_edge_bias=False)
    own = next(one for one in parameters if one.amplitude == name)
    if more_of:
        own = next(o for o in course_parameters(EFFECTS[effect]) if o.amplitude == more_of)
    more = tuple(knot_parameter(own, knot, 1.0) for knot in KNOTS)
    model = moving_model(scene, TIMES)
    whole = ParameterSet((*parameters.parameters, *more), parameters.pose_covariances)
    model = model.with_parameters(scene, whole)
    start = whole.start()
    start[-3:] = amounts
    return model, start


@pytest.mark.parametrize('effect', ['gravity_tilt', 'time_offset', 'rigid_offset'])
@pytest.mark.slow
def test_tangents_are_the_slopes_of_all_frames(effect) -> None:
    model, start = _model(effect)
    for place in range(len(start) - 3, len(start)):
        errors = slope_errors(model, start, place)
        assert min(errors) < (1e-4 if effect == 'time_offset' else _SLOPE), errors


@pytest.mark.parametrize('integrator', ['implicit', 'semi_implicit', QUASI_STATIC])
@pytest.mark.slow
def test_what_pushes_along_gravity_for_a_while_has_slopes_too(integrator) -> None:
    model, start = _model('gravity_tilt', integrator, more_of='heavier')
    tilted = start.copy()
    tilted[1:3] = 0.05, -0.02
    for place in range(len(start) - 3, len(start)):
        errors = slope_errors(model, tilted, place)
        assert min(errors) < (1e-4 if integrator == QUASI_STATIC else _SLOPE), errors
    # At a time it is what gravity is in all, and a tenth more.
    same = tilted.copy()
    same[-3:] = 0.1
    gravity = model.effects.gravity(model.effects.amplitudes(same, 0, TIMES[2]), 0)
    steady = model.effects.gravity(model.effects.amplitudes(same, 0), 0)
    np.testing.assert_allclose(gravity, 1.1 * steady, rtol=1e-12)


def test_a_held_load_sags_by_gravity_as_it_is_in_each_frame() -> None:
    model, start = _model('gravity_tilt', QUASI_STATIC)
    for place in range(len(start) - 3, len(start)):
        assert min(slope_errors(model, start, place)) < 1e-4
    # A frame is as with a tilt that is the same at all times, but for how gravity goes straight
    # between knots, and a tilt round.
    same = start.copy()
    same[-3:] = float(np.interp(TIMES[2], [k.at for k in KNOTS], start[-3:]))
    np.testing.assert_allclose(
        model.views(start)[2].points, model.views(same)[2].points, atol=1e-4
    )
    off = model.views(start)[3].points - model.views(same)[3].points
    assert np.abs(off).max() > 1e-3


def test_a_camera_reads_in_each_frame_what_it_adds_then() -> None:
    model, start = _model('depth_affine')
    heights = np.interp(TIMES, [knot.at for knot in KNOTS], start[-3:])
    for number, height in enumerate(heights):
        ((_, own),) = model.sensor(start, number).errors
        assert own['bias'] == pytest.approx(height, abs=1e-12)
    assert not np.stack(model.tangents(start))[:, -3:].any()


def test_what_is_more_around_a_time_is_nothing_of_a_body_at_rest() -> None:
    model, start = _model('depth_affine')
    own = model.parameters.parameters[-1]
    assert own.is_freed
    assert not own.is_in_all
    assert own.weight_in(0, None) == 0.0
    assert own.weight_in(0, 0.2) == 1.0
    assert replace(own, posture=1).weight_in(0, 0.2) == 0.0
    assert model.effects.amplitudes(start, 0)['depth_affine']['bias'] == 0.0


def test_amplitudes_of_long_recordings_have_names_of_their_own() -> None:
    model, _ = _model('depth_affine')
    own = model.parameters.parameters[-1]
    times = 86_400.0 + np.arange(20) / 30.0
    knots = (*knots_between(times[0], times[-1], 9), *(TimeKnot(float(t), 0.01) for t in times))
    names = {knot_parameter(own, knot, 1.0).name for knot in knots}
    assert len(names) == len(knots)
