# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is looked for: a marker, several of them, or a ChArUco board."""

from diffcal_ros.marker import Marker
from diffcal_ros.pose.board_target import BoardTarget
from diffcal_ros.pose.marker_target import MarkerTarget, single_marker

Target = MarkerTarget | BoardTarget


def target_of(marker: Marker) -> Target:
    """Return what a scene's marker is to be found by.

    Raises:
        PoseError: when there is no such marker or board.
    """
    if marker.board is None:
        return single_marker(marker.dictionary, marker.id, marker.side)
    return BoardTarget(marker.dictionary, marker.board, marker.side, marker.id)
