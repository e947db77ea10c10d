# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
from diffcal_ros import rigid_transform as rt
import numpy as np
import pytest


@pytest.mark.parametrize(
    'vector',
    [
        (0.0, 0.0, 0.0),
        (1e-9, -2e-9, 1e-9),
        (0.3, -0.7, 1.1),
        (np.pi - 1e-6, 0.0, 0.0),
        (0.0, np.pi / np.sqrt(2), -np.pi / np.sqrt(2)),
    ],
)
def test_rotation_vector_survives_matrix_and_quaternion(vector) -> None:
    rotation = rt.rotation_matrix(np.array(vector))
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    back = rt.rotation_matrix(rt.rotation_vector(rotation))
    np.testing.assert_allclose(back, rotation, atol=1e-12)
    again = rt.rotation_from_quaternion(3.0 * rt.quaternion_xyzw(rotation))
    np.testing.assert_allclose(again, rotation, atol=1e-12)


def test_quarter_turn_about_z_takes_x_to_y() -> None:
    rotation = rt.rotation_matrix(np.array([0.0, 0.0, np.pi / 2]))
    np.testing.assert_allclose(rotation @ [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], atol=1e-15)


def test_inverse_undoes_apply(random: np.random.Generator) -> None:
    pose = rt.transform(rt.rotation_matrix(random.normal(size=3)), random.normal(size=3))
    points = random.normal(size=(5, 3))
    np.testing.assert_allclose(rt.apply(rt.inverse(pose), rt.apply(pose, points)), points)
    np.testing.assert_allclose(rt.apply(pose, points[0]), (pose @ [*points[0], 1.0])[:3])


def test_angle_between_is_the_angle_turned() -> None:
    first = rt.transform(rt.rotation_matrix(np.array([0.2, 0.1, -0.4])), np.zeros(3))
    turned = first @ rt.transform(rt.rotation_matrix(np.array([0.0, 0.25, 0.0])), np.ones(3))
    assert rt.angle_between(first, turned) == pytest.approx(0.25)


@pytest.mark.parametrize(
    ('matrix', 'message'),
    [
        (np.eye(3), '4x4'),
        (np.diag([1.0, 1.0, 2.0, 1.0]), 'not rigid'),
        (np.diag([1.0, 1.0, -1.0, 1.0]), 'mirrors'),
        (np.full((4, 4), np.nan), 'NaN'),
        (np.eye(4) + np.array([[0] * 4, [0] * 4, [0] * 4, [1, 0, 0, 0]]), 'last row'),
    ],
)
def test_refuses_what_is_not_rigid(matrix, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        rt.check_rigid('world_from_object', matrix)
