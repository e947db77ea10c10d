# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A beam that is let go, predicted once."""

from diffcal_ros.prediction.film_times import FilmTimes
from diffcal_ros.prediction.predicted_body import predict_bodies, PredictedBody
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.model import Scene
import pytest
from support.recorded_beam import write_beam_scene
from support.released_beam import CHANGES


@pytest.fixture(scope='session')
def moving_scene(tmp_path_factory) -> Scene:
    """The released beam, without a stored pose."""
    return load_scene(write_beam_scene(tmp_path_factory.mktemp('moving'), CHANGES))


@pytest.fixture(scope='session')
def moving_body(moving_scene) -> PredictedBody:
    """Six frames of its motion."""
    (body,) = predict_bodies(moving_scene, FilmTimes(rate=25.0, duration=0.2))
    return body
