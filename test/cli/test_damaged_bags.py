# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What `diffcal calibrate` says of damaged recordings, and of those given twice."""

import json
import re
import shutil

from diffcal_ros.cli.main import EXIT_BAD_INPUT
from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.recording.topics.names import COLOR_CAMERA_INFO
from diffcal_ros.recording.topics.ros_messages import camera_info_message
from mcap.reader import make_reader
import numpy as np
import pytest
from support.recorded_beam import COLOR_CAMERA, DEPTH_CAMERA

DEPTH = '/depth/image_rect_raw'


@pytest.fixture
def damaged(recorded_beam, tmp_path):
    """The beam's recording with its last chunk of depth images spoilt."""
    bag = shutil.copytree(recorded_beam.bags['observation'], tmp_path / 'damaged')
    file = next(bag.glob('*.mcap'))
    with file.open('rb') as stream:
        summary = make_reader(stream).get_summary()
    number = next(one.id for one in summary.channels.values() if one.topic == DEPTH)
    chunk = [one for one in summary.chunk_indexes if number in one.message_index_offsets][-1]
    content = bytearray(file.read_bytes())
    content[chunk.chunk_start_offset + chunk.chunk_length // 2] ^= 0x55
    file.write_bytes(content)
    return bag


@pytest.mark.slow
def test_what_is_lost_is_told_in_terminal_result_and_report(
    run_cli, recorded_beam, damaged, tmp_path
):
    out = tmp_path / 'out'
    arguments = ('calibrate', damaged, '--scene', recorded_beam.scene, '--out', out)
    refused = run_cli(*arguments)
    assert refused.code == EXIT_BAD_INPUT
    assert re.search(r'is corrupt, .* or add --allow-truncated to use what is whole', refused.err)
    ran = run_cli(*arguments, '--allow-truncated', '--max-iterations', '1')
    assert ran.code != EXIT_BAD_INPUT
    sentence = r'is damaged: \d+ messages can be read, lost are .*\d of 4 on ' + DEPTH
    assert re.search(rf'note: .*{sentence}', ran.err)
    result = json.loads((out / 'result.json').read_text())
    assert any(re.search(sentence, note) for note in result['notes'])
    (recording,) = result['recordings']
    assert recording['damaged']
    assert recording['messages_lost'][DEPTH] + recording['frames'] == 4
    assert re.search(sentence, (out / 'report.html').read_text())


@pytest.mark.slow
def test_a_recording_given_twice_is_refused(run_cli, recorded_beam, tmp_path):
    bag = recorded_beam.bags['observation']
    copy = shutil.copytree(bag, tmp_path / 'copy')
    for other in (bag, copy, bag / '..' / bag.name, next(copy.glob('*.mcap'))):
        ran = run_cli(
            'calibrate', bag, other, '--scene', recorded_beam.scene, '--out', tmp_path / 'out'
        )
        assert ran.code == EXIT_BAD_INPUT
        assert 'hold the same, and every frame would count twice: give it once' in ran.err


@pytest.mark.parametrize(
    ('fields', 'reason'),
    [
        ({'distortion_model': 'equidistant'}, "has the lens model 'equidistant'"),
        ({'k': np.zeros(9), 'p': np.zeros(12)}, 'focal length is fx=0, fy=0'),
        ({'height': 99}, 'is for 640x99 pixels, but /color/image_raw has 640x360'),
        ({'d': np.array([0.1, 0.0, 0.0])}, 'has 3 distortion coefficients'),
        ({'k': np.diag([1e-6, 1e-6, 1.0]).ravel()}, 'more than 160 degrees in view'),
    ],
)
def test_the_true_reason_is_told(run_cli, recorded_beam, change_bag, tmp_path, fields, reason):
    def write(bag, stamp):
        info = camera_info_message(COLOR_CAMERA, stamp_ns=stamp, frame_id='c')
        info.d = np.array([0.1, 0.0, 0.0, 0.0])
        for name, value in fields.items():
            setattr(info, name, value)
        bag.write(COLOR_CAMERA_INFO, info, stamp)
        for frame in open_recording(recorded_beam.bags['observation']).color_frames():
            bag.write_color(frame)

    bag = change_bag(leave_out=('color',), extra=write)
    ran = run_cli('calibrate', bag, '--scene', recorded_beam.scene, '--out', tmp_path / 'out')
    assert ran.code == EXIT_BAD_INPUT
    assert 'the marker cannot be looked for in /color/image_raw' in ran.err
    assert reason in ran.err


def test_the_focal_length_of_a_scene_is_checked_too(run_cli, change_scene):
    camera = {'width': 400, 'height': 300, 'fx': 1e-6, 'fy': 1e-6, 'cx': 200.0, 'cy': 150.0}
    ran = run_cli('check', change_scene({'camera': camera}))
    assert ran.code == EXIT_BAD_INPUT
    assert 'no camera sees so wide an angle on 400 pixels, more than 160' in ran.err + ran.out


@pytest.mark.slow
def test_the_camera_of_a_scene_stands_in_for_one_that_was_not_recorded(
    run_cli, change_bag, change_scene, tmp_path
):
    numbers = {
        name: getattr(DEPTH_CAMERA, name) for name in ('width', 'height', 'fx', 'fy', 'cx', 'cy')
    }
    ran = run_cli(
        'calibrate',
        change_bag(leave_out=('depth_camera',)),
        '--scene',
        change_scene({'camera': numbers}),
        '--out',
        tmp_path / 'out',
        '--max-iterations',
        '1',
    )
    assert ran.code != EXIT_BAD_INPUT, ran.err
