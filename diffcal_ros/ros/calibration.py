# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The calibration node: depth, camera and pose in, fitted parameters out."""

from pathlib import Path
from typing import Any

from diffcal_ros.calibration.results.outcome import Outcome
from diffcal_ros.diagnosis.verdict.acceptance import accept, revert
from diffcal_ros.errors import InputError
from diffcal_ros.live.fit_words import result_words
from diffcal_ros.live.health import Health, Level
from diffcal_ros.live.node_words import for_nodes
from diffcal_ros.live.save import (
    check_folder,
    make_folder,
    ReportWritten,
    save_numbers,
    save_report,
)
from diffcal_ros.live.session import Session
from diffcal_ros.live.session_check import check_settings
from diffcal_ros.live.session_health import session_health
from diffcal_ros.live.tasks.background import Background
from diffcal_ros.live.tasks.diagnosis_task import DiagnosisEnd, DiagnosisStep, run_diagnosis
from diffcal_ros.live.tasks.fit_task import FitEnd, FitStep
from diffcal_ros.live.tracking import in_words
from diffcal_ros.ros.calibration_inputs import CalibrationInputs
from diffcal_ros.ros.calibration_outputs import CalibrationOutputs, FrameNames
from diffcal_ros.ros.calibration_parameters import session_settings, SETTINGS
from diffcal_ros.ros.diagnostics import DiagnosticsReporter, PERIOD
from diffcal_ros.ros.frame_sender import check_frame_names
from diffcal_ros.ros.lifecycle_words import Stand
from diffcal_ros.ros.parameters import Parameters, Values
from diffcal_ros.ros.tracking_relay import relay_tracking
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.model import Scene
from diffcal_ros.user_path import user_path
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from std_srvs.srv import SetBool, Trigger

_POLL_PERIOD = 0.05  # [s]


