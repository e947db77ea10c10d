# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""`diffcal simulate` from the outside: what it writes, and that a calibration can use it."""

import json

from diffcal_ros.cli.main import EXIT_BAD_INPUT, EXIT_DONE
from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.scene.load import load_scene
import pytest
from support.recorded_beam import MODULUS, write_beam_scene


@pytest.fixture
def simulate(run_cli, tmp_path):
    """Simulate the beam into `out`; return what ran."""
    scene = write_beam_scene(tmp_path / 'true')

    def run(*options, out=tmp_path / 'out'):
        # The linear element is the faster one.
        return run_cli('simulate', scene, '--out', out, '--element', 'linear', *options)

    return run


def test_a_recording_a_scene_and_the_truth_are_written(simulate, tmp_path):
    out = tmp_path / 'out'
    ran = simulate('--frames', 3, '--color-frames', 1, '--start-factor', 2, '--rate', 10)
    assert ran.code == EXIT_DONE
    assert f'bag    {out / "bag"}: 3 depth, 1 colour frames' in ran.out
    assert f'truth  {out / "truth.json"}' in ran.out
    truth = json.loads((out / 'truth.json').read_text())
    assert truth['parameters']['body']['youngs_modulus'] == MODULUS
    scene = load_scene(out / 'scene.yaml')
    assert scene.regions[0].youngs_modulus.start == pytest.approx(2 * MODULUS)
    assert scene.observations[0].bag == out / 'bag'
    recording = open_recording(out / 'bag')
    assert (recording.depth_count, recording.color_count) == (3, 1)
    assert recording.last_stamp_ns - recording.first_stamp_ns == 200_000_000


def test_options_reach_the_camera(simulate, tmp_path):
    options = ('--frames', 1, '--color-frames', 0, '--max-range', 0.6, '--noise', 0)
    position = ('--camera-position', 0.1, 0.1, -0.45)
    assert simulate(*options, *position, '--encoding', '16UC1').code == EXIT_DONE
    (frame,) = open_recording(tmp_path / 'out' / 'bag').depth_frames()
    depth = frame.depth[frame.depth == frame.depth]
    assert depth.max() <= 0.6
    millimetres = 1000.0 * depth
    assert millimetres == pytest.approx(millimetres.round(), abs=1e-3)
    truth = json.loads((tmp_path / 'out' / 'truth.json').read_text())
    pose = truth['observations']['observation']['depth_from_world']
    # The camera's place is where its pose is zero.
    middle = [sum(pose[i][j] * p for j, p in enumerate((0.1, 0.1, -0.45))) for i in range(3)]
    assert middle == pytest.approx([-pose[i][3] for i in range(3)], abs=1e-9)


@pytest.mark.slow
def test_a_recording_that_is_there_is_kept_unless_overwriting(simulate, tmp_path):
    few = ('--frames', 1, '--color-frames', 0)
    assert simulate(*few).code == EXIT_DONE
    before = (tmp_path / 'out' / 'truth.json').stat().st_mtime_ns
    ran = simulate(*few)
    assert ran.code == EXIT_BAD_INPUT
    assert 'exists already: choose another folder, or add --overwrite' in ran.err
    assert (tmp_path / 'out' / 'truth.json').stat().st_mtime_ns == before
    assert simulate(*few, '--overwrite', '--seed', 1).code == EXIT_DONE


@pytest.mark.parametrize(
    ('options', 'sentence'),
    [
        (('--frames', 0), '0 depth frames were asked for: give at least one'),
        (('--rate', 0), 'the frame rate is 0 Hz: give 0.1 to 1000'),
        (('--start-factor', -1), 'the start factor is -1: give 0.1 to 10'),
        (('--noise', -0.1), 'noise'),
    ],
)
def test_bad_options_are_one_sentence_and_nothing_is_written(
    simulate, tmp_path, options, sentence
):
    ran = simulate(*options)
    assert ran.code == EXIT_BAD_INPUT
    assert ran.err.startswith('diffcal simulate: ')
    assert ran.err.count('\n') == 1
    assert sentence in ran.err
    assert not (tmp_path / 'out').exists()
