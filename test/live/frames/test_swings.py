# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A session that fits a body each time it is let go."""

from dataclasses import replace
from functools import cache
import threading

from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.errors import InputError
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.live.health import Level
from diffcal_ros.live.session import Phase, Session
from diffcal_ros.live.session_health import session_health
from diffcal_ros.live.session_settings import SessionSettings
from diffcal_ros.live.tasks.background import Background
from diffcal_ros.stamped_pose import StampedPose
import numpy as np
import pytest
from support.moving_beams import DAMPING, moving_scene, true_depths
from support.scenes import CAMERA, DEPTH_FROM_WORLD, MODULUS, noisy

_LIMIT = 180.0  # Kernels may have to be compiled [s].
FRAME = 'depth_camera'
PERIOD = 33_333_333  # [ns]
WALL = 0.9  # [m]
COUNTS = (6, 1, 1)
FIT = ('youngs_modulus', 'damping', 'release_time')
DURATION = 0.6  # [s]
SWING = 0.7  # Until this time after the release the beam is filmed [s].
LATE = 0.012  # The release lies between two frames [s].
SETTINGS = SessionSettings(
    fit=CalibrationSettings(with_mesh_error=False), pose_source='topic', refit='tracking'
)


def scene(modulus: float = MODULUS):
    made = moving_scene(
        COUNTS, modulus=modulus, element=Element.LINEAR, fit=FIT, release_time=LATE
    )
    (setup,) = made.observations
    motion = replace(setup.motion, duration=DURATION, hold_out=4)
    return replace(made, observations=(replace(setup, motion=motion),))


@cache
def film(factor: float = 1.0) -> tuple[np.ndarray, ...]:
    """Depth of the beam before a wall from its rest on, without noise [m]."""
    times = np.arange(0.0, SWING, PERIOD / 1e9)
    return tuple(
        np.where(np.isnan(depth), WALL, depth)
        for depth in true_depths(scene(factor * MODULUS), times)
    )


class Stage:
    """A camera before a session, in time that the test makes."""

    def __init__(self) -> None:
        self.posted = threading.Event()
        self.background, self.follower = (Background(self.posted.set) for _ in range(2))
        start = scene(1.2 * MODULUS)
        self.session = Session(start, SETTINGS, self.background, self.follower)
        self.session.inputs.set_camera(CAMERA)
        self.session.inputs.pose = StampedPose(DEPTH_FROM_WORLD, None, FRAME)
        self.stamp_ns = 1_700_000_000_000_000_000
        self._random = np.random.default_rng(8)

    def close(self) -> None:
        assert self.background.close()
        assert self.follower.close()

    def until(self, is_true) -> None:
        while not is_true():
            assert self.posted.wait(_LIMIT), session_health(self.session).message
            self.posted.clear()
            for event in self.background.events():
                self.session.handle(event, self.stamp_ns)

    def shoot(self, depths) -> None:
        for depth in depths:
            self.stamp_ns += PERIOD
            frame = DepthFrame(noisy(depth, self._random), self.stamp_ns, FRAME)
            self.session.add_frame(frame, self.stamp_ns)

    def rest(self, seconds: float = 0.6, depth: np.ndarray | None = None) -> None:
        still = film()[0] if depth is None else depth
        self.shoot([still] * round(seconds * 1e9 / PERIOD))

    def let_go(self, factor: float = 1.0) -> None:
        self.rest(0.6, film(factor)[0])
        self.shoot(film(factor))

    def fit(self) -> None:
        assert self.session.poll(self.stamp_ns)
        self.until(lambda: self.session.phase is not Phase.FITTING)


@pytest.fixture
def stage():
    made = Stage()
    made.until(lambda: made.session.phase is not Phase.PREPARING)
    yield made
    made.close()


def test_a_swing_is_fitted(stage):
    session = stage.session
    assert session_health(session).message.startswith('waiting for depth/image_rect_raw')
    stage.rest()
    assert session_health(session).message.startswith('the body rests, let it go')
    assert not session.poll(stage.stamp_ns)
    stage.let_go()
    stage.fit()
    first = session.last_end.result
    assert first.outcome.is_fitted
    assert first['youngs_modulus'].value == pytest.approx(MODULUS, rel=0.02)
    assert first['damping'].value == pytest.approx(DAMPING, rel=0.05)
    assert 0.0 < first['youngs_modulus'].std_error < 0.1 * MODULUS
    assert first.gap_held_out.pixels > 0
    # What is shown is the last frame that was fitted.
    picture = session.last_end.picture
    stamps = [frame.stamp_ns for frame in session.last_end.request.snapshots[0].frames]
    assert picture.stamp_ns in stamps
    assert np.nanmedian(np.abs(picture.residual)) < 0.0005
    health = session_health(session)
    assert health.values['swings fitted'] == '1'
    assert int(health.values['frames used']) == len(stamps)


@pytest.mark.slow
def test_a_change_between_two_swings_is_told(stage):
    session = stage.session
    stage.let_go()
    stage.fit()
    first = session.last_end.result
    stage.let_go(1.3)
    stage.fit()
    second = session.last_end.result
    assert second['youngs_modulus'].value == pytest.approx(1.3 * MODULUS, rel=0.02)
    # It started where the first one ended.
    assert second.history[0].values['youngs_modulus'] == first['youngs_modulus'].value
    assert session.swings.change_count == 1
    assert set(session.swings.change.before) == {'youngs_modulus'}


@pytest.mark.slow
def test_of_two_swings_during_a_fit_the_newest_wins(stage):
    session = stage.session
    stage.let_go()
    assert session.poll(stage.stamp_ns)
    for _ in range(2):
        stage.let_go()
    stage.until(lambda: session.phase is not Phase.FITTING)
    health = session_health(session)
    assert health.values['swings skipped'] == '1'
    assert int(health.values['frames skipped']) == pytest.approx(0.6 * 30, abs=3)
    newest = stage.stamp_ns
    stage.fit()
    assert session.last_end.request.snapshots[0].newest.stamp_ns > newest - 0.4e9


@pytest.mark.slow
def test_a_body_that_is_lifted_is_no_release(stage):
    # As low as it swings; the model's own swing passes there too.
    stage.rest(0.6, film()[3])
    stage.shoot([film()[0]] * 30)
    stage.fit()
    health = session_health(stage.session)
    assert health.level is Level.ERROR
    assert 'no release was seen but another movement' in health.message
    # It goes on all the same.
    stage.stamp_ns += 3_000_000_000
    stage.let_go()
    stage.fit()
    assert session_health(stage.session).level is Level.OK


def test_what_the_stream_does_not_show_is_told(stage):
    stage.rest(11.0)
    health = session_health(stage.session)
    assert health.level is Level.WARN
    assert 'the release was never seen: let the body go' in health.message
    stage.shoot([film()[number % 8] for number in range(400)])
    health = session_health(stage.session)
    assert health.level is Level.WARN
    assert 'something has been moving for' in health.message


def test_what_makes_no_sense_of_a_motion_is_refused(stage):
    with pytest.raises(InputError, match='there is no posture to capture'):
        stage.session.capture()
    without = replace(SETTINGS, fit=CalibrationSettings(fit=('youngs_modulus', 'damping')))
    with pytest.raises(InputError, match="'release_time' is not fitted: live nobody knows"):
        stage.session.check(without)
