# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The observed edge is found along the outline's normal, to the pixel, and nowhere else."""

from diffcal_ros.calibration.residuals.edge_search import ObservedImage
from diffcal_ros.depth.trace import Outline
import numpy as np
import pytest

BODY, WALL = 0.5, 0.9  # [m]
LAST = 29  # Column of the last pixel of the body: its edge lies at 29.5.
_TOLERANCE = 0.02
_REACH = 15


def _image(beyond: float) -> np.ndarray:
    image = np.full((20, 60), beyond, np.float32)
    image[:, : LAST + 1] = BODY
    return image


def _distances(image, columns, *, outward=1.0, masked=None, reach=_REACH, tolerance=_TOLERANCE):
    count = len(columns)
    outline = Outline(
        segments=np.arange(count),
        points=np.array([[column, 9.7, BODY] for column in columns]),
        normals=np.tile([outward, 0.0], (count, 1)),
        lengths=np.ones(count),
        behind=np.full(count, np.nan),
        edges=np.arange(count),
    )
    hidden = np.zeros(image.shape, dtype=bool) if masked is None else masked
    observed = ObservedImage(image, hidden, 'cpu')
    return observed.edge_distances(outline, np.full(count, tolerance), reach)


@pytest.mark.parametrize('beyond', [WALL, np.nan], ids=['wall', 'nothing'])
def test_an_edge_is_found_on_either_side_to_half_a_pixel(beyond) -> None:
    columns = np.array([20.0, 27.3, 29.5, 33.8, 40.0])
    found = _distances(_image(beyond), columns)
    np.testing.assert_allclose(found, LAST + 0.5 - columns, atol=0.51)


def test_the_sign_is_that_of_the_normal() -> None:
    image = _image(WALL)[:, ::-1]
    columns = np.array([35.0])
    found = _distances(np.ascontiguousarray(image), columns, outward=-1.0)
    edge = 59 - LAST - 0.5
    np.testing.assert_allclose(found, columns - edge, atol=0.51)


def test_nothing_is_found_out_of_reach_without_tolerance_or_behind_a_mask() -> None:
    image, columns = _image(WALL), np.array([20.0])
    assert np.isfinite(_distances(image, columns)).all()
    assert np.isnan(_distances(image, columns, reach=5)).all()
    assert np.isnan(_distances(image, columns, tolerance=0.0)).all()
    masked = np.zeros(image.shape, dtype=bool)
    masked[:, LAST : LAST + 2] = True
    assert np.isnan(_distances(image, columns, masked=masked)).all()


def test_what_stands_in_front_is_no_edge_of_the_body() -> None:
    assert np.isnan(_distances(_image(0.2), np.array([25.0]))).all()


def test_a_single_flying_pixel_is_no_edge() -> None:
    image = _image(WALL)
    image[:, 24] = WALL
    found = _distances(image, np.array([24.0]))
    np.testing.assert_allclose(found, LAST + 0.5 - 24.0, atol=0.51)


def test_another_image_takes_the_place_of_the_first() -> None:
    observed = ObservedImage(np.full((4, 5), np.nan, np.float32), np.zeros((4, 5), bool), 'cpu')
    observed.replace(np.full((4, 5), BODY, np.float32))
    np.testing.assert_array_equal(observed._depth.numpy(), np.float32(BODY))
