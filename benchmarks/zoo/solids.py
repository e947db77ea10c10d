# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bodies as blocks between planes, which any mesh of them follows exactly.

Object frame: x runs from the held end to the tip, and 0 <= x <= `clamp` is held. Heights of block
faces change linearly between breaks along x, so that every face of the body is plane: a coarse and
a fine mesh have the same outline and the same volume.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

BoolArray = NDArray[np.bool_]
FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Counts = tuple[tuple[int, ...], tuple[int, ...], tuple[int, ...]]


@dataclass(frozen=True)
class Solid:
    """A body of blocks.

    Attributes:
        name: of its kind.
        x: breaks along the body [m], shape (X,).
        y: block faces at each break along x [m], shape (X, Y); radii where it is round.
        z: likewise, shape (X, Z); the turn in corners of the polygon where it is round.
        filled: blocks that there are, shape (X - 1, Y - 1, Z - 1).
        cells: of the mesh that is fitted, in each block along each axis.
        clamp: end of the held section [m]; a break.
        is_round: whether the section is a ring about x with as many corners as blocks along z.
    """

    name: str
    x: FloatArray
    y: FloatArray
    z: FloatArray
    filled: BoolArray
    cells: Counts
    clamp: float
    is_round: bool = False

    @property
    def free_length(self) -> float:
        """From the clamp to the tip [m]."""
        return float(self.x[-1] - self.clamp)

    def scaled(self, factor: float) -> 'Solid':
        """Return the body in another size."""
        z = self.z if self.is_round else factor * self.z
        return replace(self, x=factor * self.x, y=factor * self.y, z=z, clamp=factor * self.clamp)

    def place(self, blocks: FloatArray) -> FloatArray:
        """Return where points are, object frame [m], shape (..., 3).

        Args:
            blocks: number of the block along each axis plus the share of it, shape (..., 3).
        """
        row, along = _split(blocks[..., 0], len(self.x))
        x = (1.0 - along) * self.x[row] + along * self.x[row + 1]
        y, z = (
            (1.0 - along) * _between(table[row], blocks[..., axis])
            + along * _between(table[row + 1], blocks[..., axis])
            for axis, table in ((1, self.y), (2, self.z))
        )
        if self.is_round:
            y, z = y * self._polygon(z)[0], y * self._polygon(z)[1]
        return np.stack([x, y, z], axis=-1)

    def _polygon(self, turn: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return points on the polygon's sides, radius 1 at its corners."""
        count = self.z.shape[1] - 1
        corners = 2.0 * np.pi * np.arange(count + 1) / count
        numbers = np.arange(count + 1)
        return np.interp(turn, numbers, np.cos(corners)), np.interp(turn, numbers, np.sin(corners))


@dataclass(frozen=True)
class Grid:
    """Cells of a body.

    Attributes:
        solid: the body.
        ticks: faces of the cells along each axis, in blocks.
        filled: cells that there are, shape (x, y, z).
    """

    solid: Solid
    ticks: tuple[FloatArray, FloatArray, FloatArray]
    filled: BoolArray

    @property
    def cells(self) -> IntArray:
        """Index triples of the cells, shape (C, 3)."""
        return np.argwhere(self.filled)

    def numbered(self, triples: IntArray, parts: int) -> tuple[FloatArray, IntArray]:
        """Number the points that cells use.

        Args:
            triples: points of each cell on the grid with `parts` steps a cell, shape (C, n, 3).
            parts: 1 for corners, 2 where edges have a node in the middle.

        Returns:
            Points in the object frame [m], shape (N, 3), and those of each cell, shape (C, n).
        """
        ticks = [_finer(axis, parts) for axis in self.ticks]
        if self.solid.is_round:
            triples = triples.copy()
            triples[..., 2] %= len(ticks[2]) - 1
        shape = tuple(len(axis) for axis in ticks)
        flat = np.ravel_multi_index(tuple(np.moveaxis(triples, -1, 0)), shape)
        used, cells = np.unique(flat, return_inverse=True)
        index = np.unravel_index(used, shape)
        blocks = np.stack([axis[i] for axis, i in zip(ticks, index, strict=True)], axis=1)
        return self.solid.place(blocks), cells.reshape(flat.shape)

    def outer_faces(self) -> IntArray:
        """Return faces of one cell only as (cell, axis, side), shape (F, 3)."""
        number = np.full(self.filled.shape, -1)
        number[self.filled] = np.arange(int(self.filled.sum()))
        faces = []
        for axis in range(3):
            for side in (-1, 1):
                beside = np.roll(self.filled, -side, axis)
                if not (axis == 2 and self.solid.is_round):
                    edge = [slice(None)] * 3
                    edge[axis] = slice(-1, None) if side > 0 else slice(0, 1)
                    beside[tuple(edge)] = False
                own = number[self.filled & ~beside]
                faces.append(np.stack([own, np.full_like(own, axis), np.full_like(own, side)], 1))
        return np.concatenate(faces)


def cut(solid: Solid, counts: Counts) -> Grid:
    """Cut each block of a body into that many cells along each axis."""
    ticks, owners = [], []
    for axis_counts in counts:
        parts = [block + np.arange(n) / n for block, n in enumerate(axis_counts)]
        ticks.append(np.append(np.concatenate(parts), float(len(axis_counts))))
        owners.append(np.repeat(np.arange(len(axis_counts)), axis_counts))
    return Grid(solid, (ticks[0], ticks[1], ticks[2]), solid.filled[np.ix_(*owners)])


def _split(places: FloatArray, count: int) -> tuple[IntArray, FloatArray]:
    block = np.clip(np.floor(places).astype(np.int64), 0, count - 2)
    return block, places - block


def _between(rows: FloatArray, places: FloatArray) -> FloatArray:
    """Interpolate each row of faces, shape (..., n), at its place in blocks, shape (...)."""
    block, share = _split(places, rows.shape[-1])
    low = np.take_along_axis(rows, block[..., None], -1)[..., 0]
    high = np.take_along_axis(rows, block[..., None] + 1, -1)[..., 0]
    return (1.0 - share) * low + share * high


def _finer(ticks: FloatArray, parts: int) -> FloatArray:
    return np.interp(np.arange(parts * (len(ticks) - 1) + 1) / parts, np.arange(len(ticks)), ticks)
