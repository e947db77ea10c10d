# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Why frames give no pose, in words."""

from collections.abc import Sequence

from diffcal_ros.marker import FEWEST_CORNERS
from diffcal_ros.pose.board_target import BoardTarget
from diffcal_ros.pose.detection import Detection
from diffcal_ros.pose.target import Target


def why_nothing_seen(detections: Sequence[Detection], target: Target) -> str:
    """Say why frames give no pose, and what was seen instead."""
    count = len(detections)
    frames = f'{count} colour frame{"" if count == 1 else "s"}'
    most = max((len(detection.image_corners) for detection in detections), default=0)
    if isinstance(target, BoardTarget) and most:
        return _too_few_corners(target, frames, most)
    for detection in detections:
        if detection.hint:
            return f'{target.label} was not found in {frames}: {detection.hint}'
    if any(detection.image_corners for detection in detections):
        return (
            f'{target.label} was seen in {frames}, but too blurred to locate its corners: '
            'focus or light the marker better, or take the corners unrefined'
        )
    others = sorted({marker for detection in detections for marker in detection.other_ids})
    if others:
        noun = 'marker' if len(others) == 1 else 'markers'
        return (
            f'{target.label} was never seen in {frames}, but {noun} '
            f'{", ".join(map(str, others))} of that dictionary: set the marker id in the scene'
        )
    return (
        f'{target.label} was never seen in {frames}, nor any other of that dictionary: check '
        'that the colour camera sees it whole with a white rim, and check the dictionary'
    )


def _too_few_corners(target: BoardTarget, frames: str, most: int) -> str:
    return (
        f'{target.label} was seen in {frames}, but at most {most} of its '
        f'{target.board.corner_count} inner corners at once: {FEWEST_CORNERS} that do not lie on '
        'one line are needed, uncover or light more of it, or bring the camera nearer'
    )
