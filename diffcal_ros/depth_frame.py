# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""One depth image in metres, and the raw encodings it comes in (REP-118)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

DepthArray = NDArray[np.float32]

_SCALE_16UC1 = np.float32(0.001)  # Millimetres.
ENCODINGS = ('32FC1', '16UC1', 'mono16')


@dataclass(frozen=True)
class DepthFrame:
    """A depth image.

    Attributes:
        depth: z along the optical axis [m], shape (H, W), float32; NaN where invalid.
        stamp_ns: time of exposure [ns].
        frame_id: name of the optical frame.
    """

    depth: DepthArray
    stamp_ns: int
    frame_id: str = ''

    @property
    def valid_fraction(self) -> float:
        """Share of pixels that hold a depth."""
        return float(np.isfinite(self.depth).mean())


def decode_depth(
    data: bytes | memoryview | NDArray[np.uint8],
    *,
    encoding: str,
    width: int,
    height: int,
    step: int,
    is_bigendian: bool,
) -> DepthArray:
    """Turn a raw depth image into metres.

    32FC1 holds metres and 16UC1 millimetres; zero, negative, NaN and infinite mean invalid.

    Args:
        data: rows of `step` bytes.
        encoding: one of `ENCODINGS`.
        width: columns [px].
        height: rows [px].
        step: bytes from one row to the next, padding included.
        is_bigendian: byte order.

    Returns:
        Depth [m], shape (H, W), float32, NaN where invalid; always a copy.

    Raises:
        ValueError: for another encoding, or a size that does not fit the data.
    """
    if encoding not in ENCODINGS:
        raise ValueError(
            f'depth encoding is {encoding!r}: depth comes as 32FC1 (metres) or 16UC1 '
            '(millimetres); choose the depth topic, not a colour or infrared one'
        )
    kind = np.dtype(np.float32 if encoding == '32FC1' else np.uint16)
    kind = kind.newbyteorder('>' if is_bigendian else '<')
    if width <= 0 or height <= 0 or step < width * kind.itemsize:
        raise ValueError(
            f'depth image of {width}x{height} {encoding} has {step} bytes a row: '
            f'at least {max(width, 0) * kind.itemsize} are needed'
        )
    raw = np.frombuffer(data, dtype=np.uint8)
    if raw.size < step * (height - 1) + width * kind.itemsize:
        raise ValueError(
            f'depth image of {width}x{height} {encoding} holds {raw.size} bytes: '
            f'{step * height} are needed; the message is cut off'
        )
    image = np.ndarray((height, width), kind, buffer=raw.data, strides=(step, kind.itemsize))
    if encoding == '32FC1':
        depth = image.astype(np.float32)
        depth[~(np.isfinite(depth) & (depth > 0.0))] = np.nan
        return depth
    depth = image * _SCALE_16UC1
    depth[image == 0] = np.nan
    return depth
