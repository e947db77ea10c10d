# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Half a turn the wrong way round is told; one the right way round is not."""

from dataclasses import replace

from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.offline.calibrate_recordings import open_inputs, run_calibration
from diffcal_ros.offline.turn_sense import half_turned, other_sense
from diffcal_ros.scene.load import load_scene
import numpy as np
import pytest
from support.recorded_beam import record_beam

SETTINGS = CalibrationSettings(with_mesh_error=False)
FAR = {'box': {'x': [float('-inf'), 0.02]}, 'turn': {'axis': [1, 0, 0], 'angle_deg': -180}}


@pytest.fixture(scope='module')
def twisted(tmp_path_factory):
    """A beam whose far end was turned by minus half a turn."""
    clamp = {'box': {'x': [0.1, float('inf')]}}
    recording = record_beam(
        tmp_path_factory.mktemp('twisted'), {'held': {'clamp': clamp, 'far_block': FAR}}
    )
    return open_inputs(load_scene(recording.scene), list(recording.bags.values()))


def senses(result):
    return [warning for warning in result.warnings if 'other way round' in warning]


@pytest.mark.slow
def test_the_wrong_sense_is_told_with_its_remedy(twisted, tmp_path):
    wrong = replace(twisted, scene=other_sense(twisted.scene))
    _, result = run_calibration(wrong, SETTINGS, tmp_path)
    (note,) = senses(result)
    assert 'far_block' in note
    assert 'change the sign of angle_deg' in note


@pytest.mark.slow
def test_the_right_sense_is_left_alone(twisted, tmp_path):
    _, result = run_calibration(twisted, SETTINGS, tmp_path)
    assert senses(result) == []


@pytest.mark.parametrize(
    ('degrees', 'expected'), [(180, True), (-178, True), (540, True), (90, False), (360, False)]
)
def test_only_half_turns_end_in_the_same_place(twisted, degrees, expected):
    (setup,) = twisted.scene.observations
    clamp, far = setup.held
    far = replace(far, turn=replace(far.turn, angle=np.radians(degrees)))
    scene = replace(twisted.scene, observations=(replace(setup, held=(clamp, far)),))
    assert half_turned(scene) == (('far_block',) if expected else ())
    turned = other_sense(scene).observations[0].held[1].turn.angle
    assert turned == pytest.approx(np.radians(-degrees if expected else degrees))
