# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Depth images come out of PNG and RVL as they went in."""

import struct

import cv2
from diffcal_ros.errors import RecordingError
from diffcal_ros.recording.compressed_depth import decode_compressed_depth
import numpy as np
import pytest

PNG, RVL = '16UC1; compressedDepth png', '16UC1; compressedDepth rvl'


@pytest.fixture
def depth():
    """Noise over a slope, with holes of all sizes and a jump as large as there are."""
    random = np.random.default_rng(4)
    made = (400 + np.arange(48)[:, None] + random.integers(0, 9, (48, 61))).astype(np.uint16)
    made[random.random(made.shape) < 0.2] = 0
    made[10:12], made[20, :30], made[47, 50:] = 0, 65535, 0
    return made


def png(depth, scale=0.0, offset=0.0):
    return struct.pack('<iff', 0, scale, offset) + cv2.imencode('.png', depth)[1].tobytes()


def rvl(depth):
    """Pack number by number, as the paper's C code does."""
    groups = []

    def put(value):
        while True:
            groups.append((value & 7) | (8 if value > 7 else 0))
            value >>= 3
            if not value:
                return

    pixels, place, last = depth.ravel().tolist(), 0, 0
    while place < len(pixels):
        empty = place
        while empty < len(pixels) and not pixels[empty]:
            empty += 1
        full = empty
        while full < len(pixels) and pixels[full]:
            full += 1
        put(empty - place)
        put(full - empty)
        for value in pixels[empty:full]:
            delta, last = value - last, value
            put((delta << 1) ^ (delta >> 31))
        place = full
    groups += [0] * (-len(groups) % 8)
    words = [
        int(''.join(f'{group:x}' for group in groups[at : at + 8]), 16)
        for at in range(0, len(groups), 8)
    ]
    rows, columns = depth.shape
    return struct.pack(f'<iffii{len(words)}I', 1, 0.0, 0.0, columns, rows, *words)


@pytest.mark.parametrize(
    ('pack', 'kind'), [(png, PNG), (png, '16UC1; compressedDepth'), (rvl, RVL)]
)
def test_it_comes_out_as_it_went_in(depth, pack, kind):
    found = decode_compressed_depth(pack(depth), kind)
    assert found.dtype == np.uint16
    np.testing.assert_array_equal(found, depth)


def test_metres_are_unpacked_from_their_inverse(depth):
    metres = np.where(depth == 0, np.nan, depth / 1000.0)
    # As the transport does it: depth_max 10 m, a quantisation of 100.
    scale = 100.0 * 101.0
    offset = 1.0 - scale / 10.0
    steps = np.where(depth == 0, 0, scale / metres + offset).astype(np.uint16)
    found = decode_compressed_depth(png(steps, scale, offset), '32FC1; compressedDepth png')
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
