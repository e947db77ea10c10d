# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A live calibration without ROS: frames in, the command line's number out."""

from dataclasses import replace
import threading

from diffcal_ros.calibration.results.outcome import Outcome
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.errors import InputError
from diffcal_ros.live.health import Level
from diffcal_ros.live.inputs import CameraTransform
from diffcal_ros.live.session import Phase, Session
from diffcal_ros.live.session_health import session_health
from diffcal_ros.live.session_settings import SessionSettings, with_quantization
from diffcal_ros.live.tasks.background import Background
from diffcal_ros.stamped_pose import StampedPose
import numpy as np
import pytest
from support.scenes import beam_scene, CAMERA, DEPTH_FROM_WORLD, MODULUS, noisy, true_depth

_LIMIT = 180.0  # Kernels may have to be compiled [s].
FRAME = 'depth_camera'
QUICK = CalibrationSettings(with_mesh_error=False)
SETTINGS = SessionSettings(fit=QUICK, pose_source='topic', window_frames=2, window_seconds=3600.0)


@pytest.fixture(scope='module')
def depth():
    return noisy(true_depth(counts=(8, 2, 2)), np.random.default_rng(3))


class Drive:
    """A session and what its thread posts."""

    def __init__(self, scene, settings) -> None:
        self.posted = threading.Event()
        self.background = Background(self.posted.set)
        self.follower = Background(self.posted.set)
        self.session = Session(scene, settings, self.background, self.follower)
        self.now = 0

    def until(self, is_true) -> None:
        while not is_true():
            assert self.posted.wait(_LIMIT), session_health(self.session).message
            self.posted.clear()
            for event in [*self.background.events(), *self.follower.events()]:
                self.session.handle(event, self.now)

    def film(self, depth, count: int = 2) -> None:
        for _ in range(count):
            self.now += 33_333_333
            self.session.add_frame(DepthFrame(depth, self.now, FRAME), self.now)

    def give_camera_and_pose(self, camera=CAMERA) -> None:
        inputs = self.session.inputs
        inputs.set_camera(camera)
        inputs.pose = StampedPose(DEPTH_FROM_WORLD, None, FRAME)


@pytest.fixture
def drive():
    made = []

    def make(**changes):
        made.append(Drive(beam_scene(modulus=1.3 * MODULUS), replace(SETTINGS, **changes)))
        return made[-1]

    yield make
    for one in made:
        one.follower.close()
        one.background.close()


def test_it_says_what_it_waits_for_fits_and_starts_again(drive, depth):
    running = drive()
    session = running.session
    running.until(lambda: session.phase is not Phase.PREPARING)
    assert session_health(session).message.startswith('waiting for depth/image_rect_raw')
    running.film(depth, 1)
    running.give_camera_and_pose()
    assert not session.poll(running.now)
    running.film(depth, 1)
    assert session.poll(running.now)
    assert session.phase is Phase.FITTING
    running.until(lambda: session.phase is Phase.DONE)
    result = session.last_end.result
    assert result.outcome is Outcome.CONVERGED
    modulus = result['youngs_modulus']
    assert abs(modulus.value - MODULUS) < 4.0 * modulus.std_error
    assert session_health(session).level is Level.OK
    running.film(depth)
    assert not session.poll(running.now), 'once means once'
    assert 'started anew' in session.reset()
    assert session.phase is Phase.COLLECTING
    assert session.last_end is None


def test_what_was_captured_is_fitted_together(drive, depth):
    running = drive(window_frames=5)
    with pytest.raises(InputError, match='nothing has arrived yet on depth/image_rect_raw'):
        running.session.capture()
    running.until(lambda: running.session.phase is not Phase.PREPARING)
    running.give_camera_and_pose()
    running.film(depth)
    assert 'uses 1 captured' in running.session.capture()
    running.film(depth, 1)
    assert 'uses 2 captured' in running.session.capture()
    assert running.session.poll(running.now)
    running.until(lambda: running.session.phase is Phase.DONE)
    assert len(running.session.last_end.request.snapshots) == 2


