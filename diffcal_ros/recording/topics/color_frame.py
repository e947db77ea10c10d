# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""One colour image, and the raw encodings it comes in."""

from dataclasses import dataclass
from io import BytesIO

import numpy as np
from numpy.typing import NDArray

ByteArray = NDArray[np.uint8]

# For each encoding the channels that give blue, green and red.
_CHANNELS = {
    'bgr8': (3, (0, 1, 2)),
    'rgb8': (3, (2, 1, 0)),
    'bgra8': (4, (0, 1, 2)),
    'rgba8': (4, (2, 1, 0)),
    'mono8': (1, (0, 0, 0)),
}
COLOR_ENCODINGS = tuple(_CHANNELS)
# A few kilobytes may claim to be gigabytes of pixels.
_MOST_PIXELS = 64_000_000


@dataclass(frozen=True)
class ColorFrame:
    """A colour image.

    Attributes:
        image: BGR, shape (H, W, 3), uint8.
        stamp_ns: time of exposure [ns].
        frame_id: name of the optical frame.
    """

    image: ByteArray
    stamp_ns: int
    frame_id: str = ''


def decode_color(
    data: bytes | memoryview | ByteArray, *, encoding: str, width: int, height: int, step: int
) -> ByteArray:
    """Turn a raw colour image into BGR.

    Args:
        data: rows of `step` bytes.
        encoding: one of `COLOR_ENCODINGS`.
        width: columns [px].
        height: rows [px].
        step: bytes from one row to the next, padding included.

    Returns:
        BGR, shape (H, W, 3); always a copy.

    Raises:
        ValueError: for another encoding, or a size that does not fit the data.
    """
    if encoding not in _CHANNELS:
        raise ValueError(f'colour encoding is {encoding!r}: {", ".join(COLOR_ENCODINGS)} are read')
    depth, order = _CHANNELS[encoding]
    if width <= 0 or height <= 0 or step < width * depth:
        raise ValueError(
            f'colour image of {width}x{height} {encoding} has {step} bytes a row: '
            f'at least {max(width, 0) * depth} are needed'
        )
    raw = np.frombuffer(data, dtype=np.uint8)
    if raw.size < step * (height - 1) + width * depth:
        raise ValueError(
            f'colour image of {width}x{height} {encoding} holds {raw.size} bytes: '
            f'{step * height} are needed; the message is cut off'
        )
    image = np.ndarray((height, width, depth), np.uint8, raw.data, strides=(step, depth, 1))
    return np.ascontiguousarray(image[..., list(order)])


def decode_compressed(data: bytes | memoryview | ByteArray) -> ByteArray:
    """Turn a JPEG or PNG image into BGR, shape (H, W, 3).

    Raises:
        ValueError: when it is neither.
    """
    from PIL import Image

    try:
        with Image.open(BytesIO(bytes(data)), formats=('JPEG', 'PNG')) as image:
            if image.width * image.height > _MOST_PIXELS:
                raise ValueError(f'it would have {image.width}x{image.height} pixels')
            rgb = np.asarray(image.convert('RGB'))
    except Exception as error:  # Decoders raise what they happen to raise.
        raise ValueError(
            f'the compressed image is no JPEG or PNG that can be read ({error})'
        ) from error
    return np.ascontiguousarray(rgb[..., ::-1])
