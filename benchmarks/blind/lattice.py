# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Cut the blocks of a shape into small cells."""

from collections.abc import Sequence
from dataclasses import dataclass
import itertools

import numpy as np
from numpy.typing import NDArray

from benchmarks.blind.shapes import FloatArray, Shape


@dataclass(frozen=True)
class Lattice:
    """Small cells of a body.

    Attributes:
        ticks: coordinates of the cells' faces along x, y and z [m].
        cells: index triples of the filled cells, shape (C, 3).
    """

    ticks: tuple[FloatArray, FloatArray, FloatArray]
    cells: NDArray[np.int64]


def cut(
    shape: Shape, size: tuple[float, float, float], held_cells: int, grading: float = 1.0
) -> Lattice:
    """Cut a shape's blocks.

    Args:
        shape: the body.
        size: largest edge of a cell along x, y and z [m].
        held_cells: number of cells along the held section.
        grading: above 1, cells grow from the clamp's face, where strain is singular.
    """
    ticks, counts = [], []
    for axis in range(3):
        breaks = shape.breaks[axis]
        parts, own = [np.array([breaks[0]])], []
        for block, (low, high) in enumerate(itertools.pairwise(breaks)):
            count = max(1, round((high - low) / size[axis] + 0.49))
            if axis == 0 and block == 0:
                count = held_cells
            steps = np.linspace(0.0, 1.0, count + 1)[1:]
            if axis == 0 and block == 1:
                steps = steps**grading
            parts.append(low + (high - low) * steps)
            own.append(count)
        ticks.append(np.concatenate(parts))
        counts.append(own)
    return _filled(shape, ticks, counts)


def cut_by_counts(shape: Shape, counts: Sequence[Sequence[int]]) -> Lattice:
    """Cut a shape's blocks into so many equal cells each.

    Args:
        shape: the body.
        counts: of each block along x, y and z.
    """
    ticks = []
    for breaks, numbers in zip(shape.breaks, counts, strict=True):
        ends = zip(itertools.pairwise(breaks), numbers, strict=True)
        parts = [np.linspace(low, high, count + 1)[1:] for (low, high), count in ends]
        ticks.append(np.concatenate([[breaks[0]], *parts]))
    return _filled(shape, ticks, counts)


def _filled(shape: Shape, ticks: Sequence[FloatArray], counts: Sequence[Sequence[int]]) -> Lattice:
    owners = [np.repeat(np.arange(len(own)), own) for own in counts]
    filled = shape.solid[np.ix_(*owners)]
    return Lattice((ticks[0], ticks[1], ticks[2]), np.argwhere(filled))


def halved(ticks: FloatArray) -> FloatArray:
    """Insert the middle between any two ticks."""
    fine = np.empty(2 * len(ticks) - 1)
    fine[0::2] = ticks
    fine[1::2] = 0.5 * (ticks[:-1] + ticks[1:])
    return fine


def numbered(
    triples: NDArray[np.int64], ticks: tuple[FloatArray, FloatArray, FloatArray]
) -> tuple[FloatArray, NDArray[np.int64]]:
    """Number the lattice points that cells use.

    Args:
        triples: index triple of each cell's points, shape (C, n, 3).
        ticks: coordinates they index.

    Returns:
        Coordinates in the lattice, shape (N, 3), and points of each cell, shape (C, n).
    """
    shape = tuple(len(axis) for axis in ticks)
    flat = np.ravel_multi_index(tuple(np.moveaxis(triples, -1, 0)), shape)
    used, cells = np.unique(flat, return_inverse=True)
    index = np.unravel_index(used, shape)
    points = np.stack([axis[i] for axis, i in zip(ticks, index, strict=True)], axis=1)
    return points, cells.reshape(flat.shape)
