# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Depth images packed as compressed_depth_image_transport packs them, pixel by pixel."""

import struct
from typing import Any

import cv2
from diffcal_ros.recording.topics.ros_messages import header, message
import numpy as np

PNG, RVL = '16UC1; compressedDepth png', '16UC1; compressedDepth rvl'
METRES_PNG = '32FC1; compressedDepth png'
# What a driver quantises metres with unless it is told otherwise: up to 10 m, in steps of 100.
_FARTHEST, _QUANTIZATION = 10.0, 100.0


def png(depth: np.ndarray, scale: float = 0.0, offset: float = 0.0) -> bytes:
    """Pack 16-bit pixels, shape (H, W), as PNG."""
    return struct.pack('<iff', 0, scale, offset) + cv2.imencode('.png', depth)[1].tobytes()


def rvl(depth: np.ndarray) -> bytes:
    """Pack 16-bit pixels number by number, as the paper's C code does."""
    groups: list[int] = []

    def put(value: int) -> None:
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


def metres_png(metres: np.ndarray) -> bytes:
    """Quantise metres by their inverse, NaN invalid, and pack them as PNG."""
    scale = _QUANTIZATION * (_QUANTIZATION + 1.0)
    offset = 1.0 - scale / _FARTHEST
    steps = np.where(np.isfinite(metres), scale / metres + offset, 0.0)
    return png(steps.astype(np.uint16), scale, offset)


def packed_message(content: bytes, kind: str, *, stamp_ns: int, frame_id: str) -> Any:
    """Make a sensor_msgs/CompressedImage."""
    return message(
        'sensor_msgs/msg/CompressedImage',
        header=header(stamp_ns, frame_id),
        format=kind,
        data=np.frombuffer(content, np.uint8),
    )
