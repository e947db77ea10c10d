# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""ChArUco boards: the same print and the same corners as OpenCV's own."""

import cv2
from diffcal_ros.errors import PoseError
from diffcal_ros.marker import Board, Marker
from diffcal_ros.pose.board_target import BoardTarget
from diffcal_ros.pose.marker_print import print_of
from diffcal_ros.pose.target import target_of
import numpy as np
import pytest

BOARDS = [Board(5, 7, 0.03), Board(4, 6, 0.03), Board(4, 6, 0.03, True), Board(5, 7, 0.03, True)]
DOTS = 42  # Per square, in OpenCV's picture of a board.


def marker_of(board):
    return Marker('DICT_4X4_50', 3, 0.02, board=board)


@pytest.mark.parametrize('board', BOARDS)
def test_corners_are_those_of_opencv_in_a_frame_with_y_up(board):
    target = target_of(marker_of(board))
    theirs = np.asarray(target.opencv_board().getChessboardCorners(), dtype=np.float64)
    width, height = board.size
    expected = theirs * [1.0, -1.0, -1.0] + [-width / 2.0, height / 2.0, 0.0]
    ours = np.concatenate([target.corners[number] for number in range(board.corner_count)])
    np.testing.assert_allclose(ours, expected, atol=1e-8)
    np.testing.assert_allclose(ours.mean(axis=0), 0.0, atol=1e-12)
    # The first corner is at the top left, as who looks at the print sees it.
    assert ours[0, 0] < 0.0 < ours[0, 1]


@pytest.mark.parametrize('board', BOARDS)
def test_the_print_is_that_of_opencv(board):
    shape = (board.columns * DOTS, board.rows * DOTS)
    target = target_of(marker_of(board))
    theirs = target.opencv_board().generateImage(shape, marginSize=0) == 0
    columns, rows = np.meshgrid(np.arange(shape[0]), np.arange(shape[1]))
    places = (np.stack([columns, rows], axis=-1) + 0.5) * board.square / DOTS
    points = (places - board.size / 2.0) * [1.0, -1.0]
    different = print_of(marker_of(board)).has_ink(points) != theirs
    # OpenCV moves the edges of markers to whole dots.
    assert different.mean() < 0.03
    thick = cv2.erode(different.astype(np.uint8), np.ones((3, 3), np.uint8))
    assert not thick.any()


def test_squares_around_the_corners_do_not_overlap():
    target = target_of(marker_of(Board(5, 7, 0.03)))
    assert target.areas.keys() == target.corners.keys()
    points = np.concatenate(list(target.areas.values()))
    np.testing.assert_allclose(np.ptp(points[:, :2], axis=0), [4 * 0.03, 6 * 0.03])
    assert sum(
        cv2.contourArea(area[:, :2].astype(np.float32)) for area in target.areas.values()
    ) == pytest.approx(24 * 0.03**2)


def test_six_corners_in_two_rows_are_enough_and_six_on_a_line_are_not():
    target = target_of(marker_of(Board(7, 5, 0.03)))
    assert not target.is_enough(range(6))
    assert not target.is_enough([0, 1, 2, 6, 7])
    assert target.is_enough([0, 1, 2, 3, 4, 6])
    # On a slant.
    larger = target_of(Marker('DICT_4X4_50', 0, 0.02, board=Board(7, 7, 0.03)))
    assert not larger.is_enough([0, 7, 14, 21, 28, 35])


@pytest.mark.parametrize(
    ('board', 'side', 'said'),
    [
        (Board(3, 3, 0.03), 0.02, r'3x3 squares has 4 inner corners: at least 6 .* 3x4 squares'),
        (Board(2, 20, 0.03), 0.02, r'2x20 squares has 19 inner corners: .*not lie on one line'),
        (Board(0, 5, 0.03), 0.02, r'0x5 squares has 0 inner corners'),
        (Board(5, 7, 0.02), 0.02, r'markers of 20 mm do not fit into squares of 20 mm'),
        (Board(5, 7, 0.03), 0.0, r'markers of 0 mm do not fit'),
        (Board(11, 10, 0.03), 0.02, r'marker id is 54, but DICT_4X4_50 holds 0 to 49'),
    ],
)
def test_impossible_boards_are_refused(board, side, said):
    with pytest.raises(PoseError, match=said):
        BoardTarget('DICT_4X4_50', board, side)
