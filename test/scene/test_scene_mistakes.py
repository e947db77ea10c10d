# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is said about each mistake in a scene file."""

import math
import re

from diffcal_ros.errors import SceneError
from diffcal_ros.scene.fit_names import fit_problems
from diffcal_ros.scene.load import load_scene
import numpy as np
import pytest
from support.scene_files import BOARD

INF = float('inf')
BODY = 'regions.body'
MISTAKES = {
    'unknown key': ({'mesh.elment': 'linear'}, r'line 5: mesh\.elment .*did you mean `element`'),
    'unknown top key': ({'gravty': 1}, r'gravty is no key .*did you mean `gravity`'),
    'format missing': ({'format': ...}, 'format is missing: write `format: 1`'),
    'format of the future': ({'format': 2}, 'format is 2: this version reads format 1'),
    'no mesh': ({'mesh': ...}, 'mesh is missing: give'),
    'mesh not there': ({'mesh.file': 'no.tet'}, r"mesh\.file is 'no.tet': there is no mesh file"),
    'mesh of another kind': ({'mesh.file': 'a.step'}, r"suffix '\.step': meshes are \.tet, \.msh"),
    'no unit': ({'mesh.unit': ...}, r'mesh\.unit is missing: allowed: m, cm, mm'),
    'wrong unit': ({'mesh.unit': 'inch'}, r"mesh\.unit is 'inch': allowed: m, cm, mm"),
    'a 20 m finger': ({'mesh.unit': 'm'}, r'unit m: the body is 200 m long: set the mesh'),
    'element': (
        {'mesh.element': 'cubic'},
        r"element is 'cubic': allowed: linear, quadratic",
    ),
    'edge length': ({'mesh.edge_length': 0.01}, 'edge_length is for surfaces, leave it out'),
    'law': ({'law.name': 'hookean'}, r"law\.name is 'hookean': allowed: stable_neo_hookean, lin"),
    'convention': ({'law.lame_convention': 'x'}, 'lame_convention is .x.: allowed: consistent'),
    'nothing held': ({'held': {}}, 'held is empty: hold at least one part'),
    'held missing': ({'held': ...}, 'held is missing: name the clamped part'),
    'held part empty': ({'held.clamp': {'turn': None}}, 'held.clamp holds nothing: give a box'),
    'held part null': ({'held.clamp': None}, 'held.clamp is None: give a box or vertices'),
    'held box in mm': ({'held.clamp.box.x': [80, 100]}, r'no vertex lies in it; the body spans x'),
    'held box swapped': ({'held.clamp.box.x': [0.1, 0.08]}, r'low is 0\.1 and above high, 0\.08'),
    'held box of nothing': ({'held.clamp.box': {}}, r'held\.clamp\.box limits nothing'),
    'held box axis': ({'held.clamp.box': {'w': [0, 1]}}, r'box\.w is no key .*allowed: x, y, z'),
    'held box a number': ({'held.clamp.box.x': 0.08}, r'box\.x is 0\.08: give \[low, high\]'),
    'held in line': ({'held.clamp': {'vertices': [0, 1, 2]}}, 'holds 3 vertices on one line'),
    'held too few': ({'held.clamp': {'vertices': [0, 5]}}, 'holds 2 vertices on one line'),
    'held all': ({'held.clamp': {'box': {'x': [-1, 1]}}}, 'holds all 81 vertices: nothing is'),
    'held outside': ({'held.clamp': {'vertices': [0, 1, 99]}}, 'names 99: the mesh has 81 of'),
    'held twice': ({'held.clamp': {'vertices': [0, 1, 1]}}, 'names 1 of its 3 numbers twice'),
    'held two ways': ({'held.clamp.vertices': [1]}, 'held.clamp has box and vertices: keep one'),
    'turn without angle': (
        {'held.clamp.turn': {'axis': [1, 0, 0]}},
        r'held\.clamp\.turn\.angle_deg is missing: give the angle in degrees',
    ),
    'turn without direction': (
        {'held.clamp.turn': {'axis': [0, 0, 0], 'angle_deg': 9}},
        r'turn\.axis is \[0, 0, 0\]: give a direction that is not zero',
    ),
    'shared and turned': (
        {
            'held.far': {
                'box': {'x': [0.09, 1]},
                'turn': {'axis': [1, 0, 0], 'angle_deg': 9},
            }
        },
        'has 9 vertices that `clamp` and `far` both hold while one of them turns',
    ),
    'no region': ({'regions': {}}, 'regions is empty: give at least one'),
    'region name': ({'regions': {'a.b': {}}}, 'is no name for a region: use letters'),
    'modulus missing': ({f'{BODY}.youngs_modulus': ...}, 'youngs_modulus is missing: give Young'),
    'modulus in kPa': ({f'{BODY}.youngs_modulus': 60}, "60: Young's modulus is usually 1000 to"),
    'modulus no number': ({f'{BODY}.youngs_modulus': '60 kPa'}, "is '60 kPa': give Young.*in Pa"),
    'modulus true': ({f'{BODY}.youngs_modulus': True}, 'is True: give Young'),
    'modulus NaN': ({f'{BODY}.youngs_modulus': math.nan}, 'is nan: give Young'),
    'modulus infinite': ({f'{BODY}.youngs_modulus': INF}, 'is inf: give Young'),
    'start outside bounds': (
        {f'{BODY}.youngs_modulus': {'start': 9e6, 'min': 5e3, 'max': 5e6}},
        r'line \d+: regions\.body\.youngs_modulus\.start is 9e\+06: .*bounds, 5000 to 5e\+06',
    ),
    'bounds swapped': (
        {f'{BODY}.youngs_modulus': {'start': 1e5, 'min': 5e6, 'max': 5e3}},
        r'youngs_modulus has min 5e\+06 and max 5000: min must be below max',
    ),
    'prior without std': (
        {f'{BODY}.youngs_modulus': {'start': 1e5, 'prior': {'mean': 1e5}}},
        r'youngs_modulus\.prior\.std is missing: give the standard deviation in Pa',
    ),
    'prior without width': (
        {f'{BODY}.youngs_modulus': {'start': 1e5, 'prior': {'mean': 1e5, 'std': 0}}},
        r'prior\.std is 0: give the standard deviation',
    ),
    'nu 0.5': ({f'{BODY}.poissons_ratio': 0.5}, 'is 0.5: give Poisson.*above -1 and below 0.5'),
    'nu max 0.5': (
        {f'{BODY}.poissons_ratio': {'start': 0.4, 'max': 0.5}},
        r'poissons_ratio\.max is 0\.5: .*below 0\.5',
    ),
    'density in g/cm^3': ({f'{BODY}.density': 1.08}, 'density is usually 50 to 20000 kg/m'),
    'regions overlap': (
        {
            'regions.low': {'box': {'x': [-1, 0.02]}},
            f'{BODY}.box': {'x': [0, 1]},
        },
        r'shares \d+ tetrahedra with `body`',
    ),
    'regions leave out': ({f'{BODY}.box': {'x': [0, 1]}}, 'regions leave out 96 of 192 tetrahe'),
    'region elsewhere': ({f'{BODY}.box': {'x': [1, 2]}}, "no tetrahedron's centroid lies in it"),
    'region without place': ({'regions.low': {}}, 'says not which part of the body it is'),
    'region of nothing': (
        {f'{BODY}.box': {'x': [-1, 1]}, 'regions.low': {'rest': True}},
        'regions.low has no tetrahedron: the other regions take the whole body',
    ),
    'two rests': (
        {f'{BODY}.rest': True, 'regions.low': {'rest': True}},
        'regions.low has `rest: true`, as `body` has',
    ),
    'rest and box': ({f'{BODY}.box': {'x': [0, 1]}, f'{BODY}.rest': True}, 'has `rest` and a box'),
    'gravity short': ({'gravity': [0, -9.8]}, r'gravity is \[0, -9\.8\]: give the acceleration'),
    'gravity in mm': ({'gravity': [0, -9810, 0]}, 'gravity is .*-9810.*in m/s.2'),
    'no placement': ({'placement': ...}, 'placement is missing: give translation and rotation'),
    'placement stretched': (
        {'placement.rotation_matrix': [[2, 0, 0], [0, 1, 0], [0, 0, 1]]},
        r'placement\.rotation_matrix is not rigid: its 3x3 part must be a rotation',
    ),
    'placement mirrored': (
        {'placement.rotation_matrix': [[-1, 0, 0], [0, 1, 0], [0, 0, 1]]},
        'placement.rotation_matrix mirrors',
    ),
    'placement rows': ({'placement.rotation_matrix': [1, 2]}, 'give three rows of three numbers'),
    'placement twice turned': (
        {
            'placement.rotation_vector_deg': [0, 0, 0],
            'placement.quaternion_xyzw': [0, 0, 0, 1],
        },
        'placement has quaternion_xyzw, rotation_vector_deg: keep one of them',
    ),
    'quaternion': ({'placement.quaternion_xyzw': [0, 0, 1, 1]}, r'four numbers .* of length 1'),
    'dictionary': (
        {'marker': {'dictionary': 'DICT_6x6_250', 'id': 0, 'side': 0.02}},
        "dictionary is 'DICT_6x6_250': .*did you mean `DICT_6X6_250`",
    ),
    'marker id': (
        {'marker': {'dictionary': 'DICT_4X4_50', 'id': 50, 'side': 0.02}},
        r'marker\.id is 50: give a whole number at least 0 and at most 49',
    ),
    'marker in mm': (
        {'marker': {'dictionary': 'DICT_4X4_50', 'id': 0, 'side': 20}},
        r'marker\.side is 20: give the edge of the black square in metres',
    ),
    'board of one row': (
        {'marker': {**BOARD, 'board': {'columns': 5, 'rows': 1, 'square': 0.03}}},
        r'marker\.board\.rows is 1: give a whole number at least 3',
    ),
    'board too small': (
        {'marker': {**BOARD, 'board': {'columns': 3, 'rows': 3, 'square': 0.03}}},
        r'marker\.board cannot be used: a board of 3x3 squares has 4 inner corners: at least 6',
    ),
    'board of large markers': (
        {'marker': {**BOARD, 'side': 0.03}},
        r'markers of 30 mm do not fit into squares of 30 mm: give the edge of the black square',
    ),
    'board in mm': (
        {'marker': {**BOARD, 'board': {'columns': 5, 'rows': 7, 'square': 30}}},
        r'marker\.board\.square is 30: give the edge of a chessboard square in metres',
    ),
    'board beyond its dictionary': (
        {'marker': {**BOARD, 'id': 40}},
        r'5x7 squares holds 17 markers, 40 to 56, but the dictionary only 0 to 49',
    ),
    'board key': (
        {'marker': {**BOARD, 'board': {'columns': 5, 'rows': 7, 'square': 0.03, 'legcy': True}}},
        r'marker\.board\.legcy is no key .*did you mean `legacy`',
    ),
    'camera uncalibrated': (
        {'camera': {'width': 4, 'height': 3, 'fx': 0, 'fy': 1, 'cx': 1, 'cy': 1}},
        r'camera\.fx is 0: give the focal length in pixels, above 0; zero means not calibrated',
    ),
    'camera word': ({'camera': 'auto'}, "camera is 'auto': write from_camera_info or"),
    'camera distorted': (
        {
            'camera': {'width': 4, 'height': 3, 'fx': 1, 'fy': 1, 'cx': 1, 'cy': 1}
            | {'distortion': [0.1, 0, 0, 0, 0]}
        },
        'camera.distortion is .*depth images are rectified',
    ),
    'mask empty': ({'masks.boxes': [[5, 0, 4, 9]]}, r'masks\.boxes\[0\] is .*: it is empty'),
    'mask outside': (
        {
            'masks.boxes': [[0, 0, 1, 1], [4, 0, 9, 9]],
            'camera': {'width': 4, 'height': 3, 'fx': 1, 'fy': 1, 'cx': 1, 'cy': 1},
        },
        r'masks\.boxes\[1\] is \[4, 0, 9, 9\]: it lies outside the image',
    ),
    'truncation in mm': ({'masks.truncation': 20}, 'truncation is 20: give a length in metres'),
    'held mask': ({'masks.held': 'yes please'}, r'masks\.held is .*: write true or false'),
    'sensor mode': ({'sensor.quantization_mode': 'floor'}, 'allowed: round, truncate'),
    'offset prior': ({'rigid_offset.translation_std': 0}, 'translation_std is 0: give a length'),
    'fit unknown': ({'fit': ['youngs_modulos']}, r"fit has 'youngs_modulos'; did you mean"),
    'fit unknown region': ({'fit': ['density.bdy']}, 'did you mean `density.body`'),
    'fit twice': ({'fit': ['density', 'density.body']}, "has 'density.body' twice"),
    'fit nothing': ({'fit': []}, 'fit is empty: name at least one'),
    'fit a word': ({'fit': 'density'}, "fit is 'density': give a list of parameter names"),
    'density without weight': (
        {'fit': ['density'], 'gravity': [0, 0, 0]},
        "fit has 'density' while gravity is zero in every observation",
    ),
    'nothing loads': ({'gravity': [0, 0, 0], 'fit': ['youngs_modulus']}, 'nothing loads the body'),
    'observation nameless': ({'observations': [{}]}, r'observations\[0\]\.name is missing'),
    'observations twice': (
        {'observations': [{'name': 'a'}, {'name': 'a'}]},
        r"observations\[1\]\.name is 'a': another observation has that name",
    ),
    'observations a mapping': ({'observations': {'a': 1}}, 'observations is .*: give a list'),
    'observation part': (
        {'observations': [{'name': 'a', 'held_turns': {'clmp': None}}]},
        r'held_turns\.clmp is no part held here; did you mean `clamp`',
    ),
    'observation holds': (
        {'observations': [{'name': 'a', 'held_parts': ['far']}]},
        r"held_parts is \['far'\]: give a list of held parts, from clamp",
    ),
    'observation key': ({'observations': [{'name': 'a', 'masks': {}}]}, 'masks is no key'),
}


