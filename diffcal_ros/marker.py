# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The fiducial marker or board on the rig: what is printed, and where it sits."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

FEWEST_CORNERS = 6  # Of a board that give a pose, not on one line.


@dataclass(frozen=True)
class Board:
    """A ChArUco board: a chessboard with a marker in the middle of each white square.

    Attributes:
        columns: squares across.
        rows: squares down.
        square: edge of a square [m].
        is_legacy: made by OpenCV before 4.6, whose boards with an even number of rows have a
            white square in the top left corner in place of a black one.
    """

    columns: int
    rows: int
    square: float
    is_legacy: bool = False

    @property
    def size(self) -> FloatArray:
        """Width and height of all squares [m], shape (2,)."""
        return self.square * np.array([self.columns, self.rows], dtype=np.float64)

    @property
    def corner_count(self) -> int:
        """Number of inner corners, where four squares meet."""
        return (self.columns - 1) * (self.rows - 1)

    @property
    def marker_count(self) -> int:
        """Number of white squares."""
        return self.columns * self.rows // 2

    @property
    def starts_white(self) -> bool:
        """Tell whether the top left square is white."""
        return self.is_legacy and self.rows % 2 == 0

    @property
    def squares(self) -> NDArray[np.bool_]:
        """White squares are True; rows from the top, shape (rows, columns)."""
        row, column = np.indices((self.rows, self.columns))
        return np.asarray((row + column) % 2 == (0 if self.starts_white else 1))


@dataclass(frozen=True)
class Marker:
    """A square fiducial marker on the rig, or a board of many.

    Its frame has its origin in the middle of the print, x to the right, y up and z out of it.

    Attributes:
        dictionary: OpenCV's name, for example DICT_6X6_250.
        id: number in the dictionary; of a board that of its first marker, at the top left.
        side: edge of the black square [m]; of a board that of each of its markers.
        world_from_marker: its pose on the rig, shape (4, 4).
        board: on which the markers are printed, or None for a single one.
    """

    dictionary: str
    id: int
    side: float
    world_from_marker: FloatArray = field(default_factory=lambda: np.eye(4))
    board: Board | None = None

    @property
    def size(self) -> FloatArray:
        """Width and height of the print without its rim [m], shape (2,)."""
        return np.full(2, self.side) if self.board is None else self.board.size

    @property
    def square(self) -> float:
        """Edge of the marker, or of a board's squares [m]."""
        return self.side if self.board is None else self.board.square


def board_fault(board: Board, side: float) -> str:
    """Say what makes a board useless, or nothing.

    Args:
        board: its squares.
        side: edge of its markers [m].
    """
    if min(board.columns, board.rows) < 3 or board.corner_count < FEWEST_CORNERS:
        return (
            f'a board of {board.columns}x{board.rows} squares has {max(board.corner_count, 0)} '
            f'inner corners: at least {FEWEST_CORNERS} that do not lie on one line are needed, '
            'as 3x4 squares have'
        )
    if not 0.0 < side < board.square:
        return (
            f'markers of {1e3 * side:.4g} mm do not fit into squares of '
            f'{1e3 * board.square:.4g} mm: give the edge of the black square of a marker as '
            '`side` and the larger one of a chessboard square as `square`, in metres'
        )
    return ''
