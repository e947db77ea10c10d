# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bags of a motion whose clock is wrong: counted and told, or refused whole."""

from collections.abc import Callable
from pathlib import Path

from diffcal_ros.errors import RecordingError
from diffcal_ros.offline.calibrate_recordings import OfflineInputs, open_inputs
from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.recording.bag_writer import BagWriter
from diffcal_ros.recording.topics.names import DEPTH_FRAME, DEPTH_IMAGE
from diffcal_ros.recording.topics.ros_messages import image_message
from diffcal_ros.scene.load import load_scene
from diffcal_ros.synthetic.filming import Timing
import pytest
from support.released_beam import record_release

_MILLISECOND = 1_000_000  # [ns]
_PERIOD = 33_333_333  # Of the frames [ns].
Clock = Callable[[int, int], int]


@pytest.fixture(scope='module')
def released(tmp_path_factory):
    """Twelve frames at 30 Hz; without a marker, so that no colour is needed."""
    return record_release(tmp_path_factory.mktemp('released'), {'marker': ...}, Timing(12))


@pytest.fixture
def opened(released, tmp_path) -> Callable[[Clock], OfflineInputs]:
    """Copy the bag with other stamps, and open it."""

    def open_with(clock: Clock) -> OfflineInputs:
        source = open_recording(released.bags['observation'])
        path: Path = tmp_path / 'spoilt'
        with BagWriter(path) as bag:
            for number, frame in enumerate(source.depth_frames()):
                # The recorder's own clock is right: only the header's stamp is spoilt.
                logged = frame.stamp_ns
                bag.write_depth_camera(source.depth_camera, stamp_ns=logged, frame_id=DEPTH_FRAME)
                image = image_message(
                    frame.depth,
                    encoding='32FC1',
                    stamp_ns=clock(number, logged),
                    frame_id=DEPTH_FRAME,
                )
                bag.write(DEPTH_IMAGE, image, logged)
        return open_inputs(load_scene(released.scene), [path], pose_source='stored')

    return open_with


def test_good_stamps_need_no_words(opened):
    inputs = opened(lambda _, stamp: stamp)
    assert len(inputs.observations) == 12
    assert not any('stamp' in note for note in inputs.notes)


def test_a_stamp_that_repeats_and_one_that_jumps_back_are_left_out_and_counted(opened):
    late = {4: 1, 8: 3}  # Frames that carry the stamp of one so many before.
    inputs = opened(lambda number, stamp: stamp - late.get(number, 0) * _PERIOD)
    assert len(inputs.observations) == 10
    assert any(
        '1 stamps jump back and 1 stamps repeat the one before: these frames are left out' in note
        for note in inputs.notes
    )


def test_a_clock_that_stands_still_is_refused(opened):
    with pytest.raises(RecordingError, match=r'spoilt: all 12 .* the clock stands still'):
        opened(lambda _, stamp: 10**18)


def test_a_clock_that_starts_anew_is_refused(opened):
    with pytest.raises(RecordingError, match=r'spoilt: .* their order in time is not known'):
        opened(lambda number, stamp: stamp - (200 * _MILLISECOND if number > 5 else 0))


def test_what_comes_after_a_gap_of_seconds_is_left_out_and_told(opened):
    inputs = opened(lambda number, stamp: stamp + (2500 * _MILLISECOND if number > 8 else 0))
    assert len(inputs.observations) == 9
    assert any('no frame for 2.5 s after 0.27 s: the 3 frames' in note for note in inputs.notes)


def test_a_gap_before_the_release_leaves_nothing_to_see(opened):
    with pytest.raises(RecordingError, match=r'spoilt: the frames end .* it is never seen'):
        opened(lambda number, stamp: stamp + (5000 * _MILLISECOND if number > 1 else 0))
