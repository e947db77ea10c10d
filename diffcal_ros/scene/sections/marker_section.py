# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The section about the marker on the rig."""

from diffcal_ros.marker import Board, board_fault, Marker
from diffcal_ros.scene.reading.problems import suggestion
from diffcal_ros.scene.reading.section import Section
from diffcal_ros.scene.reading.shapes import Choice, Flag, Interval, Keys, Number, Whole
from diffcal_ros.scene.sections.marker_dictionaries import MARKER_COUNTS
from diffcal_ros.scene.sections.placement import placement_shape, read_placement
import numpy as np

_MARKER_SIDES = Interval(0.002, 2.0)
_MOST_SQUARES = 100

_BOARD_SHAPE = Keys(
    {
        'columns': Whole('squares', 3, _MOST_SQUARES),
        'rows': Whole('squares', 3, _MOST_SQUARES),
        'square': Number('edge of a chessboard square in m', _MARKER_SIDES),
        'legacy': Flag('as OpenCV before 4.6 made boards with an even number of rows'),
    },
    ('columns', 'rows', 'square'),
    'a ChArUco board in place of a single marker',
)
MARKER_SHAPE = Keys(
    {
        'dictionary': Choice(tuple(MARKER_COUNTS), "OpenCV's name"),
        'id': Whole('of a board: the marker at the top left, default 0', 0),
        'side': Number('edge of the black square in m', _MARKER_SIDES),
        'board': _BOARD_SHAPE,
        'placement': placement_shape('world_from_marker; default: it is the world frame'),
    },
    ('dictionary', 'side'),
    "the marker on the rig, from which the camera's pose is found",
)


def read_marker(scene: Section) -> Marker | None:
    """Read `marker`; None when there is none or it is wrong."""
    section = scene.child('marker')
    if section is None:
        return None
    dictionary = section.text('dictionary', needed='give a name such as DICT_6X6_250')
    if dictionary and dictionary not in MARKER_COUNTS:
        near = suggestion(dictionary, MARKER_COUNTS)
        section.wrong(
            'dictionary',
            'give one of OpenCV, DICT_<bits>X<bits>_<count> with 4 to 7 bits and 50, 100, 250 '
            f'or 1000 markers, DICT_ARUCO_ORIGINAL or DICT_APRILTAG_36h11{near}',
        )
    count = MARKER_COUNTS.get(dictionary)
    highest = None if count is None else count - 1
    is_board = section.has('board')
    # A board's markers are numbered from 0, unless it says otherwise.
    needs_id = not is_board or section.has('id')
    number = section.integer('id', high=highest) if needs_id else 0
    side = section.number(
        'side',
        needed=f'give the edge of the black square in metres, {_MARKER_SIDES}',
    )
    placement = section.child('placement')
    world_from_marker = np.eye(4) if placement is None else read_placement(placement)
    board = _read_board(section) if is_board else None
    section.refuse_unknown()
    if world_from_marker is None or not section.is_sound:
        return None
    if board is not None:
        _check_board(section, board, side, number, count)
    return Marker(dictionary, number, side, world_from_marker, board)


def _read_board(marker: Section) -> Board | None:
    section = marker.child('board')
    if section is None:
        return None
    columns = section.integer('columns')
    rows = section.integer('rows')
    square = section.number(
        'square',
        needed=f'give the edge of a chessboard square in metres, {_MARKER_SIDES}',
    )
    is_legacy = section.flag('legacy', default=False)
    section.refuse_unknown()
    return Board(columns, rows, square, is_legacy)


def _check_board(
    section: Section, board: Board, side: float, first: int, count: int | None
) -> None:
    """Note why a board cannot be found, or be printed."""
    fault = board_fault(board, side)
    if fault:
        section.problems.add(section.at('board'), f'cannot be used: {fault}')
    elif count is not None and first + board.marker_count > count:
        section.problems.add(
            section.at('board'),
            f'of {board.columns}x{board.rows} squares holds {board.marker_count} markers, '
            f'{first} to {first + board.marker_count - 1}, but the dictionary only 0 to '
            f'{count - 1}: give the dictionary that the board was made with',
        )
