# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A recording of a body that a cable bends, and the scene that goes with it."""

import json

from diffcal_ros.calibration.calibrate import calibrate
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.offline.calibrate_recordings import open_inputs
from diffcal_ros.scene.load import load_scene
import pytest
from support.recorded_beam import record_beam

_VIA = [[0.004, 0.021, 0.011], [0.06, 0.02, 0.009], [0.115, 0.021, 0.01]]
_PULL = 0.008


def test_recorded_cable_is_found_again(tmp_path) -> None:
    recorded = record_beam(
        tmp_path,
        {'cables': {'tendon': {'via': _VIA, 'pull': _PULL}}, 'fit': ['rest_length']},
        start_factor=1.6,
    )
    (truth,) = json.loads(recorded.truth.read_text())['cables'].values()
    assert truth['length'] - truth['rest_length'] == pytest.approx(_PULL)
    scene = load_scene(recorded.scene)
    (cable,) = scene.cables
    assert cable.length - cable.rest_length.start == pytest.approx(_PULL / 1.6, abs=1e-6)
    inputs = open_inputs(scene, [])
    settings = CalibrationSettings(with_mesh_error=False)
    found = calibrate(inputs.scene, inputs.observations, settings)['rest_length']
    # The recording is made with the same mesh: what is left is the sensor's and the pose's.
    assert found.value == pytest.approx(truth['rest_length'], rel=0.01)
