# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How squarely a camera meets a surface."""

from diffcal_ros.depth.facing import facing_cosines
import numpy as np


def test_a_triangle_faces_the_camera_as_much_as_it_is_turned() -> None:
    angle = np.deg2rad(40.0)
    across, along = np.array([np.cos(angle), 0.0, np.sin(angle)]), np.array([0.0, 1.0, 0.0])
    middle = np.array([0.0, 0.0, 0.5])
    corners = 0.01 * np.array([-across - along, 2.0 * along, across - along])
    corners += middle - corners.mean(axis=0)
    front = np.array([[0, 1, 2]], dtype=np.int32)
    there = facing_cosines(corners, front)
    back = facing_cosines(corners, front[:, ::-1])
    np.testing.assert_allclose(np.abs(there), np.cos(angle), rtol=1e-9)
    np.testing.assert_allclose(back, -there)
    # Its outward normal is that of corners that go round to the left as seen from outside.
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    assert np.sign(there[0]) == -np.sign(normal[2])