@pytest.mark.parametrize('mistake', MISTAKES)
def test_each_mistake_is_named(write_scene, mistake):
    changes, sentence = MISTAKES[mistake]
    changes = dict(changes)
    if 'regions.low' in changes:
        body = {'youngs_modulus': 1e5, 'poissons_ratio': 0.49, 'density': 1080}
        changes['regions.low'] = {**body, **changes['regions.low']}
    with pytest.raises(SceneError, match=r'(?s)scene\.yaml.*' + sentence) as error:
        load_scene(write_scene(changes))
    assert 'Traceback' not in str(error.value)


def test_one_mistake_is_one_sentence_and_several_are_one_line_each(write_scene):
    with pytest.raises(SceneError) as one:
        load_scene(write_scene({'gravity': 9.8}))
    assert str(one.value).count('\n') == 0
    mistakes = {'placement.translation': 1, 'gravity': 9.8, 'mesh.unit': 'inch'}
    several = write_scene({**mistakes, f'{BODY}.density': -1})
    with pytest.raises(SceneError, match=r'scene\.yaml: 4 mistakes') as error:
        load_scene(several)
    lines = str(error.value).splitlines()[1:]
    numbers = [int(re.match(r'  line (\d+): ', line).group(1)) for line in lines]
    written = several.read_text().splitlines()
    assert [written[number - 1].split(':')[0].strip() for number in numbers] == [
        'unit',
        'density',
        'gravity',
        'translation',
    ]


