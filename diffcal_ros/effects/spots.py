# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A map of spots on a body's surface: prints, stickers, speckles, whatever their shape.

The surface is cut into cells, `ROWS` along the free length and `ROUND` around the body, an equal
share of them on each of four sides. Settings are numbers, two of each row: `spots_1_1` is of the
row at the clamp on the sides towards the body's axes across it, `spots_2_64` of the one at the tip
on the other two, and their bits say which cells are in a spot.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]

ROWS, SIDES, OF_SIDE = 64, 4, 24
ROUND = SIDES * OF_SIDE
# All settings, those of a row next to each other, and what their names are like.
_HALVES = 2
NAMES = tuple(f'spots_{half}_{row}' for row in range(1, ROWS + 1) for half in (1, _HALVES))
SETTINGS = dict.fromkeys(NAMES, 0.0)
PATTERN = 'spots_[12]_[0-9]+'
# So many bits a float holds exactly.
_OF_HALF = ROUND // _HALVES
LARGEST = float(2**_OF_HALF - 1)
_BITS = 2 ** np.arange(_OF_HALF, dtype=np.int64)


@dataclass(frozen=True)
class Spots:
    """The part of a surface that is in spots, in place of `surface_parts.SurfacePart`.

    Attributes:
        cells: which cells are, shape (ROWS, ROUND).
        times: how many times as much it adds to what is read as the first part.
    """

    cells: BoolArray
    times: float = 1.0

    def holds(self, places: FloatArray, margin: tuple[float, float] = (0.0, 0.0)) -> BoolArray:
        """Tell which points are in a spot, shape (...,).

        Args:
            places: see `BodyAxes.on_surface`, shape (..., 3).
            margin: not used: all of a spot is next to its border.
        """
        return np.asarray(self.cells.ravel()[cells_of(places)])

    @property
    def borders(self) -> tuple[float, ...]:
        """Where it begins and ends along the body: it has no such place."""
        return ()

    @property
    def limits_across(self) -> list[list[float]]:
        """Limits across both axes: likewise."""
        return [[], []]

    @property
    def reach(self) -> tuple[float, float]:
        """From where to where there are spots, as shares of the free length."""
        rows = np.flatnonzero(self.cells.any(axis=1))
        return (float(rows[0]) / ROWS, float(rows[-1] + 1) / ROWS) if len(rows) else (1.0, 1.0)


def cells_of(places: FloatArray) -> IntArray:
    """Return the number of the cell of each place, row by row from the clamp on, shape (...,).

    Args:
        places: see `BodyAxes.on_surface`, shape (..., 3).
    """
    row = np.clip((places[..., 0] * ROWS).astype(np.int64), 0, ROWS - 1)
    a, b = places[..., 1], places[..., 2]
    is_across = np.abs(a) >= np.abs(b)
    ahead, aside = np.where(is_across, a, b), np.where(is_across, b, -a)
    # Around the body, as sides follow each other: along a, b, -a and -b.
    side = np.where(is_across, 0, 1) + np.where(ahead < 0.0, 2, 0)
    share = 0.5 * (1.0 + aside / np.where(ahead == 0.0, 1.0, ahead))
    within = np.clip((share * OF_SIDE).astype(np.int64), 0, OF_SIDE - 1)
    return np.asarray(row * ROUND + side * OF_SIDE + within)


def spot_settings(cells: BoolArray) -> dict[str, float]:
    """Return the settings of a map, those that are 0 left out.

    Args:
        cells: which are in spots, shape (ROWS, ROUND).
    """
    numbers = (cells.reshape(-1, _OF_HALF) * _BITS).sum(axis=1)
    return {name: float(own) for name, own in zip(NAMES, numbers, strict=True) if own}


def spots_of(settings: Mapping[str, float]) -> Spots | None:
    """Return the spots that settings state; None where they state none."""
    numbers = np.array([settings.get(name, 0.0) for name in NAMES]).astype(np.int64)
    if not numbers.any():
        return None
    return Spots(((numbers[:, None] & _BITS) > 0).reshape(ROWS, ROUND))
