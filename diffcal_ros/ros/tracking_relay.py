# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""From the thread that follows a body to the topics: the newest state wins."""

from collections.abc import Iterable
from typing import Any

from diffcal_ros.live.picture import Picture
from diffcal_ros.live.session import Session
from diffcal_ros.live.tasks.track_task import TrackStep
from diffcal_ros.live.tracking import in_words
from diffcal_ros.ros.calibration_outputs import CalibrationOutputs
from rclpy.clock import Clock
from rclpy.impl.rcutils_logger import RcutilsLogger


def relay_tracking(
    events: Iterable[Any],
    session: Session,
    outputs: CalibrationOutputs,
    steady: Clock,
    logger: RcutilsLogger,
) -> None:
    """Take in what was found, and publish every change but of the states only the newest.

    Args:
        events: of the thread that follows.
        session: that it follows for.
        outputs: publishers.
        steady: the clock that arrivals were noted by.
        logger: of the node.
    """
    newest: TrackStep | None = None
    picture: Picture | None = None
    for event in events:
        session.handle(event, steady.now().nanoseconds)
        tracking = session.tracking
        if isinstance(event, Picture):
            picture = event
        if not isinstance(event, TrackStep) or tracking is None:
            continue
        newest = event
        change = event.tracked.change
        if change is not None:
            logger.warning(f'the body changed {in_words(change)}')
            outputs.publish_change(change, tracking.change_count, event.frame_id)
    if newest is not None and session.tracking is not None:
        outputs.publish_tracked(session.scene, session.tracking, newest)
        session.tracking.told(newest, steady.now().nanoseconds)
    if picture is not None:
        outputs.publish_picture(picture)