def test_a_mistake_above_is_told_once_for_all_observations(write_scene):
    changes = {'placement.translation': 'x', 'observations': [{'name': 'a'}, {'name': 'b'}]}
    with pytest.raises(SceneError, match=r'line \d+: placement\.translation is') as error:
        load_scene(write_scene(changes))
    assert str(error.value).count('placement') == 1


@pytest.mark.parametrize(
    ('text', 'sentence'),
    [
        ('', 'is empty: a scene file starts with `format: 1`'),
        ('- a\n- b\n', 'is a list, not a mapping'),
        ('a: [1,\n', r'line 2, column 1: not readable as YAML'),
        ('a: 1\n\tb: 2\n', r'line 2, column 1: not readable as YAML'),
        ('a: 1\nb: {c: 1, c: 2}\na: 3\n', r'`a` stands on line 1 and again on line 3'),
        ('b: {c: 1,\n c: 2}\n', r'`b\.c` stands on line 1 and again on line 2'),
        ('a: 2001-99-99\n', 'holds a value that YAML cannot read'),
        ('a: !!python/object:os.system x\n', 'not readable as YAML'),
        ('x: \x00\n', 'not readable as YAML'),
        ('[' * 20000, 'is nested too deeply'),
        ('format: 1\n1: 2\n', '1 is no text: put the key in quotes'),
    ],
)
def test_unreadable_yaml_says_where(tmp_path, text, sentence):
    path = tmp_path / 'scene.yaml'
    path.write_text(text)
    with pytest.raises(SceneError, match=sentence):
        load_scene(path)


