# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Rendered markers: a camera, poses in front of it, and noisy images of them."""

from collections.abc import Callable

import cv2
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.pose.marker_image import draw_marker
from diffcal_ros.pose.marker_target import MarkerTarget, single_marker
from diffcal_ros.rigid_transform import rotation_matrix, transform
import numpy as np
import pytest

# Not square, fx and fy apart, principal point off the middle.
CAMERA = PinholeCamera(640, 480, 605.0, 590.0, 331.5, 226.3)
SIDE = 0.03
DICTIONARY = 'DICT_6X6_250'


@pytest.fixture
def color_camera() -> PinholeCamera:
    return CAMERA


@pytest.fixture
def target() -> MarkerTarget:
    return single_marker(DICTIONARY, 3, SIDE)


@pytest.fixture
def marker_pose() -> Callable[..., np.ndarray]:
    """Make a pose of a marker that faces the camera, then tilts about `axis` in the image."""

    def make(
        tilt_deg: float,
        *,
        axis_deg: float = 70.0,
        distance: float = 0.4,
        column: float = 0.05,
        row: float = -0.04,
        spin_deg: float = 12.0,
    ) -> np.ndarray:
        axis = np.deg2rad(axis_deg)
        tilt = rotation_matrix(np.deg2rad(tilt_deg) * np.array([np.cos(axis), np.sin(axis), 0.0]))
        facing = np.diag([1.0, -1.0, -1.0])
        spin = rotation_matrix(np.array([0.0, 0.0, np.deg2rad(spin_deg)]))
        return transform(tilt @ facing @ spin, np.array([column, row, distance]))

    return make


@pytest.fixture
def photograph(random: np.random.Generator) -> Callable[..., np.ndarray]:
    """Render a marker at a pose with a lens blur and sensor noise."""

    def take(
        camera_from_marker: np.ndarray,
        *,
        camera: PinholeCamera = CAMERA,
        marker_id: int = 3,
        side: float = SIDE,
        blur: float = 0.7,
        noise: float = 2.0,
    ) -> np.ndarray:
        blank = np.full((camera.height, camera.width, 3), 110, np.uint8)
        drawn = draw_marker(
            blank,
            camera=camera,
            camera_from_marker=camera_from_marker,
            dictionary=DICTIONARY,
            marker_id=marker_id,
            side=side,
        )
        blurred = cv2.GaussianBlur(drawn, (0, 0), blur)
        noisy = blurred + random.normal(0.0, noise, blurred.shape)
        return np.clip(noisy, 0, 255).astype(np.uint8)

    return take


@pytest.fixture
def plane_depth() -> Callable[..., np.ndarray]:
    """Measure depth on the plane of a marker, everywhere in the image."""

    def measure(camera: PinholeCamera, camera_from_marker: np.ndarray) -> np.ndarray:
        normal, origin = camera_from_marker[:3, 2], camera_from_marker[:3, 3]
        depth = (normal @ origin) / (camera.rays() @ normal)
        return np.where(depth > 0.0, depth, np.nan)

    return measure
