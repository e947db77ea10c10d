# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Follow a body from frame to frame in the background, until told to stop."""

from collections.abc import Callable
from dataclasses import dataclass, replace
import threading
import time

from diffcal_ros.calibration.observations.observation import measured_depth
from diffcal_ros.calibration.tracking.tracked import Tracked, TrackerSettings
from diffcal_ros.calibration.tracking.tracker import Tracker
from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.live.frames.body_frames import body_frames, BodyFrames
from diffcal_ros.live.frames.latest_frame import LatestFrame
from diffcal_ros.live.picture import draw_picture, Picture
from diffcal_ros.live.tasks.background import Post
from diffcal_ros.live.tasks.fit_task import FitEnd

_PATIENCE = 0.1  # How soon an end without a frame is noticed [s].


@dataclass(frozen=True)
class TrackStep:
    """What is known after a frame.

    Attributes:
        tracked: parameters and what the frame showed.
        frame_id: optical frame of the depth images.
        number: of the frame, from 1.
        arrived_ns: when the frame came, steady time [ns].
        seconds: that the update took.
        search_count: searches for a body that changed, so far.
        frames: where world and body are.
    """

    tracked: Tracked
    frame_id: str
    number: int
    arrived_ns: int
    seconds: float
    search_count: int
    frames: BodyFrames


@dataclass(frozen=True)
class TrackRequest:
    """What to follow.

    Attributes:
        end: of the fit to start from.
        settings: how to follow.
        frames: where they come from.
        is_picture_due: asked after every frame.
    """

    end: FitEnd
    settings: TrackerSettings
    frames: LatestFrame
    is_picture_due: Callable[[], bool]


def track(request: TrackRequest, post: Post, stop: threading.Event) -> None:
    """Post a `TrackStep` after every frame, and after some of them a `Picture`.

    Raises:
        InputError: when the fitted values cannot be simulated.
    """
    fit = request.end.request
    # The fit's own model may be in use for a report.
    calibration = fit.calibration()
    (observation,) = calibration.model.observations
    tracker = Tracker(calibration, request.end.result.parameters, request.settings)
    triangles = calibration.model.body(observation).discretisation.surface_triangles
    number = 0

    def draw(frame: DepthFrame) -> Picture:
        return draw_picture(
            tracker.view.rendered,
            tracker.view.read_depth(),
            frame.depth,
            triangles,
            observation.camera,
            frame,
        )

    while not stop.is_set():
        arrived = request.frames.take(_PATIENCE)
        if arrived is None:
            continue
        begun = time.perf_counter()
        if arrived.is_restart:
            tracker.forget()
        depth = measured_depth(arrived.frame.depth, observation.sensor or fit.scene.sensor)
        frame = replace(arrived.frame, depth=depth)
        tracked = tracker.follow(frame)
        number += 1
        seconds = time.perf_counter() - begun
        step = TrackStep(
            tracked,
            frame.frame_id,
            number,
            arrived.arrived_ns,
            seconds,
            tracker.search_count,
            body_frames(fit.scene, calibration.model, tracker.coordinates),
        )
        post(step)
        # Parameters do not wait for pictures.
        if request.is_picture_due():
            post(draw(frame))
