# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whatever is wrong with what `diffcal calibrate` is given: one sentence, code 2, no files."""

from collections.abc import Callable
from dataclasses import replace
import re
from typing import Any

from diffcal_ros.cli.main import EXIT_BAD_INPUT
from diffcal_ros.recording.bag_writer import BagWriter
from diffcal_ros.recording.topics.names import DEPTH_CAMERA_INFO, DEPTH_IMAGE
from diffcal_ros.recording.topics.ros_messages import camera_info_message, image_message
import numpy as np
import pytest
from support.recorded_beam import DEPTH_CAMERA

INF = float('inf')


def add_image(topic: str, encoding: str, kind: type) -> Callable[[BagWriter, int], None]:
    def write(bag: BagWriter, stamp: int) -> None:
        pixels = np.ones((DEPTH_CAMERA.height, DEPTH_CAMERA.width), kind)
        image = image_message(pixels, encoding=encoding, stamp_ns=stamp, frame_id='d')
        bag.write(topic, image, stamp)

    return write


def add_info(camera: Any, **fields: Any) -> Callable[[BagWriter, int], None]:
    def write(bag: BagWriter, stamp: int) -> None:
        info = camera_info_message(camera, stamp_ns=stamp, frame_id='d')
        for name, value in fields.items():
            setattr(info, name, value)
        bag.write(DEPTH_CAMERA_INFO, info, stamp)

    return write


SMALL = replace(DEPTH_CAMERA, width=200, height=150)
BAGS: dict[str, tuple[dict[str, Any], str]] = {
    'no depth topic': ({'leave_out': ('depth',)}, 'no depth topic, only .*: record /depth'),
    'two depth topics': (
        {'extra': add_image('/aligned/image_raw', '32FC1', np.float32)},
        '2 depth topics, .*choose one with --depth-topic',
    ),
    'unknown encoding': (
        {'leave_out': ('depth',), 'extra': add_image(DEPTH_IMAGE, '64FC1', np.float64)},
        "encoding '64FC1': depth comes as 32FC1",
    ),
    'no camera_info': ({'leave_out': ('depth_camera',)}, 'no camera_info .*record it, or give'),
    'camera_info of another size': (
        {'leave_out': ('depth_camera',), 'extra': add_info(SMALL)},
        'is for 200x150 pixels, but .* has 400x300: record',
    ),
    'zero focal length': (
        {
            'leave_out': ('depth_camera',),
            'extra': add_info(DEPTH_CAMERA, k=np.zeros(9), p=np.zeros(12)),
        },
        'focal length is fx=0, fy=0: both must be positive',
    ),
    'depth all NaN': ({'depth': lambda d: d * np.nan}, 'no depth in any of 4 frames, all zero'),
    'depth all infinite': ({'depth': lambda d: d * INF}, 'no depth in any of 4 frames, all zero'),
    'depth all zero': ({'depth': lambda d: d * 0.0}, 'no depth in any of 4 frames, all zero'),
    'millimetres as metres': (
        {'depth': lambda d: 1000.0 * d},
        r'/depth/image_rect_raw holds depths of [\d.]+ m in the middle: 32FC1 is in metres, so',
    ),
    'no colour': ({'leave_out': ('color',)}, 'no colour images .*record them too, or give'),
    'no transform': ({'leave_out': ('transform',)}, 'where the colour camera is: record /tf_stat'),
    'marker never seen': (
        {'color': lambda image: np.full_like(image, 90)},
        'marker 7 of DICT_6X6_250 was never seen in 2 colour frames, nor any other',
    ),
}


@pytest.mark.parametrize('mistake', BAGS)
def test_a_recording_that_cannot_be_used(run_cli, recorded_beam, change_bag, tmp_path, mistake):
    changes, sentence = BAGS[mistake]
    bag = change_bag(**changes)
    ran = run_cli('calibrate', bag, '--scene', recorded_beam.scene, '--out', tmp_path / 'out')
    check(ran, sentence, tmp_path / 'out')
    # Of several recordings, the one at fault is named.
    assert str(bag) in ran.err