class CalibrationNode(LifecycleNode):
    """Configure loads the scene and compiles, activate consumes, deactivate pauses."""

    def __init__(self) -> None:
        super().__init__('calibration')
        self._session: Session | None = None
        self._inputs: CalibrationInputs | None = None
        self._outputs: CalibrationOutputs | None = None
        self._problem: str | None = None
        self._stand = Stand.UNCONFIGURED
        self._report = 'none'
        self._diagnosis = 'none'
        self._told: set[str] = set()
        self._last_outcome: Outcome | None = None
        self._settings = Parameters(
            self,
            SETTINGS,
            check=self._check,
            check_change=self._check_change,
            act=self._changed,
        )
        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._found = self.create_guard_condition(self._drain)
        self._background = Background(self._found.trigger)
        self._follower = Background(self._found.trigger)
        self._reporter = DiagnosticsReporter(self, self._examine, self._settings[PERIOD.name])
        self._poll_timer = self.create_timer(_POLL_PERIOD, self._poll, clock=self._steady)
        self.create_service(SetBool, '~/enable', self._on_enable)
        self.create_service(Trigger, '~/reset', self._on_reset)
        self.create_service(Trigger, '~/capture', self._on_capture)
        self.create_service(Trigger, '~/save', self._on_save)
        self.create_service(Trigger, '~/diagnose', self._on_diagnose)
        self.create_service(Trigger, '~/accept_effect', self._on_accept)
        self.create_service(Trigger, '~/revert_effect', self._on_revert)
        self._autostart_timer = self.create_timer(0.0, self._autostart, clock=self._steady)

    def close(self) -> bool:
        """End the background work; return False when it cannot be ended."""
        is_followed = self._follower.close()
        return self._background.close() and is_followed

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Load the scene and compile in the background."""
        if not self._load():
            self._reporter.report()
            return TransitionCallbackReturn.FAILURE
        self._outputs = CalibrationOutputs(self, self._frame_names)
        self._stand = Stand.INACTIVE
        return super().on_configure(state)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Start to consume."""
        assert self._session is not None
        self._session.enable(True)
        self._inputs = CalibrationInputs(self, self._steady, self._session)
        self._stand = Stand.ACTIVE
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Pause; a fit that runs is given up."""
        assert self._session is not None
        self._session.enable(False)
        self._end_inputs()
        self._stand = Stand.INACTIVE
        return super().on_deactivate(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Forget the scene and everything found."""
        self._end_inputs()
        if self._session is not None:
            self._session.reset()
        self._session = self._problem = None
        if self._outputs is not None:
            self._outputs.destroy()
            self._outputs = None
        self._stand = Stand.UNCONFIGURED
        return TransitionCallbackReturn.SUCCESS

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """End everything."""
        done = self.on_cleanup(state)
        self._stand = Stand.FINALIZED
        return done

    def _autostart(self) -> None:
        self._autostart_timer.cancel()
        is_due = self._settings['autostart'] and self._stand is Stand.UNCONFIGURED
        if is_due and self.trigger_configure() == TransitionCallbackReturn.SUCCESS:
            self.trigger_activate()

    def _load(self) -> bool:
        """Load the scene; return whether that could be done."""
        try:
            scene = _scene_of(self._settings.values)
            settings = session_settings(self._settings.values)
            session = Session(scene, settings, self._background, self._follower)
        except InputError as error:
            self._problem = str(error)
            return False
        self._problem = None
        self._session = session
        for note in scene.notes:
            self.get_logger().info(note)
        return True

    def _check(self, values: Values) -> None:
        session_settings(values)
        check_frame_names(values['world_frame'], values['body_frame'])

    def _check_change(self, old: Values, new: Values) -> None:
        """Refuse what could not be gone on with."""
        if self._stand is Stand.FINALIZED:
            raise InputError(self._stand.words(self.get_fully_qualified_name()))
        settings = session_settings(new)
        if new['out'] != old['out']:
            check_folder(user_path(new['out']).resolve())
        if new['scene'] != old['scene']:
            check_settings(_scene_of(new), settings)
        elif self._session is not None:
            self._session.check(settings)

    def _changed(self, names: frozenset[str]) -> None:
        if 'scene' in names:
            self._change_scene()
        elif self._session is not None:
            self._session.change(session_settings(self._settings.values))

    def _change_scene(self) -> None:
        """Load another scene; until it is a good one, the node is what it was."""
        if self._session is None:
            self._autostart_timer.reset()
            return
        old = self._session
        if self._load():
            old.reset()
            assert self._session is not None
            if self._inputs is None:
                self._session.enable(False)
            else:
                self._inputs.feed(self._session)

    def _end_inputs(self) -> None:
        if self._inputs is not None:
            self._inputs.destroy()
            self._inputs = None

    def _frame_names(self) -> FrameNames:
        values, session = self._settings.values, self._session
        world = values['world_frame']
        if session is not None:
            # A pose from TF: it says already where the world is.
            is_known = session.inputs.source == 'tf'
            world = '' if is_known else session.inputs.world_frame or world
        return FrameNames(values['publish_tf'], world, values['body_frame'])

    def _poll(self) -> None:
        if self._session is None:
            return
        self._session.poll(self._steady.now().nanoseconds)
        if self._session.tracking is not None and self._outputs is not None:
            self._session.tracking.has_onlookers = self._outputs.has_onlookers

    def _drain(self) -> None:
        """Take in what the background thread found, and publish it."""
        for event in self._background.events():
            if isinstance(event, ReportWritten):
                self._report = event.problem or f'written to {event.path}'
                self.get_logger().info(f'report: {self._report}')
            elif isinstance(event, DiagnosisStep):
                self._diagnosis = event.words
            elif isinstance(event, DiagnosisEnd):
                self._end_diagnosis(event)
            elif self._session is not None:
                self._session.handle(event, self._steady.now().nanoseconds)
                self._publish(event)
        events = self._follower.events()
        if self._session is not None and self._outputs is not None:
            logger = self.get_logger()
            relay_tracking(events, self._session, self._outputs, self._steady, logger)

    def _publish(self, event: Any) -> None:
        if self._outputs is None or self._session is None:
            return
        if isinstance(event, FitStep):
            self._outputs.publish_step(self._session.scene, event)
        elif isinstance(event, FitEnd):
            self._outputs.publish_end(self._session.scene, event)
            self._log_notes(event)
            self._log_outcome(event)
            self._publish_swing(event)
            self._reporter.report()

    def _log_notes(self, end: FitEnd) -> None:
        """Log what a person should know of a fit's inputs, once."""
        for note in end.result.details.get('notes', ()):
            if note not in self._told:
                self._told.add(note)
                self.get_logger().info(f'note: {note}')

    def _log_outcome(self, end: FitEnd) -> None:
        """Log a fit that succeeded; of window after window the first, and one after a failure."""
        outcome, before = end.result.outcome, self._last_outcome
        self._last_outcome = outcome
        is_one_of_many = self._settings['refit'] == 'continuous' and outcome is before
        # Its health is logged where there is something to mend.
        if outcome.is_fitted and not is_one_of_many:
            self.get_logger().info(f'the fit {result_words(end.result)}')

    def _publish_swing(self, end: FitEnd) -> None:
        """Publish a change of the body that the last swing showed."""
        assert self._session is not None
        assert self._outputs is not None
        swings = self._session.swings
        change = None if swings is None else swings.change
        newest = end.request.snapshots[-1].newest
        if swings is not None and change is not None and change.stamp_ns == newest.stamp_ns:
            self.get_logger().warning(f'the body changed {in_words(change)}')
            self._outputs.publish_change(change, swings.change_count, newest.frame_id)

    def _examine(self) -> dict[str, Health]:
        if self._session is None:
            message = self._problem or self._stand.words(self.get_fully_qualified_name())
            level = Level.ERROR if self._problem else Level.WARN
            return {'fit': Health(level, message)}
        fit = session_health(self._session)
        if self._stand is not Stand.ACTIVE:
            words = self._stand.words(self.get_fully_qualified_name())
            fit = Health(Level.WARN, words, fit.values)
        if self._problem is not None:
            fit = Health(Level.ERROR, self._problem, fit.values)
        fit.values['report'] = self._report
        fit.values['diagnosis'] = self._diagnosis
        parts = {'fit': fit}
        if self._inputs is not None:
            parts['input'] = self._inputs.health()
        return parts

    def _required(self) -> Session:
        if self._session is None:
            words = self._stand.words(self.get_fully_qualified_name())
            raise InputError(self._problem or words)
        return self._session

    def _active(self) -> Session:
        session = self._required()
        if self._stand is not Stand.ACTIVE:
            raise InputError(self._stand.words(self.get_fully_qualified_name()))
        return session

    def _on_enable(self, request: Any, response: Any) -> Any:
        return _answer(response, lambda: self._active().enable(request.data))

    def _on_reset(self, request: Any, response: Any) -> Any:
        return _answer(response, lambda: self._required().reset())

    def _on_capture(self, request: Any, response: Any) -> Any:
        return _answer(response, lambda: self._active().capture())

    def _on_save(self, request: Any, response: Any) -> Any:
        return _answer(response, self._save)

    def _save(self) -> str:
        end = self._required().present()
        if end is None:
            raise InputError('no fit has come to its end yet: there is nothing to save')
        folder = self._folder()
        written = save_numbers(end, folder)
        self._report = 'being written'
        self._background.submit(lambda post, stop: save_report(end, folder, post, stop))
        files = ', '.join(str(path) for path in written)
        return f'wrote {files}; the report follows in {folder}'

    def _on_diagnose(self, request: Any, response: Any) -> Any:
        return _answer(response, self._diagnose)

    def _on_accept(self, request: Any, response: Any) -> Any:
        return _answer(response, self._accept)

    def _on_revert(self, request: Any, response: Any) -> Any:
        return _answer(response, self._revert)

    def _diagnosis_folder(self) -> Path:
        return self._folder() / 'diagnosis'

    def _folder(self) -> Path:
        """Return where to write to, in full: whoever calls a service is elsewhere."""
        return user_path(self._settings['out']).resolve()

    def _diagnose(self) -> str:
        session = self._required()
        end = session.present()
        if end is None:
            raise InputError('no fit has come to its end yet: there is nothing to diagnose')
        seen, folder = end.request, self._diagnosis_folder()
        make_folder(folder)
        self._diagnosis = 'begun'
        self._background.submit(
            lambda post, stop: run_diagnosis(
                seen.scene, seen.snapshots, seen.settings.fit, folder, post, stop
            )
        )
        return f'diagnosing in the background; the verdict comes on ~/verdict and in {folder}'

    def _end_diagnosis(self, end: DiagnosisEnd) -> None:
        if end.diagnosis is None:
            self._diagnosis = f'broke off: {end.problem}'
            self.get_logger().error(f'diagnosis: {end.problem}')
            return
        self._diagnosis = f'{end.diagnosis.verdict.value}, in {end.folder}'
        self.get_logger().info(f'diagnosis: {self._diagnosis}')
        if self._outputs is not None:
            self._outputs.publish_verdict(end.diagnosis, end.stamp_ns, end.frame_id)

    def _accept(self) -> str:
        self._required()
        path, added = accept(self._diagnosis_folder())
        self._change_scene()
        return f'added {", ".join(added)} to {path}; the next fit uses it'

    def _revert(self) -> str:
        scene = self._required().scene.path
        if scene is None:
            raise InputError('the scene was not read from a file: it has no model file')
        path, effect = revert(scene)
        self._change_scene()
        return f'took {effect} out of {path}; the next fit is without it'


def _scene_of(values: Values) -> Scene:
    """Load the scene that the parameters name.

    Raises:
        InputError: when there is none, or it is not a good one.
    """
    if not values['scene']:
        raise InputError("there is no scene: set the parameter 'scene' to a scene file")
    return load_scene(user_path(values['scene']))


def _answer(response: Any, act: Any) -> Any:
    """Do something and answer with what was done, or why it was not."""
    try:
        response.message = act()
        response.success = True
    except InputError as error:
        response.message = for_nodes(str(error))
        response.success = False
    return response
