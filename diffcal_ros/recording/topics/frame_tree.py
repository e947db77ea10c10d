# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Frames and the transforms between them over time: what TF knows, without TF.

Only transforms that are needed can be wrong: a tree takes in whatever was sent, and complains of
what lies on the way that somebody asks for.
"""

from bisect import bisect_left
from collections import deque
from dataclasses import dataclass, field

from diffcal_ros.errors import RecordingError
from diffcal_ros.plain_text import plain
from diffcal_ros.rigid_transform import inverse, rotation_matrix, rotation_vector, transform
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_SECOND = 1_000_000_000  # [ns]
# Before the first and after the last sample a transform counts as what it is there, so long [ns].
TOLERANCE_NS = _SECOND // 5


@dataclass
class _Edge:
    """What is known of one transform.

    Attributes:
        parent: frame name.
        child: frame name.
        still: parent_from_child that does not change, shape (4, 4), or None.
        stamps: of the samples [ns].
        samples: parent_from_child at these times, in the order of arrival.
        problem: why the last unusable sample is so; empty without one.
    """

    parent: str
    child: str
    still: FloatArray | None = None
    stamps: list[int] = field(default_factory=list)
    samples: list[FloatArray] = field(default_factory=list)
    problem: str = ''
    is_sorted: bool = True

    @property
    def is_usable(self) -> bool:
        return self.still is not None or bool(self.samples)

    def at(self, stamp_ns: int | None) -> FloatArray:
        """Return parent_from_child at a time [ns]; None: what does not change, or the last."""
        if not self.samples:
            assert self.still is not None
            return self.still
        if not self.is_sorted:
            order = sorted(range(len(self.stamps)), key=self.stamps.__getitem__)
            self.stamps = [self.stamps[index] for index in order]
            self.samples = [self.samples[index] for index in order]
            self.is_sorted = True
        if stamp_ns is None:
            return self.samples[-1]
        after = bisect_left(self.stamps, stamp_ns)
        if 0 < after < len(self.stamps):
            first, last = self.stamps[after - 1], self.stamps[after]
            fraction = (stamp_ns - first) / (last - first)
            return _between(self.samples[after - 1], self.samples[after], fraction)
        nearest = 0 if after == 0 else -1
        off = stamp_ns - self.stamps[nearest]
        if abs(off) > TOLERANCE_NS:
            where = 'before it is first' if off < 0 else 'after it is last'
            raise RecordingError(
                f'the transform from {plain(self.child)} to {plain(self.parent)} is needed '
                f'{abs(off) / _SECOND:.2f} s {where} known ({TOLERANCE_NS / _SECOND:g} s are '
                'tolerated): record /tf as long as the images, with the same clock'
            )
        return self.samples[nearest]


class FrameTree:
    """Transforms between named frames."""

    def __init__(self) -> None:
        self._edges: dict[tuple[str, str], _Edge] = {}

    def add(
        self,
        parent: str,
        child: str,
        parent_from_child: FloatArray | None,
        *,
        stamp_ns: int | None = None,
        problem: str = '',
    ) -> None:
        """Take in a transform.

        Args:
            parent: frame name.
            child: frame name.
            parent_from_child: shape (4, 4); None where what was sent is unusable.
            stamp_ns: when it is so [ns]; None: always.
            problem: why it is unusable.
        """
        key = (parent.lstrip('/'), child.lstrip('/'))
        edge = self._edges.setdefault(key, _Edge(*key))
        if parent_from_child is None:
            edge.problem = problem
        elif stamp_ns is None:
            edge.still = parent_from_child
        else:
            edge.is_sorted &= not edge.stamps or edge.stamps[-1] < stamp_ns
            edge.stamps.append(stamp_ns)
            edge.samples.append(parent_from_child)

    def find(self, target: str, source: str, stamp_ns: int | None = None) -> FloatArray | None:
        """Return target_from_source, shape (4, 4), or None where no way leads there.

        Args:
            target: frame name.
            source: frame name.
            stamp_ns: when [ns]; None: whenever.

        Raises:
            RecordingError: when a transform on the way is unusable, or not known at that time.
        """
        start, goal = target.lstrip('/'), source.lstrip('/')
        if not start or not goal:
            return None
        usable = [edge for edge in self._edges.values() if edge.is_usable]
        way = _way(usable, start, goal)
        if way is None:
            for edge, _ in _way(list(self._edges.values()), start, goal) or ():
                if not edge.is_usable:
                    raise RecordingError(
                        f'the recorded transform from {plain(edge.child)} to '
                        f'{plain(edge.parent)} is unusable, {edge.problem}: record it again'
                    )
            return None
        found = np.eye(4)
        for edge, is_down in way:
            step = edge.at(stamp_ns)
            found = found @ (step if is_down else inverse(step))
        return found

    @property
    def frames(self) -> list[str]:
        """Names of all frames."""
        return sorted({name for key in self._edges for name in key})


def _way(edges: list[_Edge], start: str, goal: str) -> list[tuple[_Edge, bool]] | None:
    """Return the shortest way, each step with whether it goes from parent to child, or None."""
    neighbours: dict[str, list[tuple[str, _Edge, bool]]] = {}
    for edge in edges:
        neighbours.setdefault(edge.parent, []).append((edge.child, edge, True))
        neighbours.setdefault(edge.child, []).append((edge.parent, edge, False))
    ways: dict[str, list[tuple[_Edge, bool]]] = {start: []}
    waiting = deque([start])
    while waiting:
        frame = waiting.popleft()
        if frame == goal:
            return ways[frame]
        for neighbour, edge, is_down in neighbours.get(frame, []):
            if neighbour not in ways:
                ways[neighbour] = [*ways[frame], (edge, is_down)]
                waiting.append(neighbour)
    return None


def _between(first: FloatArray, last: FloatArray, fraction: float) -> FloatArray:
    """Return the transform between two, at a share of the way, shape (4, 4)."""
    turn = rotation_vector(first[:3, :3].T @ last[:3, :3])
    shift = (1.0 - fraction) * first[:3, 3] + fraction * last[:3, 3]
    return transform(first[:3, :3] @ rotation_matrix(fraction * turn), shift)
