# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""`diffcal predict` from the outside."""

import cv2
from diffcal_ros.cli.main import EXIT_BAD_INPUT, EXIT_DONE
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.motion import implicit_step
from diffcal_ros.recording.bag_reader import open_recording
import numpy as np
from PIL import Image
import pytest
from support.recorded_beam import DEPTH_CAMERA, record_beam, write_beam_scene
from support.released_beam import CHANGES

LINEAR = {'mesh.element': 'linear'}
NOISE = 0.00014  # Of the synthetic camera's pixels [m].


@pytest.fixture
def predict(run_cli, tmp_path):
    """Predict the released beam into `out`; return what ran."""
    scene = write_beam_scene(tmp_path / 'scene', {**CHANGES, **LINEAR})

    def run(*options, source=scene, out=tmp_path / 'out'):
        return run_cli('predict', source, '--out', out, *options)

    return run


def test_depth_meshes_bag_and_film_are_written(predict, tmp_path):
    out = tmp_path / 'out'
    ran = predict('--rate', 20, '--duration', 0.2, '--bag', '--slow-motion', 2)
    assert ran.code == EXIT_DONE
    assert ran.out.startswith('observation  5 frames, moved by up to ')
    for word, path in (('mesh', 'mesh/body.pvd'), ('film', 'film.gif'), ('bag', 'bag')):
        assert f'{word:<11}  {out / path}' in ran.out
    assert "no camera: intrinsics like an Intel L515's" in ran.err
    assert open_recording(out / 'bag').depth_count == 5
    assert len(list((out / 'mesh').glob('*.vtu'))) == 5
    film = Image.open(out / 'film.gif')
    assert (film.n_frames, film.info['duration']) == (5, 100)


def test_a_film_is_written_as_mp4(predict, tmp_path):
    ran = predict('--rate', 20, '--duration', 0.2, '--mesh', 'none', '--film', 'mp4')
    assert ran.code == EXIT_DONE
    path = tmp_path / 'out' / 'film.mp4'
    assert f'film         {path}' in ran.out
    film = cv2.VideoCapture(str(path))
    assert (film.get(cv2.CAP_PROP_FRAME_COUNT), film.get(cv2.CAP_PROP_FPS)) == (5, 5)
    assert not (tmp_path / 'out' / 'film.gif').exists()


def test_every_observation_has_a_folder(predict, tmp_path):
    observations = [{'name': 'dropped'}, {'name': 'held', 'gravity': [0, -5.0, 0]}]
    source = write_beam_scene(tmp_path / 'two', {**LINEAR, 'observations': observations})
    assert predict('--mesh', 'obj', source=source).code == EXIT_DONE
    for name in ('dropped', 'held'):
        assert (tmp_path / 'out' / name / 'depth.png').is_file()
        assert (tmp_path / 'out' / name / 'mesh' / '0000.obj').is_file()


def test_a_fitted_scene_predicts_what_was_seen(run_cli, tmp_path):
    camera = {name: getattr(DEPTH_CAMERA, name) for name in ('fx', 'fy', 'cx', 'cy')}
    camera |= {'width': DEPTH_CAMERA.width, 'height': DEPTH_CAMERA.height}
    # Without a marker the scene stores the camera's pose.
    made = record_beam(
        tmp_path, {**LINEAR, 'marker': ..., 'camera': camera}, element=Element.LINEAR
    )
    options = ('--pose', 'stored', '--no-mesh-error')
    fit, out = tmp_path / 'fit', tmp_path / 'out'
    ran = run_cli('calibrate', '--scene', made.scene, '--out', fit, *options)
    assert ran.code == EXIT_DONE
    ran = run_cli('predict', fit / 'fitted_scene.yaml', '--out', out, '--mesh', 'none')
    assert ran.code == EXIT_DONE
    assert 'diffcal predict: ' not in ran.err
    predicted = np.load(out / 'depth' / '0000.npz')['depth']
    (seen, *_) = open_recording(made.bags['observation']).depth_frames()
    wrong = np.abs(seen.depth - predicted)[np.isfinite(predicted)]
    assert np.nanmedian(wrong) < 3.0 * NOISE


def test_a_time_step_that_was_halved_is_told(predict, tmp_path, monkeypatch):
    # With as many rounds as it has, a step of this length converges in any body that was tried.
    monkeypatch.setattr(implicit_step, '_MAX_HELD_ROUNDS', 3)
    monkeypatch.setattr(implicit_step, '_MAX_NEWTON_STEPS', 3)
    motion = {**CHANGES['motion'], 'time_step': 0.02}
    source = write_beam_scene(tmp_path / 'long', {**CHANGES, **LINEAR, 'motion': motion})
    ran = predict('--duration', 0.2, '--mesh', 'none', source=source)
    assert ran.code == EXIT_DONE
    assert 'warning: observation: the time step of 0.02 s did not converge' in ran.err


def test_what_is_there_is_kept_unless_overwriting(predict, tmp_path):
    (tmp_path / 'out').mkdir()
    (tmp_path / 'out' / 'mine').write_text('keep')
    ran = predict('--duration', 0.1)
    assert ran.code == EXIT_BAD_INPUT
    assert 'is not empty: choose another folder, or add --overwrite' in ran.err
    assert predict('--duration', 0.1, '--overwrite', '--mesh', 'none').code == EXIT_DONE
    assert (tmp_path / 'out' / 'mine').read_text() == 'keep'


@pytest.mark.parametrize(
    ('options', 'sentence'),
    [
        (('--rate', 0), 'the frame rate is 0 Hz: give 0.1 to 10000'),
        (('--duration', 0), 'the duration is 0 s: give more than 0, up to 600'),
        (('--slow-motion', 0), 'the slow motion is 0: give 0.01 to 1000'),
        (('--rate', 1000, '--duration', 60), '60001 frames'),
        (('--camera-position', 0, 50, 0), 'the body covers no pixel; give another'),
    ],
)
def test_bad_options_are_one_sentence_and_nothing_is_written(predict, tmp_path, options, sentence):
    ran = predict(*options)
    assert ran.code == EXIT_BAD_INPUT
    last = ran.err.splitlines()[-1]
    assert last.startswith('diffcal predict: ')
    assert sentence in last
    assert not (tmp_path / 'out').exists()


def test_a_missing_scene_is_one_sentence(predict, tmp_path):
    ran = predict(source=tmp_path / 'none.yaml')
    assert ran.code == EXIT_BAD_INPUT
    assert 'none.yaml' in ran.err
