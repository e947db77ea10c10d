# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.errors import SceneError
from diffcal_ros.scene.load import load_scene
import numpy as np
import pytest

CAMERA = PinholeCamera(64, 48, 70.0, 74.0, 30.5, 25.25)


def test_back_projection_undoes_projection(random: np.random.Generator) -> None:
    depth = random.uniform(0.3, 0.6, size=(48, 64))
    points = CAMERA.back_project(depth)
    pixels = CAMERA.project(points)
    rows, columns = np.mgrid[:48, :64]
    np.testing.assert_allclose(pixels[..., 0], columns, atol=1e-9)
    np.testing.assert_allclose(pixels[..., 1], rows, atol=1e-9)
    np.testing.assert_allclose(points[..., 2], depth)


@pytest.mark.parametrize(
    ('changes', 'message'),
    [
        ({'fx': 0.0}, 'focal length is fx=0'),
        ({'width': 0}, 'camera size is 0x48'),
        ({'cx': float('nan')}, 'NaN'),
    ],
)
def test_refuses_impossible_intrinsics(changes, message: str) -> None:
    values = {'width': 64, 'height': 48, 'fx': 70.0, 'fy': 74.0, 'cx': 30.5, 'cy': 25.25}
    with pytest.raises(ValueError, match=message):
        PinholeCamera(**{**values, **changes})


def test_refuses_a_depth_image_of_another_size() -> None:
    with pytest.raises(ValueError, match='check that camera_info matches'):
        CAMERA.back_project(np.ones((10, 10)))


_WIDE = {'width': 64, 'height': 48, 'fy': 74.0, 'cx': 30.5, 'cy': 25.25}


def test_scenes_and_camera_infos_refuse_the_same_focal_length(write_scene) -> None:
    values = {**_WIDE, 'fx': 0.0879 * 64}
    with pytest.raises(ValueError, match='more than 160 degrees in view'):
        PinholeCamera(**values)
    with pytest.raises(SceneError, match='more than 160 degrees'):
        load_scene(write_scene({'camera': values}))


def test_scenes_and_camera_infos_take_the_same_focal_length(write_scene) -> None:
    values = {**_WIDE, 'fx': 0.0881 * 64}
    assert load_scene(write_scene({'camera': values})).depth_camera == PinholeCamera(**values)
