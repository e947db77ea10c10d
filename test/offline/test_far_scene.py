# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A scene file whose world is that of a robot far from the body leads to the same modulus."""

from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.offline.calibrate_recordings import open_inputs, run_calibration
from diffcal_ros.scene.load import load_scene
import numpy as np
import pytest
from support.far_worlds import shift_by
import yaml

_SETTINGS = CalibrationSettings(with_mesh_error=False, max_iterations=4, search=False)


def _fitted(scene, folder) -> float:
    inputs = open_inputs(load_scene(scene), [])
    return run_calibration(inputs, _SETTINGS, folder)[1]['youngs_modulus'].value


def test_a_far_world_in_a_scene_file_changes_nothing(recorded_beam, tmp_path) -> None:
    near = recorded_beam.scene
    document = yaml.safe_load(near.read_text())
    off = shift_by(90.0)[:3, 3]
    placed = np.array(document['placement']['translation'])
    document['placement']['translation'] = (placed + off).tolist()
    document['marker']['placement'] = {'translation': off.tolist()}
    document['mesh']['file'] = str(near.parent / document['mesh']['file'])
    document['bag'] = str(recorded_beam.bags['observation'])
    document['regions']['body']['youngs_modulus'] = 8e4
    far = tmp_path / 'far.yaml'
    far.write_text(yaml.safe_dump(document))
    document['placement']['translation'] = placed.tolist()
    del document['marker']['placement']
    here = tmp_path / 'here.yaml'
    here.write_text(yaml.safe_dump(document))
    expected = _fitted(here, tmp_path / 'here')
    assert _fitted(far, tmp_path / 'far') == pytest.approx(expected, rel=1e-6)
