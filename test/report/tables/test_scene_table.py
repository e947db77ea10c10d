# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The table of a scene tells its figures in units that people use."""

from diffcal_ros.report.tables.scene_table import format_rows, scene_rows
from diffcal_ros.scene.load import load_scene
import pytest


def test_the_table_tells_size_mass_bounds_and_turns(write_scene):
    changes = {
        'regions.body.youngs_modulus': {
            'start': 6e4, 'min': 5e3, 'max': 5e6, 'prior': {'mean': 5e4, 'std': 1e4},
        },
        'marker': {'dictionary': 'DICT_6X6_250', 'id': 7, 'side': 0.02},
        'held.far': {
            'box': {'x': [-1, -0.09]},
            'turn': {'axis': [1, 0, 0], 'angle_deg': 180},
        },
    }  # fmt: skip
    text = format_rows(scene_rows(load_scene(write_scene(changes))))
    # 0.2 x 0.03 x 0.03 m at 1080 kg/m^3.
    assert '200.0 x 30.0 x 30.0 mm, 180 cm^3, 194.4 g' in text
    assert '81 vertices, 192 tetrahedra, quadratic element, 18 vertices held' in text
    assert "Young's modulus 60 kPa, bounds 5 to 5000, prior 50 +- 10" in text
    assert 'DICT_6X6_250, id 7, side 20 mm' in text
    assert 'far holds 9 vertices, turned by 180 deg about (1, 0, 0)' in text
    assert 'depth camera  from camera_info' in text


@pytest.mark.parametrize(('distance', 'seen'), [(0.4, '100%'), (0.1, '70%'), (-0.4, '0%')])
def test_the_table_tells_how_much_of_the_body_is_in_view(write_scene, distance, seen):
    changes = {
        'camera': {'width': 640, 'height': 480, 'fx': 400, 'fy': 400, 'cx': 320, 'cy': 240},
        'stored_depth_from_world': {'translation': [0, 0, distance]},
    }
    # At 0.1 m the image takes in |x| < 0.8 z: 57 of the 81 vertices.
    text = format_rows(scene_rows(load_scene(write_scene(changes))))
    assert f'{seen} of its vertices in view' in text


def test_a_recording_that_is_not_there_is_told(write_scene, tmp_path):
    (tmp_path / 'here').mkdir()
    observations = [{'name': 'a', 'bag': 'here'}, {'name': 'b', 'bag': 'gone'}]
    text = format_rows(scene_rows(load_scene(write_scene({'observations': observations}))))
    assert f'recording {tmp_path / "here"}\n' in text + '\n'
    assert f'recording {tmp_path / "gone"} (not there yet)' in text


def test_a_board_is_described(write_scene):
    board = {'columns': 4, 'rows': 6, 'square': 0.03, 'legacy': True}
    changes = {'marker': {'board': board, 'dictionary': 'DICT_4X4_50', 'id': 2, 'side': 0.022}}
    text = format_rows(scene_rows(load_scene(write_scene(changes))))
    assert 'board of 4x6 squares of 30 mm, DICT_4X4_50 2 to 13, side 22 mm, legacy pat' in text
