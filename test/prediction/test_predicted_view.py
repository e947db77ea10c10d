# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a depth camera reads of a predicted body."""

from dataclasses import replace

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.errors import SceneError
from diffcal_ros.prediction.film_times import FilmTimes
from diffcal_ros.prediction.predicted_body import predict_bodies
from diffcal_ros.prediction.predicted_view import look_at
from diffcal_ros.rigid_transform import apply
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.model import ObservationSetup
import numpy as np
import pytest
from support.recorded_beam import DEPTH_CAMERA, write_beam_scene

SAME = 1e-6  # Images are float32 [m].


def test_the_default_camera_sees_the_whole_motion(moving_scene, moving_body):
    (view,) = look_at(moving_scene, [moving_body])
    camera = view.camera
    pixels = camera.project(apply(view.depth_from_world, moving_body.positions.reshape(-1, 3)))
    assert (pixels >= 0.0).all()
    assert (pixels <= [camera.width - 1, camera.height - 1]).all()
    images = list(view.depths())
    assert len(images) == len(moving_body.times)
    assert all(image.shape == (camera.height, camera.width) for image in images)
    assert not np.array_equal(images[0], images[-1], equal_nan=True)


def test_depth_is_what_a_fit_renders(tmp_path):
    """Sensor errors and camera offset of the scene are applied as a fit applies them."""
    effects = {
        'camera_offset': {'x': 0.004, 'ry': 0.05},
        'depth_affine': {'scale': 0.01, 'bias': -0.002},
        'depth_bias_by_region': {'bias': 0.003},
    }
    scene = load_scene(write_beam_scene(tmp_path, {'effects': effects}))
    scene = replace(scene, depth_camera=DEPTH_CAMERA)
    (body,) = predict_bodies(scene, FilmTimes())
    (view,) = look_at(scene, [body], (0.05, 0.03, -0.4))
    (image,) = view.depths()
    seen = Observation('beam', 0, image, DEPTH_CAMERA, view.depth_from_world)
    fit = Calibration(scene, [seen])
    residual = fit.objective.comparisons(fit.coordinates)[0].difference
    assert np.isfinite(residual).any()
    assert np.nanmax(np.abs(residual)) < SAME


def test_a_stored_pose_is_used_and_a_position_goes_before_it(moving_scene, moving_body):
    (free,) = look_at(moving_scene, [moving_body])
    stored = _with_pose(moving_body.setup, free.depth_from_world + 0.0)
    (view,) = look_at(moving_scene, [replace(moving_body, setup=stored)])
    np.testing.assert_array_equal(view.depth_from_world, free.depth_from_world)
    (other,) = look_at(moving_scene, [replace(moving_body, setup=stored)], (0.3, 0.2, -0.5))
    np.testing.assert_allclose(
        apply(other.depth_from_world, np.array([0.3, 0.2, -0.5])), 0.0, atol=1e-12
    )


def test_a_body_out_of_view_is_told(moving_scene, moving_body):
    away = np.eye(4)
    away[:3, 3] = [0.0, 0.0, -2.0]
    body = replace(moving_body, setup=_with_pose(moving_body.setup, away))
    (view,) = look_at(moving_scene, [body])
    with pytest.raises(SceneError, match=r'out of view 0 s after .*another --camera-position'):
        next(view.depths())


def test_a_body_too_far_to_be_seen_is_told(moving_scene, moving_body):
    (view,) = look_at(moving_scene, [moving_body], (0.0, 1.0, -500.0))
    with pytest.raises(SceneError, match=r'the body covers no pixel; give another'):
        next(view.depths())


def _with_pose(setup: ObservationSetup, pose: np.ndarray) -> ObservationSetup:
    return replace(setup, stored_depth_from_world=pose)
