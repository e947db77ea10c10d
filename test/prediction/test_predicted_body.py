# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A prediction is the same simulation as a fit's and the recorder's."""

from dataclasses import replace

from diffcal_ros.errors import InputError, SceneError
from diffcal_ros.prediction.film_times import FilmTimes
from diffcal_ros.prediction.predicted_body import predict_bodies
from diffcal_ros.scene.load import load_scene
from diffcal_ros.synthetic.moving_body import move_body
from diffcal_ros.synthetic.posed_body import pose_body
import numpy as np
import pytest
from support.fingers import cable, finger_scene, via_points
from support.recorded_beam import write_beam_scene

RELEASE_TIME = 0.08
# Both ways simulate alike; roundings differ with the order of what was settled before [m].
SAME = 1e-12


def test_a_moving_body_goes_where_the_recorder_has_it(moving_scene, moving_body):
    np.testing.assert_allclose(moving_body.times, np.arange(6) / 25.0)
    (setup,) = moving_scene.observations
    film = move_body(moving_scene, setup, moving_body.times)
    np.testing.assert_allclose(moving_body.positions, film.positions, atol=SAME)
    moved = np.linalg.norm(moving_body.positions - moving_body.positions[0], axis=2).max(axis=1)
    before = moving_body.times <= RELEASE_TIME
    assert moved[before].max() < SAME
    assert moved[~before].min() > 1e-4
    assert moving_body.largest_displacement >= moved.max()


def test_a_body_at_rest_has_one_frame(tmp_path):
    scene = load_scene(write_beam_scene(tmp_path))
    (body,) = predict_bodies(scene, FilmTimes())
    assert body.times.tolist() == [0.0]
    posed = pose_body(scene, scene.observations[0])
    np.testing.assert_allclose(body.positions[0], posed.positions, atol=SAME)


def test_the_effects_of_the_scene_are_in_it(tmp_path):
    plain = load_scene(write_beam_scene(tmp_path / 'plain'))
    weight = {'effects': {'added_mass': {'mass': 0.01, 'at': 1.0}}}
    loaded = load_scene(write_beam_scene(tmp_path / 'loaded', weight))
    (hanging,), (sagging,) = (predict_bodies(scene, FilmTimes()) for scene in (plain, loaded))
    assert sagging.largest_displacement > 1.2 * hanging.largest_displacement


def test_cables_pull():
    slack, taut = (finger_scene(cable('top', pull, via_points())) for pull in (-0.01, 0.01))
    (free,), (bent,) = (predict_bodies(scene, FilmTimes()) for scene in (slack, taut))
    posed = pose_body(taut, taut.observations[0])
    np.testing.assert_allclose(bent.positions[0], posed.positions, atol=SAME)
    assert np.abs(bent.positions - free.positions).max() > 0.005


def test_a_film_lasts_as_long_as_is_said(moving_scene):
    (setup,) = moving_scene.observations
    assert len(FilmTimes(30.0, 0.4).of(setup)) == 13
    # Until a second after the release, where neither scene nor command says how long.
    assert FilmTimes(50.0).of(setup)[-1] == pytest.approx(1.08)
    short = replace(setup, motion=replace(setup.motion, duration=0.5))
    assert FilmTimes(50.0).of(short)[-1] == pytest.approx(0.5)
    assert FilmTimes(50.0, 0.3).of(short)[-1] == pytest.approx(0.3)


@pytest.mark.parametrize(
    ('given', 'message'),
    [
        ({'rate': 0.0}, r'frame rate is 0 Hz: give 0\.1 to 10000'),
        ({'rate': float('nan')}, r'frame rate is nan Hz'),
        ({'duration': -1.0}, r'duration is -1 s: give more than 0, up to 600'),
    ],
)
def test_times_that_make_no_sense_are_refused(given, message):
    with pytest.raises(InputError, match=message):
        FilmTimes(**given)


def test_too_many_frames_are_refused_before_anything_is_simulated(moving_scene):
    with pytest.raises(InputError, match=r"60001 frames of 'observation', and 2000 are the most"):
        predict_bodies(moving_scene, FilmTimes(100.0, 600.0))


@pytest.mark.slow
def test_a_body_that_finds_no_rest_is_told(tmp_path):
    modulus = {'start': 1.0, 'min': 0.5, 'max': 1e6}
    scene = load_scene(write_beam_scene(tmp_path, {'regions.body.youngs_modulus': modulus}))
    with pytest.raises(SceneError, match=r'observation cannot be simulated: .*Young'):
        predict_bodies(scene, FilmTimes())
