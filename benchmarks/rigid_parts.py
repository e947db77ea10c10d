# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Rigid parts of a rig: closed surfaces of blocks put together, and a cylinder."""

from collections.abc import Sequence
from itertools import product

from diffcal_ros.scene.model import Fixture
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Block = tuple[tuple[float, float], tuple[float, float], tuple[float, float]]


def blocks(parts: Sequence[Block]) -> Fixture:
    """Return the closed surface of blocks that share corners, edges or faces, or overlap.

    Args:
        parts: limits along x, y and z [m].
    """
    ticks = [np.unique([limit for part in parts for limit in part[axis]]) for axis in range(3)]
    middles = [0.5 * (own[1:] + own[:-1]) for own in ticks]
    filled = np.zeros([len(own) + 2 for own in middles], dtype=bool)
    for part in parts:
        inside = [
            (own > low) & (own < high) for own, (low, high) in zip(middles, part, strict=True)
        ]
        filled[1:-1, 1:-1, 1:-1] |= (
            inside[0][:, None, None] & inside[1][None, :, None] & inside[2][None, None, :]
        )
    corners: dict[tuple[int, ...], int] = {}
    triangles = []
    for cell, axis, side in product(np.argwhere(filled), range(3), (0, 1)):
        beyond = cell.copy()
        beyond[axis] += 2 * side - 1
        if filled[tuple(beyond)]:
            continue
        first, second = (axis + 1) % 3, (axis + 2) % 3
        ring = []
        for along, across in ((0, 0), (1, 0), (1, 1), (0, 1)):
            corner = cell - 1
            corner[axis] += side
            corner[first] += along
            corner[second] += across
            ring.append(corners.setdefault(tuple(int(own) for own in corner), len(corners)))
        ring = ring if side else ring[::-1]
        triangles += [ring[:3], [ring[0], ring[2], ring[3]]]
    positions = np.array([[ticks[axis][own[axis]] for axis in range(3)] for own in corners])
    return Fixture(positions, np.array(triangles, dtype=np.int32))


def block(half: FloatArray, back: float) -> Fixture:
    """Return a plain block from x = -back to 0, which half turns take to itself.

    Args:
        half: of its sides along y and z [m], shape (2,).
        back: its length [m].
    """
    y, z = half
    return blocks([((-back, 0.0), (-y, y), (-z, z))])


def bracket(half: FloatArray, back: float) -> Fixture:
    """Return a block with a leg along y at its far end: an L that no turn takes to itself."""
    y, z = half
    leg = ((-back, -0.6 * back), (y, y + 0.04), (-z, z))
    return blocks([((-back, 0.0), (-y, y), (-z, z)), leg])


def clamp(half: FloatArray, back: float, gap: float) -> Fixture:
    """Return two jaws, the upper one thicker, with a gap between them, on a back.

    Args:
        half: of the lower jaw's reach along y, and along z [m], shape (2,).
        back: length of jaws and back [m].
        gap: half of what is between the jaws [m].
    """
    y, z = half
    return blocks(
        [
            ((-back, -0.7 * back), (-y, y + 0.01), (-z, z)),
            ((-0.7 * back, 0.0), (-y, -gap), (-z, z)),
            ((-0.7 * back, 0.0), (gap, y + 0.01), (-z, z)),
        ]
    )


def cylinder(radius: float, back: float, segments: int = 96) -> Fixture:
    """Return a cylinder along x, which any turn about its axis takes to itself."""
    angle = 2.0 * np.pi * np.arange(segments) / segments
    ring = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    near = np.column_stack([np.full(segments, -back), ring])
    far = np.column_stack([np.zeros(segments), ring])
    positions = np.vstack([near, far, [[-back, 0.0, 0.0], [0.0, 0.0, 0.0]]])
    own, after = np.arange(segments), (np.arange(segments) + 1) % segments
    first, last = np.full(segments, 2 * segments), np.full(segments, 2 * segments + 1)
    triangles = [
        np.column_stack([own, after, own + segments]),
        np.column_stack([after, after + segments, own + segments]),
        np.column_stack([first, after, own]),
        np.column_stack([last, own + segments, after + segments]),
    ]
    return Fixture(positions, _outward(positions, np.concatenate(triangles)))


def _outward(positions: FloatArray, triangles: NDArray[np.int64]) -> NDArray[np.int32]:
    """Turn all triangles round if they look inwards."""
    a, b, c = (positions[triangles[:, corner]] for corner in range(3))
    volume = float(np.einsum('ti,ti->', a, np.cross(b, c)))
    return (triangles if volume > 0.0 else triangles[:, ::-1]).astype(np.int32)