def test_pictures_show_what_the_sensor_would_read(depth):
    # The sensor reads too far and cuts off millimetres: both are in the scene, neither is left.
    far = 0.02
    scene = replace(
        beam_scene(modulus=1.3 * MODULUS), effects={'depth_affine': {'scale': 0.0, 'bias': far}}
    )
    cut = (np.floor((depth + far) / 0.001) * 0.001).astype(np.float32)
    running = Drive(
        scene,
        replace(SETTINGS, refit='tracking', depth_quantization='truncate_millimetres'),
    )
    try:
        running.until(lambda: running.session.phase is not Phase.PREPARING)
        running.give_camera_and_pose()
        running.film(cut)
        assert running.session.poll(running.now)
        running.until(lambda: running.session.phase is Phase.TRACKING)
        running.session.tracking.has_onlookers = True
        running.film(cut, 1)
        running.until(lambda: running.session.tracking.picture is not None)
        drawn = [running.session.last_end.picture, running.session.tracking.picture]
    finally:
        running.follower.close()
        running.background.close()
    for picture in drawn:
        seen = np.isfinite(picture.residual)
        assert np.abs(np.median(picture.residual[seen])) < 0.0003
        assert np.median((picture.rendered - depth)[seen]) == pytest.approx(far, abs=0.0003)


def test_paused_it_takes_nothing(drive, depth):
    running = drive()
    assert running.session.enable(False) == 'paused'
    running.film(depth)
    assert running.session.phase is Phase.PAUSED
    assert not running.session.window.frames
    assert running.session.enable(True) == 'collecting frames again'


@pytest.mark.parametrize(
    ('spoil', 'words'),
    [
        (
            lambda running, depth: (running.give_camera_and_pose(), running.film(depth * np.nan)),
            'depth',
        ),
        (
            lambda running, depth: (
                running.give_camera_and_pose(PinholeCamera(64, 48, 60.0, 61.0, 31.0, 23.0)),
                running.film(depth),
            ),
            'is for 64x48 pixels',
        ),
    ],
)
def test_what_cannot_be_fitted_is_told_and_tried_again(drive, depth, spoil, words):
    running = drive()
    session = running.session
    running.until(lambda: session.phase is not Phase.PREPARING)
    spoil(running, depth)
    if session.poll(running.now):
        running.until(lambda: session.problem is not None)
    health = session_health(session)
    assert health.level is Level.ERROR
    assert words in health.message
    assert 'please report' not in health.message
    running.give_camera_and_pose()
    running.now += 10_000_000_000
    running.film(depth)
    assert session.poll(running.now)
    running.until(lambda: session.phase is Phase.DONE)
    assert session_health(session).level is Level.OK


@pytest.mark.slow
def test_a_fit_that_fails_is_an_error_and_is_tried_again_later_and_later(drive, depth):
    running = drive(refit='tracking')
    session = running.session
    running.until(lambda: session.phase is not Phase.PREPARING)
    running.give_camera_and_pose()
    for failures in (1, 2):
        # A wall far behind where the body should be.
        running.film(np.full_like(depth, 3.0))
        assert session.poll(running.now)
        end = session.last_end
        running.until(lambda end=end: session.last_end is not end)
        health = session_health(session)
        assert health.level is Level.ERROR
        assert 'the last fit diverged: No step made the fit better' in health.message
        assert f'again every {2 * failures} s' in health.message
        running.film(depth)
        assert not session.poll(running.now + 2_000_000_000 * failures - 1_000_000_000)
        running.now += 2_000_000_000 * failures
    running.film(depth)
    assert session.poll(running.now)
    assert session_health(session).level is Level.ERROR, 'until it succeeds'
    running.until(lambda: session.phase is Phase.TRACKING)
    assert session_health(session).level is Level.OK
    assert session._failure_count == 0


def test_a_transform_between_other_frames_is_refused(drive, depth):
    running = drive()
    running.give_camera_and_pose()
    running.session.inputs.pose = StampedPose(DEPTH_FROM_WORLD, None, 'color_camera')
    running.film(depth)
    (missing,) = running.session.inputs.missing(running.session.window.newest)
    assert missing.startswith("depth_from_color: where the frame 'color_camera' is in")
    assert 'ros-jazzy-tf2-ros' in missing
    running.session.inputs.transform = CameraTransform(np.eye(4), 'another', 'color_camera')
    with pytest.raises(InputError, match="leads to 'another'"):
        running.session.capture()


def test_settings_that_contradict_the_scene_are_refused(drive):
    session = drive().session
    for changes, words in (
        ({'observation': 'twisted'}, 'twisted'),
        ({'pose_source': 'estimated'}, "no 'marker'"),
        ({'fit': replace(QUICK, fit=('colour',))}, 'colour'),
    ):
        with pytest.raises(InputError, match=words):
            session.check(replace(SETTINGS, **changes))


def test_the_drivers_rounding_replaces_the_scenes():
    scene = beam_scene()
    assert with_quantization(scene, 'scene') is scene
    cut = with_quantization(scene, 'truncate_millimetres').sensor
    assert (cut.quantization, cut.quantization_mode) == (0.001, 'truncate')
    assert with_quantization(scene, 'none').sensor.quantization == 0.0
