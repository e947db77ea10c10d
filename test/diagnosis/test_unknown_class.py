# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library, made by the independent generator, fall into their own class."""

import json

from diffcal_ros.diagnosis.nominal_fit import fit_nominal
from diffcal_ros.diagnosis.verdict.frame_test import frame_test
from diffcal_ros.offline.calibrate_recordings import open_inputs
from diffcal_ros.scene.load import load_scene
import pytest

from benchmarks.blind.generator import main as generate

pytestmark = pytest.mark.slow
# A wider middle, wind from the side, a softer skin, and a lens that distorts.
CASES = ('case_089', 'case_128', 'case_010', 'case_023')


@pytest.mark.parametrize('name', CASES)
def test_the_class_is_that_of_the_cause(tmp_path, name):
    generate(['--set', 'development', '--out', str(tmp_path), '--only', name, '--jobs', '1'])
    path = tmp_path / 'cases' / name / 'scene.yaml'
    scene = load_scene(path)
    inputs = open_inputs(scene, [], pose_source='stored')
    evaluator, nominal = fit_nominal(inputs.scene, inputs.observations, None)
    best, second, *_ = frame_test(evaluator, nominal)
    label = json.loads((tmp_path / 'labels' / f'{name}.json').read_text())
    assert best.group == label['outside_class']
    assert best.prediction > second.prediction > 0.0
    assert best.closes > 0.5
