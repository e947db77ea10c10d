# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A session that follows a body after its first fit."""

from dataclasses import replace
import json
import threading

from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.live.health import Level
from diffcal_ros.live.save import save_numbers
from diffcal_ros.live.session import Phase, Session
from diffcal_ros.live.session_health import session_health
from diffcal_ros.live.session_settings import SessionSettings
from diffcal_ros.live.tasks.background import Background
from diffcal_ros.live.tracking import TrackingSettings
from diffcal_ros.scene.load import load_scene
from diffcal_ros.stamped_pose import StampedPose
import numpy as np
import pytest
from support.followed import exact, PERIOD, START
from support.scenes import beam_scene, CAMERA, DEPTH_FROM_WORLD, MODULUS, noisy
from support.two_materials import second_material

_LIMIT = 180.0  # Kernels may have to be compiled [s].
FRAME = 'depth_camera'
SETTINGS = SessionSettings(
    fit=CalibrationSettings(with_mesh_error=False),
    pose_source='topic',
    window_frames=4,
    window_seconds=3600.0,
    refit='tracking',
    tracking=TrackingSettings(picture_rate=1000.0),
)


class Stream:
    """A camera before a session; every frame is waited for."""

    def __init__(self, region_count: int = 1, fit: tuple[str, ...] = ('youngs_modulus',)) -> None:
        self.posted = threading.Event()
        self.background, self.follower = (Background(self.posted.set) for _ in range(2))
        scene = beam_scene(modulus=1.1 * MODULUS, region_count=region_count, fit=fit)
        self.session = Session(scene, SETTINGS, self.background, self.follower)
        self.session.inputs.set_camera(CAMERA)
        self.session.inputs.pose = StampedPose(DEPTH_FROM_WORLD, None, FRAME)
        self.stamp_ns = START
        self.spoil: np.ndarray = np.float32(1.0)
        self.step: np.ndarray = np.float32(0.0)
        self._random = np.random.default_rng(6)

    def close(self) -> None:
        assert self.follower.close()
        assert self.background.close()

    def until(self, is_true) -> None:
        while not is_true():
            assert self.posted.wait(_LIMIT), session_health(self.session).message
            self.posted.clear()
            for event in [*self.background.events(), *self.follower.events()]:
                self.session.handle(event, self.stamp_ns)

    def put(self, factor: float = 1.0) -> None:
        """Send one frame."""
        depth = self.spoil * noisy(exact(factor), self._random) + self.step
        frame = DepthFrame(depth, self.stamp_ns, FRAME)
        self.session.add_frame(frame, self.stamp_ns)

    def shoot(self, count: int, factor: float = 1.0) -> None:
        """Send frames, each when the one before is done."""
        for _ in range(count):
            self.stamp_ns += PERIOD
            self.put(factor)
            if self.session.phase is Phase.TRACKING:
                stamp = self.stamp_ns
                self.until(lambda: self.last_stamp() == stamp)  # noqa: B023

    def last_stamp(self) -> int:
        last = self.session.tracking.last
        return 0 if last is None else last.tracked.stamp_ns

    def track(self) -> None:
        """Fit, and begin to track."""
        self.until(lambda: self.session.phase is not Phase.PREPARING)
        self.shoot(SETTINGS.window_frames)
        assert self.session.poll(self.stamp_ns)
        self.until(lambda: self.session.phase is Phase.TRACKING)

    @property
    def modulus(self) -> float:
        return self.session.tracking.last.tracked.values()['youngs_modulus']


@pytest.fixture
def stream():
    made = Stream()
    yield made
    made.close()


@pytest.mark.slow
def test_a_step_is_followed_told_and_saved(stream, tmp_path):
    session = stream.session
    stream.track()
    assert session_health(session).message == 'tracking, waiting for the first frame'
    stream.shoot(20)
    assert stream.modulus == pytest.approx(MODULUS, rel=0.01)
    assert session_health(session).message == 'tracking'
    stream.shoot(30, 1.3)
    assert stream.modulus == pytest.approx(1.3 * MODULUS, rel=0.01)
    assert session.tracking.change_count == 1
    health = session_health(session)
    assert health.level is Level.OK
    assert 'the body changed suddenly: youngs_modulus' in health.message
    assert health.values['frames used'] == '50'
    assert health.values['frames skipped'] == '0'
    assert health.values['searches'] == '1'
    # What is saved is what is known now, from frames of the body as it is now.
    end = session.present()
    changed = session.tracking.change.stamp_ns
    assert min(f.stamp_ns for f in end.request.snapshots[0].frames) >= changed
    scene = load_scene_with_file(tmp_path)
    save_numbers(replace(end, request=replace(end.request, scene=scene)), tmp_path / 'out')
    saved = json.loads((tmp_path / 'out' / 'result.json').read_text())
    assert saved['parameters']['youngs_modulus']['value'] == pytest.approx(stream.modulus)
    assert saved['tracking']['changes'] == '1'
    again = end.request.calibration()
    there = [
        parameter.coordinate(found.value)
        for parameter, found in zip(again.parameters, end.result.parameters, strict=True)
    ]
    assert again.objective.gap(np.array(there)).median < 0.0002


