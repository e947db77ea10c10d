# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is looked for: markers, each with its four corners on the rig."""

from dataclasses import dataclass

from diffcal_ros.errors import PoseError
from diffcal_ros.pose.dictionary import check_marker_id, marker_dictionary
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class MarkerTarget:
    """One marker or a board of several, rigid.

    The frame of a single marker has its origin in the middle, x to the right, y up and z out of
    the print, towards who looks at it.

    Attributes:
        dictionary: OpenCV's name, for example DICT_6X6_250.
        corners: by marker id, the corners [m], shape (4, 3), in the target's frame: top left,
            top right, bottom right, bottom left of the upright print.
    """

    dictionary: str
    corners: dict[int, FloatArray]

    def __post_init__(self) -> None:
        marker_dictionary(self.dictionary)
        if not self.corners:
            raise PoseError('the marker target is empty: give at least one marker')
        for marker_id, corners in self.corners.items():
            check_marker_id(self.dictionary, marker_id)
            if np.shape(corners) != (4, 3) or not np.isfinite(corners).all():
                raise PoseError(
                    f'marker {marker_id} has corners of shape {np.shape(corners)}: '
                    'four finite points in metres are needed'
                )

    @property
    def areas(self) -> dict[int, FloatArray]:
        """What belongs to each marker: its black square, shape (4, 3), clockwise [m]."""
        return self.corners

    @property
    def ids(self) -> tuple[int, ...]:
        """Marker numbers in ascending order."""
        return tuple(sorted(self.corners))

    @property
    def label(self) -> str:
        """Name for messages, such as 'marker 0 of DICT_6X6_250'."""
        noun = 'marker' if len(self.corners) == 1 else 'markers'
        return f'{noun} {", ".join(map(str, self.ids))} of {self.dictionary}'


def single_marker(dictionary: str, marker_id: int, side: float) -> MarkerTarget:
    """Make a target of one marker.

    Args:
        dictionary: OpenCV's name.
        marker_id: number in it.
        side: edge of the black square [m].
    """
    return MarkerTarget(dictionary, {marker_id: _square(side)})


def marker_grid(
    dictionary: str,
    *,
    columns: int,
    rows: int,
    side: float,
    gap: float,
    first_id: int = 0,
) -> MarkerTarget:
    """Make a flat board, ids row by row from the top left; its origin is the board's middle.

    Args:
        dictionary: OpenCV's name.
        columns: markers across.
        rows: markers down.
        side: edge of a black square [m].
        gap: white between two squares [m].
        first_id: number of the top left marker.
    """
    if columns < 1 or rows < 1 or gap < 0.0:
        raise PoseError(
            f'marker board is {columns}x{rows} with gaps of {gap:g} m: at least one marker '
            'each way and no negative gap are needed'
        )
    pitch = side + gap
    corners = {}
    for row in range(rows):
        for column in range(columns):
            middle = [(column - (columns - 1) / 2) * pitch, ((rows - 1) / 2 - row) * pitch, 0.0]
            corners[first_id + row * columns + column] = _square(side) + middle
    return MarkerTarget(dictionary, corners)


def _square(side: float) -> FloatArray:
    if not (np.isfinite(side) and side > 0.0):
        raise PoseError(f'marker side is {side:g} m: give the edge of its black square in metres')
    half = side / 2.0
    return np.array(
        [[-half, half, 0.0], [half, half, 0.0], [half, -half, 0.0], [-half, -half, 0.0]]
    )
