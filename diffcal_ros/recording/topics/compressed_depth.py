# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Depth images as compressed_depth_image_transport packs them: 16-bit PNG, or RVL.

RVL is of Wilson 2017, "Fast lossless depth image compression": runs of empty and of full pixels,
the full ones as differences, all numbers in groups of three bits with a fourth that says that more
follow, eight such groups in a word.
"""

import re
import struct
from typing import Any

import cv2
from diffcal_ros.errors import RecordingError
from diffcal_ros.recording.topics.ros_messages import image_message, stamp_ns_of
import numpy as np
from numpy.typing import NDArray

# A number for the kind of header, and the two that 32FC1 was quantised with.
_HEADER = struct.Struct('<iff')
_SIZE = struct.Struct('<ii')
_FORMAT = re.compile(r'\s*(?P<encoding>\w+)\s*;\s*compressedDepth(?:\s+(?P<kind>png|rvl))?\s*')
_PNG = b'\x89PNG\r\n\x1a\n'
# Where it says how large it is: behind its signature and the head of its first chunk.
_PNG_SIZE = struct.Struct('>16xII')
_MOST_PIXELS = 1 << 26
_LONGEST = 11  # Groups of three bits of one number: 32 bits.


def unpack_depth(packed: Any) -> Any:
    """Turn a sensor_msgs/CompressedImage that was recorded into the sensor_msgs/Image it packs.

    Raises:
        RecordingError: see `decode_compressed_depth`.
    """
    pixels = decode_compressed_depth(packed.data, str(packed.format))
    return image_message(
        pixels,
        encoding=encoding_of(pixels),
        stamp_ns=stamp_ns_of(packed),
        frame_id=str(packed.header.frame_id),
    )


def encoding_of(pixels: NDArray[np.uint16] | NDArray[np.float32]) -> str:
    """Return what sensor_msgs calls depth that was unpacked."""
    return '16UC1' if pixels.dtype == np.uint16 else '32FC1'


def decode_compressed_depth(
    data: bytes | memoryview | NDArray[np.uint8], kind: str
) -> NDArray[np.uint16] | NDArray[np.float32]:
    """Unpack a depth image.

    Args:
        data: of a sensor_msgs/CompressedImage.
        kind: its format, such as "16UC1; compressedDepth png".

    Returns:
        Millimetres as 16UC1 has them, 0 invalid, or metres as 32FC1 has them, NaN invalid, shape
        (H, W).

    Raises:
        RecordingError: for another format, or data that do not hold what the format says.
    """
    known = _FORMAT.fullmatch(kind)
    if known is None or known['encoding'] not in ('16UC1', '32FC1', 'mono16'):
        raise RecordingError(
            f'the format is {kind!r}: 16UC1 or 32FC1, compressedDepth, png or rvl are read'
        )
    content = bytes(data)
    if len(content) <= _HEADER.size:
        raise RecordingError(f'a compressed depth image of {len(content)} bytes is cut off')
    _, scale, offset = _HEADER.unpack_from(content)
    body = content[_HEADER.size :]
    packed = _unpack_rvl(body) if known['kind'] == 'rvl' else _unpack_png(body)
    if known['encoding'] != '32FC1':
        return packed
    # Inverse depth, in steps; 0 is invalid.
    with np.errstate(divide='ignore'):
        depth = np.float32(scale) / (packed.astype(np.float32) - np.float32(offset))
    return np.where(packed == 0, np.float32(np.nan), depth).astype(np.float32)


def _unpack_png(body: bytes) -> NDArray[np.uint16]:
    if body.startswith(_PNG) and len(body) >= _PNG_SIZE.size:
        _check_size(*_PNG_SIZE.unpack_from(body))
    try:
        pixels = cv2.imdecode(np.frombuffer(body, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error:
        pixels = None
    if pixels is None or pixels.ndim != 2 or pixels.dtype != np.uint16:
        raise RecordingError('a compressed depth image holds no 16-bit PNG: it is damaged')
    return np.asarray(pixels, dtype=np.uint16)


def _unpack_rvl(body: bytes) -> NDArray[np.uint16]:
    if len(body) < _SIZE.size:
        raise RecordingError('a compressed depth image has no size: it is cut off')
    columns, rows = _SIZE.unpack_from(body)
    _check_size(columns, rows)
    numbers = _numbers(body[_SIZE.size :])
    pixels = np.zeros(columns * rows, dtype=np.int64)
    place = at = last = 0
    while place < len(pixels):
        if at + 2 > len(numbers):
            raise RecordingError(
                'a compressed depth image ends before its last row: it is cut off'
            )
        place += int(numbers[at])
        count = int(numbers[at + 1])
        deltas = numbers[at + 2 : at + 2 + count]
        if place + count > len(pixels) or len(deltas) < count:
            raise RecordingError('a compressed depth image runs beyond its end: it is damaged')
        if count:
            # Differences are zigzag coded: 0, -1, 1, -2, ...
            pixels[place : place + count] = last + np.cumsum((deltas >> 1) ^ -(deltas & 1))
            last = int(pixels[place + count - 1])
        place, at = place + count, at + 2 + count
    return pixels.astype(np.uint16).reshape(rows, columns)


def _check_size(columns: int, rows: int) -> None:
    """Refuse what a few bytes may claim."""
    if columns <= 0 or rows <= 0 or columns * rows > _MOST_PIXELS:
        raise RecordingError(
            f'a compressed depth image says it is {columns}x{rows}: it is damaged'
        )


def _numbers(body: bytes) -> NDArray[np.int64]:
    """Read all numbers of an RVL stream; what is cut off at its end is left out."""
    words = np.frombuffer(body, '<u4', count=len(body) // 4)
    shifts = np.arange(28, -4, -4, dtype=np.uint32)
    groups = ((words[:, None] >> shifts) & 0xF).ravel().astype(np.int64)
    ends = np.flatnonzero(groups < 8)
    groups = groups[: ends[-1] + 1] if len(ends) else groups[:0]
    begins = np.concatenate([[0], ends[:-1] + 1]) if len(ends) else ends
    within = np.arange(len(groups)) - np.repeat(begins, ends - begins + 1)
    if len(within) and within.max() >= _LONGEST:
        raise RecordingError('a compressed depth image holds a number too long: it is damaged')
    shifted = (groups & 7) << (3 * within)
    return np.add.reduceat(shifted, begins) if len(ends) else shifted
