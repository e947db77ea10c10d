# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The motion of a scene file: what a sound one becomes, and what is said about each mistake."""

from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.calibration.parameters.parameters import Kind
from diffcal_ros.errors import SceneError
from diffcal_ros.report.tables.scene_table import format_rows, scene_rows
from diffcal_ros.scene.load import load_scene
import numpy as np
import pytest

INF = float('inf')
LEDGE = {'held.ledge': {'box': {'x': [-INF, -0.08]}}}
MOTION = {
    **LEDGE,
    'motion': {'released': ['ledge'], 'at': {'start': 0.1, 'min': 0.0, 'max': 0.3}},
    'regions.body.damping': 12,
    'fit': ['youngs_modulus', 'damping', 'density', 'release_time'],
}


def test_a_motion_and_its_parameters(write_scene):
    scene = load_scene(write_scene(_merged({'motion.time_step': 0.002, 'motion.hold_out': 3})))
    (setup,) = scene.observations
    assert setup.motion.released == ('ledge',)
    assert [part.name for part in setup.staying] == ['clamp']
    assert (setup.motion.integrator, setup.motion.time_step) == ('implicit', 0.002)
    assert setup.motion.hold_out == 3
    parameters = make_parameters(scene, with_edge_bias=False)
    assert parameters.names == ('youngs_modulus', 'damping', 'density', 'release_time')
    damping, time = parameters.parameters[1], parameters.parameters[3]
    assert (damping.unit, damping.is_logarithmic) == ('Pa s', True)
    assert (time.kind, time.unit, time.quantity.upper) == (Kind.RELEASE_TIME, 's', 0.3)
    assert parameters.start()[[1, 3]] == pytest.approx([np.log(12.0), 0.1])


def test_the_table_tells_of_the_motion(write_scene):
    text = format_rows(scene_rows(load_scene(write_scene(MOTION))))
    assert 'moves: ledge let go; the time of release 0.1 s, bounds 0 to 0.3' in text
    assert 'damping 12 Pa s' in text
    assert 'one in 5 kept for the check' in text


def test_a_tolerance_chooses_the_steps(write_scene):
    scene = load_scene(write_scene(_merged({'motion.tolerance': 2e-5})))
    (setup,) = scene.observations
    assert (setup.motion.tolerance, setup.motion.time_step) == (2e-5, None)
    assert 'implicit steps, each off by at most 0.02 mm' in format_rows(scene_rows(scene))


def test_one_observation_moves_and_another_rests(write_scene):
    changes = {key: value for key, value in MOTION.items() if key != 'motion'}
    motion = MOTION['motion']
    changes['observations'] = [
        {'name': 'hanging', 'held_parts': ['clamp']},
        {'name': 'dropped', 'motion': motion},
        {'name': 'again', 'motion': {**motion, 'at': 0.25}},
    ]
    scene = load_scene(write_scene(changes))
    assert [setup.motion is None for setup in scene.observations] == [True, False, False]
    names = make_parameters(scene, with_edge_bias=False).names
    assert names[-2:] == ('release_time.dropped', 'release_time.again')


@pytest.mark.parametrize(
    ('changes', 'message'),
    [
        ({'motion.released': ...}, 'motion.released is missing: give a list of held parts'),
        ({'motion.released': ['legde']}, "has 'legde', no part held here; did you mean `ledge`"),
        ({'motion.released': ['ledge', 'clamp']}, 'no part is left to hold the body'),
        ({'motion.at': ...}, 'motion.at is missing: give the time of release in s'),
        ({'motion.at': -1}, 'motion.at is -1: give the time of release in s, at least 0'),
        ({'motion.integrator': 'euler'}, 'allowed: implicit, semi_implicit'),
        ({'motion.time_step': 1}, 'motion.time_step is 1: give seconds, at least 1e-06'),
        ({'motion.tolerance': 1}, 'motion.tolerance is 1: give metres, at least 1e-08'),
        (
            {'motion.tolerance': 1e-5, 'motion.integrator': 'semi_implicit'},
            'motion.tolerance is 1e-05: only steps of `integrator: implicit` follow one',
        ),
        ({'motion.hold_out': 1}, 'every frame would be kept from the fit'),
        ({'motion.frames': 1}, 'motion.frames is 1: give a whole number at least 2'),
        ({'motion.duraton': 1}, 'did you mean `duration`'),
        ({'regions.body.damping': 0}, 'give damping in Pa s, above 0'),
        ({'regions.body.damping': ...}, "region 'body' gives no damping"),
        ({'motion': ...}, "has 'damping' while the body is at rest in every observation"),
        ({'motion': ...}, "has 'release_time' while the body is at rest"),
    ],
)
def test_what_is_wrong_is_told(write_scene, changes, message):
    with pytest.raises(SceneError) as caught:
        load_scene(write_scene(_merged(changes)))
    assert message in str(caught.value)


def test_all_mistakes_at_once_and_each_once(write_scene):
    motion = {'released': ['legde'], 'at': -1, 'integrator': 'euler', 'frames': 1}
    observations = [{'name': 'one'}, {'name': 'two'}]
    with pytest.raises(SceneError, match='4 mistakes'):
        load_scene(write_scene({**MOTION, 'motion': motion, 'observations': observations}))


def _merged(changes):
    """Apply dotted changes to the motion of this module."""
    merged = {**MOTION, 'motion': dict(MOTION['motion'])}
    for key, value in changes.items():
        head, _, name = key.partition('.')
        if head == 'motion' and name:
            if value is ...:
                del merged['motion'][name]
            else:
                merged['motion'][name] = value
        elif value is ... and key in merged:
            del merged[key]
        else:
            merged[key] = value
    return merged
