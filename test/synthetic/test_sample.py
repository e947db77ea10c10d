# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The bundled sample: small, said to be synthetic, made by its script, and fitted to its truth."""

import importlib.util
import json
from pathlib import Path
import sys
from types import ModuleType

from diffcal_ros.calibration.calibrate import calibrate
from diffcal_ros.calibration.results.outcome import Outcome
from diffcal_ros.offline.calibrate_recordings import open_inputs
from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.scene.load import load_scene
from diffcal_ros.tet_mesh import mesh_problems
import numpy as np
import pytest

BAGS = Path(__file__).resolve().parents[2] / 'bags'
SAMPLE = BAGS / 'sample'
LARGEST = 3e6  # Bytes, so that a clone stays small.


@pytest.fixture(scope='module')
def script() -> ModuleType:
    spec = importlib.util.spec_from_file_location('make_sample', BAGS / 'make_sample.py')
    module = importlib.util.module_from_spec(spec)
    sys.modules['make_sample'] = module
    spec.loader.exec_module(module)
    yield module
    del sys.modules['make_sample']


def test_it_is_small_and_says_that_it_is_synthetic():
    files = [path for path in SAMPLE.rglob('*') if path.is_file()]
    assert sum(path.stat().st_size for path in files) <= LARGEST
    assert 'synthetic' in (SAMPLE / 'scene.yaml').read_text().partition('format:')[0]
    assert 'synthetic' in (SAMPLE / 'README.md').read_text()


def test_it_lasts_a_second_and_shows_the_marker_and_the_body():
    recording = open_recording(SAMPLE / 'bag')
    assert recording.notes == ()
    assert 1.0 <= (recording.last_stamp_ns - recording.first_stamp_ns) * 1e-9 <= 2.0
    inputs = open_inputs(load_scene(SAMPLE / 'scene.yaml'), [])
    assert all('mirrored' not in note for note in inputs.notes)


@pytest.mark.slow
def test_the_default_fit_has_the_truth_in_its_interval():
    """Modulus and rigid offset are fitted; the data come from another mesh than the model's."""
    truth = json.loads((SAMPLE / 'truth.json').read_text())
    inputs = open_inputs(load_scene(SAMPLE / 'scene.yaml'), [])
    result = calibrate(inputs.scene, inputs.observations)
    assert result.outcome is Outcome.CONVERGED
    assert 'rigid_offset.x' in result.values()
    fitted = result['youngs_modulus']
    low, high = fitted.interval_95
    modulus = truth['parameters']['silicone']['youngs_modulus']
    assert low < modulus < high
    assert high / low < 1.5**2, 'an interval that wide would hold anything'
    assert abs(fitted.start / modulus - 1.0) > 0.3
    assert result.gap_end.median < 0.2e-3


def test_the_mesh_is_sound_and_as_the_script_makes_it(script):
    mesh = script.finger()
    assert mesh_problems(mesh) == []
    assert script.vtk_text(mesh) == (SAMPLE / 'finger.vtk').read_text()


@pytest.mark.slow
def test_the_script_makes_the_same_recording_again(script, tmp_path):
    """Compared as decoded: another zstd may compress otherwise."""
    script.make_sample(tmp_path / 'sample')
    for name in ('scene.yaml', 'finger.vtk'):
        assert (tmp_path / 'sample' / name).read_bytes() == (SAMPLE / name).read_bytes()
    old, new = open_recording(SAMPLE / 'bag'), open_recording(tmp_path / 'sample' / 'bag')
    for was, made in zip(old.depth_frames(), new.depth_frames(), strict=True):
        assert was.stamp_ns == made.stamp_ns
        same = np.isclose(was.depth, made.depth, atol=1e-6, equal_nan=True)
        # Another linear algebra may round a few depths to the next step.
        assert same.mean() > 0.999
    for was, made in zip(old.color_frames(), new.color_frames(), strict=True):
        assert (was.image == made.image).mean() > 0.999