def load_scene_with_file(folder):
    """A scene that was read from a file: only such a one is saved."""
    from support.recorded_beam import write_beam_scene

    return load_scene(write_beam_scene(folder))


def test_pictures_are_drawn_only_for_who_looks(stream):
    stream.track()
    stream.shoot(3)
    assert stream.session.tracking.picture is None
    stream.session.tracking.has_onlookers = True
    stream.shoot(1)
    stream.until(lambda: stream.session.tracking.picture is not None)
    picture = stream.session.tracking.picture
    assert picture.stamp_ns == stream.stamp_ns
    assert np.nanmedian(np.abs(picture.residual)) < 0.001


def test_stamps_that_stand_still_are_told(stream):
    session = stream.session
    stream.track()
    stream.shoot(2)
    for _ in range(40):
        stream.put()
    health = session_health(session)
    assert health.level is Level.WARN
    assert 'stand still' in health.message
    assert health.values['frames refused for their stamp'] == '40'
    stream.shoot(1)
    assert session_health(session).level is Level.OK


@pytest.mark.parametrize(
    ('factor', 'words'),
    [
        (np.nan, 'no pixel of the depth images holds a depth'),
        (1000.0, 'depth is 1e+03 times that of the fit: the images are in another unit now'),
        (0.001, 'depth is 0.001 times that of the fit'),
    ],
)
@pytest.mark.slow
def test_why_the_images_do_not_show_the_body_is_told(stream, factor, words):
    session = stream.session
    stream.track()
    stream.shoot(5)
    stream.spoil = np.float32(factor)
    stream.shoot(40)
    health = session_health(session)
    assert health.level is Level.ERROR
    assert words in health.message
    stream.spoil = np.float32(1.0)
    stream.shoot(3)
    assert session_health(session).level is Level.OK


def test_a_clock_set_back_and_a_gap_of_seconds_are_lived_through(stream):
    stream.track()
    stream.shoot(10)
    stream.stamp_ns -= 60_000_000_000
    stream.shoot(10)
    assert stream.modulus == pytest.approx(MODULUS, rel=0.01)
    stream.stamp_ns += 10_000_000_000
    stream.shoot(10)
    assert stream.modulus == pytest.approx(MODULUS, rel=0.01)
    assert stream.session.tracking.change_count == 0


@pytest.mark.slow
def test_another_image_size_a_pause_and_a_reset_end_it(stream):
    session = stream.session
    stream.track()
    stream.shoot(2)
    session.add_frame(DepthFrame(np.ones((3, 4), np.float32), stream.stamp_ns + PERIOD, FRAME), 0)
    assert session.phase is Phase.COLLECTING
    session.reset()
    stream.shoot(SETTINGS.window_frames)
    assert session.poll(stream.stamp_ns)
    stream.until(lambda: session.phase is Phase.TRACKING)
    session.enable(False)
    assert session.phase is Phase.PAUSED
    session.enable(True)
    assert session.phase is Phase.COLLECTING


def test_other_settings_end_it_and_the_next_fit_starts_where_it_was(stream):
    session = stream.session
    stream.track()
    stream.shoot(10)
    session.change(replace(SETTINGS, refit='once'))
    assert session.phase is Phase.COLLECTING
    stream.shoot(SETTINGS.window_frames)
    assert session.poll(stream.stamp_ns)
    stream.until(lambda: session.phase is Phase.DONE)
    first = session.last_end.result.history[0].values['youngs_modulus']
    assert first == pytest.approx(MODULUS, rel=0.01)


@pytest.mark.slow
def test_a_camera_that_looks_into_a_material_is_followed_as_it_was_fitted():
    """What the fit has added to its model is in the tracker's as well."""
    stream = Stream(2, ('youngs_modulus', 'rigid_offset'))
    try:
        stream.step = np.where(second_material(), np.float32(0.022), np.float32(0.0))
        stream.track()
        fitted = stream.session.last_end.result
        assert fitted['depth_bias_by_region.bias'].value == pytest.approx(0.022, abs=0.001)
        stream.shoot(2)
        tracked = stream.session.tracking.last.tracked.values()
        assert tracked.keys() == fitted.values().keys()
        assert tracked['youngs_modulus.part_0'] == pytest.approx(MODULUS, rel=0.1)
    finally:
        stream.close()
