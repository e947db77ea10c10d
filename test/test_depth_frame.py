# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
from diffcal_ros.depth_frame import decode_depth
import numpy as np
import pytest

METRES = np.array([[0.25, np.nan, 0.0], [-1.0, np.inf, 1.5]], dtype=np.float32)
MILLIMETRES = np.array([[250, 0, 65535], [1, 2, 1500]], dtype=np.uint16)


def _padded(image: np.ndarray, padding: int, order: str) -> tuple[bytes, int]:
    image = image.astype(image.dtype.newbyteorder(order))
    step = image.shape[1] * image.itemsize + padding
    rows = [row.tobytes() + b'\x7f' * padding for row in image]
    return b''.join(rows), step


@pytest.mark.parametrize('order', ['<', '>'])
@pytest.mark.parametrize('padding', [0, 5])
def test_metres_keep_their_values_and_lose_what_is_no_depth(order: str, padding: int) -> None:
    data, step = _padded(METRES, padding, order)
    depth = decode_depth(
        data, encoding='32FC1', width=3, height=2, step=step, is_bigendian=order == '>'
    )
    np.testing.assert_array_equal(depth, [[0.25, np.nan, np.nan], [np.nan, np.nan, 1.5]])
    assert depth.dtype == np.float32


@pytest.mark.parametrize('order', ['<', '>'])
@pytest.mark.parametrize('padding', [0, 3])
def test_millimetres_become_metres_and_zero_is_invalid(order: str, padding: int) -> None:
    data, step = _padded(MILLIMETRES, padding, order)
    depth = decode_depth(
        data, encoding='16UC1', width=3, height=2, step=step, is_bigendian=order == '>'
    )
    np.testing.assert_allclose(depth, [[0.25, np.nan, 65.535], [0.001, 0.002, 1.5]], rtol=1e-6)


@pytest.mark.parametrize(
    ('changes', 'message'),
    [
        ({'encoding': 'rgb8'}, "depth encoding is 'rgb8'"),
        ({'step': 5}, 'at least 12 are needed'),
        ({'height': 9}, 'the message is cut off'),
    ],
)
def test_refuses_what_does_not_fit(changes, message: str) -> None:
    arguments = {
        'encoding': '32FC1',
        'width': 3,
        'height': 2,
        'step': 12,
        'is_bigendian': False,
    }
    with pytest.raises(ValueError, match=message):
        decode_depth(METRES.tobytes(), **{**arguments, **changes})
