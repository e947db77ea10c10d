# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is printed: where a marker or a board has ink."""

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

from diffcal_ros.marker import Board, Marker
from diffcal_ros.pose.dictionary import marker_cells
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

_BOARD_RIM = 0.25  # Of a board, in its squares.


class Print(Protocol):
    """Ink on a sheet of paper, whose middle is the origin; x to the right, y up."""

    @property
    def reach(self) -> FloatArray:
        """Half width and half height of the paper with its white rim [m], shape (2,)."""
        ...

    def has_ink(self, points: FloatArray) -> BoolArray:
        """Tell where the paper is black, at points [m], shape (..., 2)."""
        ...


@dataclass(frozen=True)
class MarkerPrint:
    """One marker.

    Attributes:
        cells: its squares, black border included, True is white, shape (n, n).
        side: edge of the black square [m].
        quiet_zone: width of the white rim, in squares of the marker.
    """

    cells: BoolArray
    side: float
    quiet_zone: float = 1.0

    @property
    def reach(self) -> FloatArray:
        """Half width and half height of the paper with its white rim [m], shape (2,)."""
        return np.full(2, self.side / 2.0 + self.quiet_zone * self.side / len(self.cells))

    def has_ink(self, points: FloatArray) -> BoolArray:
        """Tell where the paper is black, at points [m], shape (..., 2)."""
        count = len(self.cells)
        index = np.floor((points * [1.0, -1.0] / self.side + 0.5) * count)
        on_square = ((index >= 0) & (index < count)).all(axis=-1)
        column, row = np.moveaxis(np.clip(index, 0, count - 1).astype(int), -1, 0)
        return np.asarray(on_square & ~self.cells[row, column])


@dataclass(frozen=True)
class BoardPrint:
    """A chessboard with markers in its white squares.

    Attributes:
        board: its squares.
        side: edge of the markers [m].
        markers: their squares, shape (m, n, n), row by row from the top left.
    """

    board: Board
    side: float
    markers: BoolArray

    @property
    def reach(self) -> FloatArray:
        """Half width and half height of the paper with its white rim [m], shape (2,)."""
        return self.board.size / 2.0 + _BOARD_RIM * self.board.square

    def has_ink(self, points: FloatArray) -> BoolArray:
        """Tell where the paper is black, at points [m], shape (..., 2)."""
        board = self.board
        place = (points * [1.0, -1.0] + board.size / 2.0) / board.square
        index = np.floor(place)
        on_board = ((index >= 0) & (index < [board.columns, board.rows])).all(axis=-1)
        last = [board.columns - 1, board.rows - 1]
        column, row = np.moveaxis(np.clip(index, 0, last).astype(int), -1, 0)
        number = self._numbers[row, column]
        count = self.markers.shape[1]
        cell = np.floor(((place - index - 0.5) * board.square / self.side + 0.5) * count)
        on_marker = ((cell >= 0) & (cell < count)).all(axis=-1)
        x, y = np.moveaxis(np.clip(cell, 0, count - 1).astype(int), -1, 0)
        is_marker_ink = on_marker & ~self.markers[number, y, x]
        return np.asarray(on_board & ((number < 0) | is_marker_ink))

    @cached_property
    def _numbers(self) -> NDArray[np.int64]:
        """Marker of each square, -1 for black ones, shape (rows, columns)."""
        white = self.board.squares
        numbers = np.full(white.shape, -1, dtype=np.int64)
        numbers[white] = np.arange(int(white.sum()))
        return numbers


def print_of(marker: Marker) -> Print:
    """Return the print of a scene's marker or board.

    Raises:
        PoseError: for an unknown dictionary or a number beyond it.
    """
    if marker.board is None:
        return MarkerPrint(marker_cells(marker.dictionary, marker.id), marker.side)
    numbers = range(marker.id, marker.id + marker.board.marker_count)
    markers = np.stack([marker_cells(marker.dictionary, number) for number in numbers])
    return BoardPrint(marker.board, marker.side, markers)
