# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Rate, exposure, jitter and lost frames of a synthetic recording of a motion."""

import json

from diffcal_ros.calibration.forward.motion_check import has_changed
from diffcal_ros.errors import InputError
from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.scene.load import load_scene
from diffcal_ros.synthetic.filming import line_by_line, Timing
from diffcal_ros.synthetic.scan import Scan
import numpy as np
import pytest
from support.released_beam import record_release, RELEASE_TIME


@pytest.mark.parametrize('rate', [30.0, 60.0, 90.0])
def test_times_and_stamps_follow_the_rate(rate, random):
    timing = Timing(10, rate)
    np.testing.assert_allclose(timing.times(), np.arange(10) / rate)
    np.testing.assert_allclose(timing.stamps_ns(random), 1e9 * timing.times(), atol=10.0)
    assert timing.kept(random) == list(range(10))


def test_jitter_has_its_size_and_never_turns_the_order(random):
    stamps = np.array(Timing(4000, 30.0, stamp_jitter=0.002).stamps_ns(random))
    errors = 1e-9 * stamps - np.arange(4000) / 30.0
    assert errors.std() == pytest.approx(0.002, rel=0.05)
    wild = Timing(4000, 30.0, stamp_jitter=0.03).stamps_ns(random)
    assert (np.diff(wild) > 0).all()


def test_lost_frames_are_as_many_as_asked_for_and_never_the_first(random):
    kept = Timing(4000, drop_share=0.25).kept(random)
    assert kept[0] == 0
    assert len(kept) == pytest.approx(3000, rel=0.05)


def test_an_exposure_lies_around_the_stamp():
    instants = Timing(3, exposure=0.01).instants()
    assert instants.mean() == pytest.approx(0.0, abs=1e-15)
    assert np.ptp(instants) == pytest.approx(0.008)
    assert Timing(3).instants().tolist() == [0.0]


def test_lines_are_taken_one_after_the_other():
    scans = [
        Scan(np.full((4, 3), float(k)), np.ones((4, 3)), np.zeros((4, 3), np.int32))
        for k in range(2)
    ]
    assert line_by_line(scans).depth[:, 0].tolist() == [0.0, 0.0, 1.0, 1.0]
    assert line_by_line(scans[:1]) is scans[0]


@pytest.mark.parametrize(
    ('change', 'message'),
    [
        ({'frames': 0}, '0 depth frames were asked for: give at least one'),
        ({'rate': 0.0}, r'frame rate is 0 Hz: give 0\.1 to 1000'),
        ({'exposure': 0.1}, r'exposure is 0\.1 s: give 0 to the 0\.03333 s'),
        ({'stamp_jitter': -1.0}, r'jitter of the stamps is -1 s'),
        ({'drop_share': 1.0}, r'share of lost frames is 1: give 0 to less than 1'),
    ],
)
def test_timing_that_makes_no_sense_is_refused(change, message):
    with pytest.raises(InputError, match=message):
        Timing(**change)


@pytest.fixture(scope='module')
def released(tmp_path_factory):
    timing = Timing(9, 30.0, exposure=0.01, stamp_jitter=0.001, drop_share=0.2)
    return record_release(tmp_path_factory.mktemp('released'), timing=timing)


def test_the_body_rests_until_its_release_and_then_falls(released):
    frames = list(open_recording(released.bags['observation']).depth_frames())
    times = 1e-9 * (np.array([frame.stamp_ns for frame in frames]) - frames[0].stamp_ns)
    moved = [has_changed(frames[0].depth, frame.depth) for frame in frames]
    assert 4 <= len(frames) < 9
    assert not any(moved[k] for k in np.flatnonzero(times < RELEASE_TIME))
    assert all(moved[k] for k in np.flatnonzero(times > RELEASE_TIME + 0.06))
    # Jitter of a millisecond: no stamp lies on the grid of the rate.
    assert np.abs(30.0 * times - np.round(30.0 * times))[1:].min() > 1e-4


def test_the_written_scene_starts_away_from_the_truth(released):
    scene = load_scene(released.scene)
    truth = json.loads(released.truth.read_text())
    assert truth['observations']['observation']['release_time'] == RELEASE_TIME
    assert truth['parameters']['body']['damping'] == 150.0
    assert truth['timing']['exposure'] == 0.01
    assert scene.regions[0].damping.start == pytest.approx(195.0)
    assert scene.observations[0].motion.release_time.start == pytest.approx(RELEASE_TIME + 0.02)
