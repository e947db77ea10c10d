# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0

from diffcal_ros.errors import PoseError
from diffcal_ros.pose.dictionary import dictionary_names, marker_cells
from diffcal_ros.pose.marker_target import marker_grid, MarkerTarget, single_marker
from diffcal_ros.scene.sections.marker_dictionaries import MARKER_COUNTS
import numpy as np
import pytest


def test_corners_run_clockwise_from_the_top_left_as_seen_from_the_front():
    corners = single_marker('DICT_4X4_50', 7, 0.02).corners[7]
    np.testing.assert_allclose(np.linalg.norm(np.diff(corners, axis=0), axis=1), 0.02)
    assert corners[0, 0] < 0.0 < corners[0, 1]
    # Seen from +z with y up, a clockwise walk has a normal along -z.
    assert np.cross(corners[1] - corners[0], corners[2] - corners[1])[2] < 0.0


def test_board_is_centred_and_its_markers_do_not_overlap():
    board = marker_grid('DICT_4X4_50', columns=3, rows=2, side=0.02, gap=0.005, first_id=4)
    assert board.ids == (4, 5, 6, 7, 8, 9)
    points = np.concatenate(list(board.corners.values()))
    np.testing.assert_allclose(points.mean(axis=0), 0.0, atol=1e-15)
    np.testing.assert_allclose(np.ptp(points[:, :2], axis=0), [0.07, 0.045])
    # The second marker stands to the right of the first, the fourth below it.
    assert board.corners[5][0, 0] - board.corners[4][1, 0] == pytest.approx(0.005)
    assert board.corners[4][3, 1] - board.corners[7][0, 1] == pytest.approx(0.005)


def test_cells_have_a_black_rim():
    cells = marker_cells('DICT_6X6_250', 0)
    assert cells.shape == (8, 8)
    assert not cells[[0, -1]].any()
    assert not cells[:, [0, -1]].any()
    assert cells[1:-1, 1:-1].any()


def test_dictionaries_of_the_scene_are_known_to_opencv():
    assert set(MARKER_COUNTS) <= set(dictionary_names())


def test_unknown_dictionary_lists_the_known_ones():
    with pytest.raises(PoseError, match=r"'DICT_6X6_251', which OpenCV .*DICT_6X6_250"):
        single_marker('DICT_6X6_251', 0, 0.02)


def test_id_beyond_the_dictionary_is_refused():
    with pytest.raises(PoseError, match=r'id is 50, but DICT_4X4_50 holds 0 to 49'):
        single_marker('DICT_4X4_50', 50, 0.02)


@pytest.mark.parametrize('side', [0.0, -0.02, float('nan')])
def test_side_must_be_positive(side):
    with pytest.raises(PoseError, match=r'side is .* give the edge of its black square'):
        single_marker('DICT_4X4_50', 0, side)


def test_corners_of_another_shape_are_refused():
    with pytest.raises(PoseError, match=r'marker 2 has corners of shape \(4, 2\)'):
        MarkerTarget('DICT_4X4_50', {2: np.zeros((4, 2))})


def test_empty_target_is_refused():
    with pytest.raises(PoseError, match='empty: give at least one marker'):
        MarkerTarget('DICT_4X4_50', {})


def test_board_without_markers_is_refused():
    with pytest.raises(PoseError, match='board is 0x2'):
        marker_grid('DICT_4X4_50', columns=0, rows=2, side=0.02, gap=0.005)