def test_a_recording_that_is_missing_empty_cut_or_spoilt(run_cli, recorded_beam, tmp_path):
    whole = next(recorded_beam.bags['observation'].glob('*.mcap')).read_bytes()
    spoilt = bytearray(whole)
    spoilt[len(whole) // 3] ^= 0x55
    for content, sentence in (
        (None, r'there is no recording .*x\.mcap: check the path'),
        (b'', r'x\.mcap is empty: nothing was recorded'),
        (whole[: len(whole) // 2], r'x\.mcap is truncated.*: add --allow-truncated'),
        (bytes(spoilt), r'x\.mcap is corrupt, .*: copy it again'),
    ):
        if content is not None:
            (tmp_path / 'x.mcap').write_bytes(content)
        arguments = ('--scene', recorded_beam.scene, '--out', tmp_path / 'out')
        check(run_cli('calibrate', tmp_path / 'x.mcap', *arguments), sentence, tmp_path / 'out')


def mesh_lines(text: str) -> tuple[list[str], list[str]]:
    lines = text.splitlines()
    return [x for x in lines if x[0] == 'v'], [x for x in lines if x[0] == 't']


def turn_one(text: str) -> str:
    vertices, tets = mesh_lines(text)
    _, a, b, c, d = tets[5].split()
    tets[5] = f't {b} {a} {c} {d}'
    return '\n'.join([*vertices, *tets])


def flatten_one(text: str) -> str:
    vertices, tets = mesh_lines(text)
    _, a, _, c, d = tets[5].split()
    tets[5] = f't {a} {a} {c} {d}'
    return '\n'.join([*vertices, *tets])


def double_one(text: str) -> str:
    return '\n'.join([text, mesh_lines(text)[1][3]])


def add_vertex(text: str) -> str:
    vertices, tets = mesh_lines(text)
    return '\n'.join([*vertices, 'v 1 2 3', *tets])


BODY = 'regions.body'
SCENES: dict[str, tuple[dict[str, Any], Any, str]] = {
    'marker of another id': ({'marker.id': 3}, None, 'but marker 7 of that .*: set the marker id'),
    'marker too small': (
        {'marker.side': 0.95 * 0.03},
        None,
        r"\(-\d\.\d%, 3% is tolerated\): the marker's side .* wrong; 1\.05\d times it would fit",
    ),
    'marker too large': (
        {'marker.side': 1.05 * 0.03},
        None,
        r"\(\+\d\.\d%, 3% is tolerated\): the marker's side .* wrong; 0\.95\d times it would fit",
    ),
    'no marker': ({'marker': ...}, None, "no 'marker': add its dictionary, .*--pose stored"),
    'inverted tetrahedron': ({}, turn_one, '1 of 192 tetrahedra are inverted .*: swap two'),
    'degenerate tetrahedron': ({}, flatten_one, '1 of 192 tetrahedra are degenerate .*: mesh'),
    'duplicate tetrahedron': ({}, double_one, '1 tetrahedra are duplicates: remove the copies'),
    'unreferenced vertex': ({}, add_vertex, '1 vertices belong to no tetrahedron .*: remove'),
    'a body of 120 m': ({'mesh.unit': 'm'}, None, "is 120 m long: set the mesh's unit"),
    'nothing held': ({'held.clamp.box': {'x': [5, 6]}}, None, 'no vertex lies in it; the body'),
    'start outside bounds': (
        {f'{BODY}.youngs_modulus': {'start': 1e8, 'min': 5e3, 'max': 5e6}},
        None,
        r'youngs_modulus\.start is 1e\+08: it must lie within its bounds, 5000 to 5e\+06',
    ),
    'body beside the image': (
        {'placement.translation': [1.5, 0, 0]},
        None,
        "of a 400x300 image: it must be in the camera's view; check the placement",
    ),
    'body behind the camera': (
        {'placement.translation': [0, 0, 3.0]},
        None,
        r'nearest point is at z = -\d.* m of the camera: it must lie in front of it; check',
    ),
}


@pytest.mark.parametrize('mistake', SCENES)
def test_a_scene_that_does_not_fit(run_cli, change_scene, tmp_path, mistake):
    changes, mesh, sentence = SCENES[mistake]
    scene = change_scene(changes, mesh)
    check(
        run_cli('calibrate', '--scene', scene, '--out', tmp_path / 'out'),
        sentence,
        tmp_path / 'out',
    )


OPTIONS: dict[str, tuple[tuple[str, ...], str]] = {
    'unknown topic': (('--depth-topic', '/x'), '/x is no image topic .*choose another'),
    'no stored pose': (('--pose', 'stored'), "no 'stored_depth_from_world': add it, or use"),
    'unknown parameter': (('--fit', 'youngs'), "--fit has 'youngs'; did you mean `youngs_modulus"),
    'demon on the robust loss': (('--optimizer', 'adam_demon'), 'choose one of them with --loss'),
    'no iteration': (('--max-iterations', '0'), 'max_iterations is 0: give at least 1'),
    'a GPU that is not there': (('--device', 'cuda:99'), "device is 'cuda:99': this machine has "),
}


@pytest.mark.parametrize('mistake', OPTIONS)
def test_an_option_that_makes_no_sense(run_cli, recorded_beam, tmp_path, mistake):
    options, sentence = OPTIONS[mistake]
    arguments = ('--scene', recorded_beam.scene, '--out', tmp_path / 'out')
    check(run_cli('calibrate', *arguments, *options), sentence, tmp_path / 'out')


def test_a_recording_taken_for_a_parameter(run_cli, recorded_beam, tmp_path):
    arguments = ('--scene', recorded_beam.scene, '--out', tmp_path / 'out')
    ran = run_cli('calibrate', *arguments, '--fit', 'density', recorded_beam.bags['observation'])
    check(ran, 'a path: name the recordings before the options', tmp_path / 'out')


def test_results_that_cannot_go_where_they_are_told(run_cli, recorded_beam, tmp_path):
    (tmp_path / 'file').write_text('kept')
    out = tmp_path / 'file'
    ran = run_cli('calibrate', '--scene', recorded_beam.scene, '--out', out)
    assert ran.code == EXIT_BAD_INPUT
    assert 'result.json cannot be written' in ran.err
    assert out.read_text() == 'kept'


@pytest.mark.slow
def test_nan_and_infinity_among_the_depths_are_left_out(
    run_cli, recorded_beam, change_bag, tmp_path
):
    random = np.random.default_rng(3)

    def sprinkle(depth: np.ndarray) -> np.ndarray:
        depth[random.random(depth.shape) < 0.02] = np.nan
        depth[random.random(depth.shape) < 0.02] = np.inf
        depth[random.random(depth.shape) < 0.02] = -np.inf
        return depth

    bag = change_bag(depth=sprinkle)
    ran = run_cli('calibrate', bag, '--scene', recorded_beam.scene, '--out', tmp_path / 'out')
    assert ran.code == 0
    assert 'median nan' not in ran.out
    assert 'beam: converged' in ran.out


def check(ran: Any, sentence: str, out: Any) -> None:
    """One clear sentence at the end, and nothing written."""
    assert ran.code == EXIT_BAD_INPUT
    last = ran.err.splitlines()[-1]
    assert last.startswith('diffcal calibrate: ')
    assert re.search(sentence, last), last
    assert 'Traceback' not in ran.err
    assert ran.out == ''
    assert not out.exists()
