# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Transforms that do not change, chained from frame to frame."""

from collections import deque
from collections.abc import Iterable
from typing import NamedTuple

from diffcal_ros.rigid_transform import inverse
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


class FrameTransform(NamedTuple):
    """One edge of a frame tree.

    Attributes:
        parent: frame name.
        child: frame name.
        parent_from_child: shape (4, 4).
    """

    parent: str
    child: str
    parent_from_child: FloatArray


def chain(edges: Iterable[FrameTransform], target: str, source: str) -> FloatArray | None:
    """Return target_from_source along known edges, shape (4, 4), or None without a way."""
    neighbours: dict[str, list[tuple[str, FloatArray]]] = {}
    for parent, child, parent_from_child in edges:
        neighbours.setdefault(parent.lstrip('/'), []).append(
            (child.lstrip('/'), parent_from_child)
        )
        neighbours.setdefault(child.lstrip('/'), []).append(
            (parent.lstrip('/'), inverse(parent_from_child))
        )
    goal = source.lstrip('/')
    start = target.lstrip('/')
    found = {start: np.eye(4)}
    waiting = deque([start])
    while waiting:
        frame = waiting.popleft()
        if frame == goal:
            return found[frame]
        for neighbour, frame_from_neighbour in neighbours.get(frame, []):
            if neighbour not in found:
                found[neighbour] = found[frame] @ frame_from_neighbour
                waiting.append(neighbour)
    return None
