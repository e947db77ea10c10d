# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A ChArUco board as a target: its inner chessboard corners on the rig."""

from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property

import cv2
from diffcal_ros.errors import PoseError
from diffcal_ros.marker import Board, board_fault, FEWEST_CORNERS
from diffcal_ros.pose.dictionary import check_marker_id, marker_dictionary
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class BoardTarget:
    """A chessboard with markers that number its corners.

    The frame is that of a single marker: origin in the middle of the board, x to the right, y up
    and z out of the print, towards who looks at it. OpenCV's own frame of the board has its
    origin in the top left corner of the top left square, y down and z into the print.

    Attributes:
        dictionary: OpenCV's name, for example DICT_4X4_50.
        board: its squares.
        side: edge of its markers [m].
        first_id: number of the top left marker; the others follow row by row.
    """

    dictionary: str
    board: Board
    side: float
    first_id: int = 0

    def __post_init__(self) -> None:
        marker_dictionary(self.dictionary)
        fault = board_fault(self.board, self.side)
        if fault:
            raise PoseError(fault)
        check_marker_id(self.dictionary, self.first_id)
        check_marker_id(self.dictionary, self.first_id + self.board.marker_count - 1)

    @cached_property
    def corners(self) -> dict[int, FloatArray]:
        """Inner corners [m] in the board's frame, shape (1, 3) each, row by row from the top."""
        board = self.board
        row, column = np.indices((board.rows - 1, board.columns - 1)).reshape(2, -1)
        down = board.size[1] / 2.0 - (row + 1) * board.square
        across = (column + 1) * board.square - board.size[0] / 2.0
        points = np.stack([across, down, np.zeros(len(row))], axis=1)
        return {number: point[None] for number, point in enumerate(points)}

    @cached_property
    def areas(self) -> dict[int, FloatArray]:
        """What belongs to each inner corner: a square around it, shape (4, 3), clockwise."""
        half = self.board.square / 2.0
        square = np.array(
            [[-half, half, 0.0], [half, half, 0.0], [half, -half, 0.0], [-half, -half, 0.0]]
        )
        return {number: corner + square for number, corner in self.corners.items()}

    @property
    def marker_ids(self) -> range:
        """Numbers of the markers in its white squares."""
        return range(self.first_id, self.first_id + self.board.marker_count)

    def is_enough(self, numbers: Collection[int]) -> bool:
        """Tell whether these corners give a pose: enough of them, and not on one line."""
        if len(numbers) < FEWEST_CORNERS:
            return False
        points = np.concatenate([self.corners[number] for number in numbers])
        spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
        # Of corners in two rows even one alone is most of a square off the line of the others.
        return bool(spread[1] > 0.5 * self.board.square)

    @property
    def label(self) -> str:
        """Name for messages, such as 'the 5x7 board of DICT_4X4_50'."""
        return f'the {self.board.columns}x{self.board.rows} board of {self.dictionary}'

    def opencv_board(self, *, is_legacy: bool | None = None) -> cv2.aruco.CharucoBoard:
        """Return the board as OpenCV knows it.

        Args:
            is_legacy: pattern of boards with an even number of rows; None: the board's own.
        """
        board = cv2.aruco.CharucoBoard(
            (self.board.columns, self.board.rows),
            self.board.square,
            self.side,
            marker_dictionary(self.dictionary),
            np.array(self.marker_ids, dtype=np.int32),
        )
        board.setLegacyPattern(self.board.is_legacy if is_legacy is None else is_legacy)
        return board
