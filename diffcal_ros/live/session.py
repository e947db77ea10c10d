# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The states of a live calibration: collect frames, fit, report; one step at a time."""

from dataclasses import replace
from enum import Enum
import threading
from typing import Any

from diffcal_ros.calibration.results.outcome import Outcome
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.errors import InputError
from diffcal_ros.live.frames.frame_window import FrameWindow
from diffcal_ros.live.frames.release import with_release
from diffcal_ros.live.frames.swings import Swings
from diffcal_ros.live.inputs import LiveInputs, Snapshot
from diffcal_ros.live.node_words import camera_change_words, error_words
from diffcal_ros.live.picture import Picture
from diffcal_ros.live.session_check import check_settings, motion_in_view
from diffcal_ros.live.session_settings import SessionSettings, with_quantization
from diffcal_ros.live.tasks.background import Background, TaskFailed
from diffcal_ros.live.tasks.fit_task import fit, FitEnd, FitRequest, FitStep
from diffcal_ros.live.tasks.track_task import TrackStep
from diffcal_ros.live.tasks.warm_up import Ready, warm_up
from diffcal_ros.live.tracking import Tracking
from diffcal_ros.scene.model import Scene

_SECOND = 1_000_000_000  # [ns]
# After what failed the next try comes so late, and after each further one in a row twice as late.
_RETRY, _LONGEST_RETRY = 2 * _SECOND, 30 * _SECOND


class Phase(Enum):
    """Which state the calibration is in."""

    PREPARING = 'preparing'
    COLLECTING = 'collecting'
    FITTING = 'fitting'
    DONE = 'done'
    TRACKING = 'tracking'
    PAUSED = 'paused'


