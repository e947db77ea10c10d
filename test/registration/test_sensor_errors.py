# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Unknowns beside a pose have the covariance that they are said to have."""

from diffcal_ros.registration.sensor_errors import outline_columns, SmoothField
import numpy as np
import pytest


def test_a_smooth_field_has_the_covariance_of_its_lengths():
    low, high = np.array([100.0, 40.0]), np.array([220.0, 190.0])
    field = SmoothField.over(low, high)
    pixels = np.random.default_rng(2).uniform(low, high, (300, 2))
    columns = field.columns(pixels)
    assert columns.shape == (300, field.count)
    square = ((pixels[:, None] - pixels[None]) ** 2).sum(axis=2)
    wanted = sum(np.exp(-square / length**2) for length in (40.0, 80.0, 160.0)) / 3.0
    np.testing.assert_allclose(columns @ columns.T, wanted, atol=0.02)


def test_pieces_of_one_edge_are_off_together_and_of_others_less():
    pixels = np.array([[50.0, 50.0], [52.0, 58.0], [50.0, 200.0], [300.0, 50.0]])
    normals = np.array([[1.0, 0.0], [1.0, 0.02], [1.0, 0.0], [-1.0, 0.0]])
    scale = np.full(4, 5e-4)
    columns = outline_columns(pixels, normals, scale)
    covariance = columns @ columns.T / scale[0] ** 2
    near, along, across = covariance[0, 1], covariance[0, 2], covariance[0, 3]
    assert near == pytest.approx(0.5**2 + 0.2**2 + 0.2**2)
    assert along == pytest.approx(0.5**2 + 0.2**2)
    assert across == pytest.approx(0.5**2)
    assert outline_columns(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0)).shape[0] == 0
