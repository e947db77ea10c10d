# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Depth images come out of PNG and RVL as they went in."""

import struct

from diffcal_ros.errors import RecordingError
from diffcal_ros.recording.topics.compressed_depth import decode_compressed_depth
import numpy as np
import pytest
from support.packed_depth import METRES_PNG, metres_png, PNG, png, RVL, rvl


@pytest.fixture
def depth():
    """Noise over a slope, with holes of all sizes and a jump as large as there are."""
    random = np.random.default_rng(4)
    made = (400 + np.arange(48)[:, None] + random.integers(0, 9, (48, 61))).astype(np.uint16)
    made[random.random(made.shape) < 0.2] = 0
    made[10:12], made[20, :30], made[47, 50:] = 0, 65535, 0
    return made


@pytest.mark.parametrize(
    ('pack', 'kind'), [(png, PNG), (png, '16UC1; compressedDepth'), (rvl, RVL)]
)
def test_it_comes_out_as_it_went_in(depth, pack, kind):
    found = decode_compressed_depth(pack(depth), kind)
    assert found.dtype == np.uint16
    np.testing.assert_array_equal(found, depth)


def test_metres_are_unpacked_from_their_inverse(depth):
    metres = np.where(depth == 0, np.nan, depth / 1000.0)
    found = decode_compressed_depth(metres_png(metres), METRES_PNG)
    np.testing.assert_array_equal(np.isnan(found), depth == 0)
    np.testing.assert_allclose(found[depth == 400], 0.4, rtol=1e-4)


@pytest.mark.parametrize(
    ('spoil', 'kind', 'words'),
    [
        (lambda data: data, 'bgr8; jpeg compressed bgr8', 'the format is'),
        (lambda data: data[:8], RVL, 'cut off'),
        (lambda data: data[:-40], RVL, 'cut off|beyond its end'),
        (lambda data: data[:12] + b'\xff' * 40, RVL, 'it is damaged'),
        (lambda data: data[:20] + b'\xff' * 40, RVL, 'cut off'),
        (lambda data: data, PNG, 'no 16-bit PNG'),
    ],
)
def test_what_is_damaged_is_told(depth, spoil, kind, words):
    with pytest.raises(RecordingError, match=words):
        decode_compressed_depth(spoil(rvl(depth)), kind)


def test_a_few_bytes_that_claim_gigabytes_are_refused(depth):
    content = bytearray(png(depth))
    content[12 + 16 : 12 + 24] = struct.pack('>II', 1 << 15, 1 << 15)
    with pytest.raises(RecordingError, match='says it is 32768x32768'):
        decode_compressed_depth(content, PNG)