class Session:
    """Collects, fits and remembers; all but the fits themselves is done in the caller's thread."""

    def __init__(
        self,
        scene: Scene,
        settings: SessionSettings,
        background: Background,
        follower: Background,
    ) -> None:
        """Start, and compile in the background.

        Args:
            scene: the set-up.
            settings: how it goes.
            background: for fits.
            follower: for tracking, which takes a thread of its own.

        Raises:
            InputError: when scene and settings contradict each other.
        """
        self.scene = scene
        self.settings = settings
        self.check(settings)
        self.inputs = LiveInputs(scene, settings.pose_source, settings.observation)
        self.swings = self._new_swings()
        self.window = FrameWindow(self._window_size)
        self.captured: list[Snapshot] = []
        self.problem: str | None = None
        self.bad_inputs: dict[str, str] = {}
        self.step_seconds = 0.0
        self.fit_count = 0
        self.last_step: FitStep | None = None
        self.last_end: FitEnd | None = None
        self.tracking: Tracking | None = None
        self._background, self._follower = background, follower
        self._values: dict[str, float] = {}
        self._is_enabled = True
        self._is_due = True
        self._is_ready = False
        self._fit: threading.Event | None = None
        self._retry_ns = 0
        self._failure_count = 0
        background.submit(lambda post, stop: warm_up(scene, settings.fit, post, stop))

    @property
    def phase(self) -> Phase:
        """Which state the calibration is in."""
        if not self._is_enabled:
            return Phase.PAUSED
        if not self._is_ready:
            return Phase.PREPARING
        if self._fit is not None:
            return Phase.FITTING
        if self.tracking is not None:
            return Phase.TRACKING
        return Phase.COLLECTING if self._is_due else Phase.DONE

    @property
    def failure(self) -> Outcome | None:
        """How the last fit ended, where it left nothing to go on from."""
        if self.last_end is None or self.tracking is not None or self.swings is not None:
            return None
        outcome = self.last_end.result.outcome
        return None if outcome.is_fitted else outcome

    @property
    def retry_seconds(self) -> float:
        """How long after a failure the next fit begins [s]."""
        return self._patience() / _SECOND

    def add_frame(self, frame: DepthFrame, now_ns: int) -> str | None:
        """Take a depth frame; return why the window started anew, or None."""
        if not self._is_enabled:
            return None
        newest = self.window.newest
        if newest is not None and newest.depth.shape != frame.depth.shape:
            self._stop_tracking()
        if self.tracking is not None:
            self.tracking.put(frame, now_ns)
        if self.swings is not None:
            self.swings.window.add(frame)
        return self.window.add(frame, now_ns)

    def set_camera(self, camera: PinholeCamera) -> str | None:
        """Take a camera_info; return what another camera than before ended, or None."""
        before = self.inputs.camera
        self.inputs.set_camera(camera)
        if before is None or self.inputs.camera == before:
            return None
        self.window.clear()
        if self.swings is not None:
            self.swings.window.clear()
        is_at_work = self._interrupt() or self.tracking is not None
        self._stop_tracking()
        self._is_due = self._is_due or is_at_work
        words = camera_change_words(before, camera)
        return f'the depth camera changed ({words}): frames are collected anew'

    def poll(self, now_ns: int) -> bool:
        """Start a fit when everything for it is there; return whether one was started.

        Args:
            now_ns: steady time [ns].
        """
        if self.phase is not Phase.COLLECTING or now_ns < self._retry_ns:
            return False
        try:
            if self.swings is not None:
                return self._start_swing(self.swings)
            snapshots = tuple(self.captured) or self._ripe_window(now_ns)
        except InputError as error:
            self.problem = str(error)
            self._retry_ns = now_ns + _RETRY
            self.window.clear()
            return False
        if snapshots:
            self._start(self.scene, snapshots)
        return bool(snapshots)

    def handle(self, event: Any, now_ns: int) -> None:
        """Take in what the background thread found."""
        if isinstance(event, Ready):
            self._is_ready = True
        elif isinstance(event, FitStep):
            before = self.last_step.record if self.last_step and event.record.number else None
            self.step_seconds = event.record.seconds - (before.seconds if before else 0.0)
            self.last_step = event
        elif isinstance(event, FitEnd):
            self.last_end = event
            self.fit_count += 1
            self.problem = None
            self._fit = None
            self._is_due = self._goes_on
            if self.swings is not None:
                assert event.calibration is not None
                newest = event.request.snapshots[-1].newest
                self.swings.take_in(event.result, event.calibration, newest)
                self._values = dict(self.swings.values)
                return
            self._values = event.result.values()
            if self.settings.refit == 'tracking' and not self.captured:
                self._track(event)
            self._count_failures(self.failure is not None, now_ns)
        elif isinstance(event, TrackStep):
            if self.tracking is not None:
                self.tracking.handle(event)
                self._values = event.tracked.values()
        elif isinstance(event, Picture):
            if self.tracking is not None:
                self.tracking.picture = event
        elif isinstance(event, TaskFailed):
            self._is_ready = True
            self._fail(error_words(event.error), now_ns)

    def present(self) -> FitEnd | None:
        """Return what is known now: the last fit, or where tracking has got to from there."""
        end, tracking = self.last_end, self.tracking
        if end is None or tracking is None or tracking.last is None:
            return end
        frames = tracking.alike(self.window.frames)
        request = replace(end.request, snapshots=(self.inputs.snapshot(frames),))
        return replace(end, request=request, result=tracking.result(end.result), calibration=None)

    def enable(self, is_enabled: bool) -> str:
        """Go on, or pause: a fit that runs is given up; return what was done."""
        if is_enabled == self._is_enabled:
            return 'is enabled already' if is_enabled else 'is paused already'
        self._is_enabled = is_enabled
        self.window.clear()
        if is_enabled:
            return 'collecting frames again'
        given_up = self._interrupt()
        self._stop_tracking()
        if self.swings is not None:
            self.swings.window.clear()
        return 'paused; the fit that ran was given up' if given_up else 'paused'

    def reset(self) -> str:
        """Forget frames, captures and results, and start anew; return what was done."""
        self._interrupt()
        self._stop_tracking()
        count = len(self.captured)
        self.window.clear()
        self.swings = self._new_swings()
        self.captured.clear()
        self.last_step = self.last_end = self.problem = None
        self._values = {}
        self._is_due = True
        self._retry_ns = self._failure_count = 0
        return f'started anew; {count} captured observations were forgotten'

    def capture(self) -> str:
        """Freeze the window as one more observation; the next fit uses all captured ones.

        Returns:
            What was captured.

        Raises:
            InputError: when frames or another input are missing, or the body moves.
        """
        if self.swings is not None:
            raise InputError(
                'a body in motion is fitted swing by swing: there is no posture to capture'
            )
        snapshot = self.inputs.snapshot(self.window.frames)
        self.captured.append(snapshot)
        self.window.clear()
        self._interrupt()
        self._stop_tracking()
        self._is_due = True
        return (
            f'captured {snapshot.name!r} from {len(snapshot.frames)} frames; the next fit uses '
            f'{len(self.captured)} captured observations'
        )

    def check(self, settings: SessionSettings) -> None:
        """Refuse settings that contradict the scene.

        Raises:
            InputError: naming what is wrong.
        """
        check_settings(self.scene, settings)

    def change(self, settings: SessionSettings) -> None:
        """Go on with other settings, checked before; a fit that they concern starts anew."""
        old = self.settings
        is_other_view = (settings.pose_source, settings.observation) != (
            old.pose_source,
            old.observation,
        )
        if is_other_view:
            self.inputs = self._inputs_for(settings)
            self.window.clear()
        self.settings = settings
        is_other_fit = (settings.fit, settings.depth_quantization) != (
            old.fit,
            old.depth_quantization,
        )
        if is_other_view or is_other_fit:
            self.swings = self._new_swings()
        self.window.resize(self._window_size)
        is_other_follow_up = settings.refit != old.refit or settings.tracking != old.tracking
        if is_other_fit or is_other_follow_up or (is_other_view and not self.captured):
            self._stop_tracking()
        if is_other_fit or (is_other_view and not self.captured):
            self._interrupt()
            self._is_due = True
            self._retry_ns = self._failure_count = 0
        elif self._goes_on:
            self._is_due = True

    def _ripe_window(self, now_ns: int) -> tuple[Snapshot, ...]:
        patience = int(self.settings.window_seconds * _SECOND)
        if self.inputs.missing(self.window.newest):
            return ()
        if not self.window.is_ripe(now_ns, patience):
            return ()
        return (self.inputs.snapshot(self.window.frames),)

    @property
    def _goes_on(self) -> bool:
        """Tell whether new frames start another fit; captured observations do not change."""
        refit = self.settings.refit
        return (
            refit == 'continuous' or (refit == 'tracking' and self.swings is not None)
        ) and not self.captured

    @property
    def _window_size(self) -> int:
        return self.settings.window_frames if self.swings is None else 1

    def _new_swings(self) -> Swings | None:
        motion = motion_in_view(self.scene, self.settings)
        return None if motion is None else Swings(motion, self.settings.tracking.tracker.change)

    def _start_swing(self, swings: Swings) -> bool:
        """Fit the newest swing, where there is one."""
        if self.inputs.missing(self.window.newest):
            return False
        swing = swings.window.take()
        if swing is None:
            return False
        scene = with_release(self.scene, self.inputs.setup_index, swing)
        self._start(scene, (self.inputs.snapshot(swing.frames),))
        return True

    def _inputs_for(self, settings: SessionSettings) -> LiveInputs:
        fresh = LiveInputs(self.scene, settings.pose_source, settings.observation)
        fresh.camera = self.inputs.camera
        fresh.take_over(self.inputs)
        return fresh

    def _start(self, scene: Scene, snapshots: tuple[Snapshot, ...]) -> None:
        scene = with_quantization(scene, self.settings.depth_quantization)
        request = FitRequest(scene, snapshots, self._fit_settings(), dict(self._values))
        self.window.used()
        if not self._failure_count:
            self.problem = None
        self._fit = self._background.submit(lambda post, stop: fit(request, post, stop))

    def _fit_settings(self) -> CalibrationSettings:
        """Return how to fit: what goes on from a good fit needs no other start."""
        settings, end = self.settings.fit, self.last_end
        goes_on = self._values and end is not None and end.result.outcome.is_usable
        return replace(settings, search=False) if goes_on else settings

    def _track(self, end: FitEnd) -> None:
        """Follow the body from here on; what is not fitted is fitted again."""
        if end.result.outcome.is_fitted:
            self.tracking = Tracking(end, self.settings.tracking, self._follower)
        else:
            self._is_due = True

    def _stop_tracking(self) -> None:
        """End the tracking, where there is one, for another fit."""
        if self.tracking is not None:
            self.tracking.stop()
            self.tracking = None
            self._is_due = True

    def _interrupt(self) -> bool:
        """Give up the fit that runs; return whether there was one."""
        if self._fit is None:
            return False
        self._fit.set()
        self._fit = None
        return True

    def _fail(self, problem: str, now_ns: int) -> None:
        """Remember what is wrong and try again with new frames."""
        self.problem = problem
        self._fit = None
        self._stop_tracking()
        self._is_due = not self.captured
        self._count_failures(True, now_ns)

    def _count_failures(self, has_failed: bool, now_ns: int) -> None:
        """Put the next try off, the longer the more tries failed in a row."""
        self._failure_count = self._failure_count + 1 if has_failed else 0
        if has_failed:
            self._retry_ns = now_ns + self._patience()
            self.window.clear()

    def _patience(self) -> int:
        doubled = _RETRY << min(10, max(0, self._failure_count - 1))
        return int(min(doubled, _LONGEST_RETRY))
