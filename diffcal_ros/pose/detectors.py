# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The detector that belongs to a target."""

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.pose.board_detection import BoardDetector
from diffcal_ros.pose.board_target import BoardTarget
from diffcal_ros.pose.detection import CornerRefinement, Detector, MarkerDetector
from diffcal_ros.pose.target import Target


def make_detector(
    target: Target,
    camera: PinholeCamera,
    refinement: CornerRefinement = CornerRefinement.EDGES,
) -> Detector:
    """Prepare the search for a marker or a board.

    Args:
        target: what is looked for.
        camera: intrinsics of the colour images.
        refinement: how a marker's corners are located; those of a board are always refined
            where its squares meet.
    """
    if isinstance(target, BoardTarget):
        return BoardDetector(target, camera)
    return MarkerDetector(target, camera, refinement)