def test_missing_folder_and_binary_files_are_refused(tmp_path):
    with pytest.raises(SceneError, match='there is no scene file') as missing:
        load_scene(tmp_path / 'none.yaml')
    assert 'make one with `diffcal init` or `diffcal import`' in str(missing.value)
    with pytest.raises(SceneError, match='is a folder: name the file in it'):
        load_scene(tmp_path)
    (tmp_path / 'x.mcap').write_bytes(b'\x89MCAP0\r\n\xff\xfe')
    with pytest.raises(SceneError, match='is no text file: a scene is YAML'):
        load_scene(tmp_path / 'x.mcap')


def test_a_loose_piece_of_the_mesh_is_refused(write_scene, write_tet, beam_mesh, tmp_path):
    path = write_scene()
    loose = beam_mesh.rest_positions[beam_mesh.tets[0]] + [0.0, 0.1, 0.0]
    mesh = type(beam_mesh)(
        np.vstack([beam_mesh.rest_positions, loose]),
        np.vstack([beam_mesh.tets, np.arange(4) + beam_mesh.vertex_count]).astype(np.int32),
    )
    write_tet(tmp_path / 'beam.tet', mesh)
    with pytest.raises(SceneError, match='leaves a piece of 4 vertices loose'):
        load_scene(path)


def test_parts_that_an_observation_leaves_out_must_not_be_needed(write_scene):
    line = {'vertices': [0, 1, 2]}
    changes = {'held.line': line, 'observations': [{'name': 'a', 'held_parts': ['line']}]}
    with pytest.raises(SceneError, match=r'observations\[0\] holds 3 vertices on one line'):
        load_scene(write_scene(changes))


def test_fit_names_are_checked_for_the_command_line_too(write_scene):
    scene = load_scene(write_scene())
    names = ['youngs_modulus.body', 'rigid_offset', 'gravity_tilt']
    assert fit_problems(names, ['body'], scene.observations) == []
    (problem,) = fit_problems(['rigid_ofset'], ['body'], scene.observations)
    assert 'did you mean `rigid_offset`' in problem
