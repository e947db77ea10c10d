# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The schema of scene files: made of what the reader goes by, it refuses what the reader does."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from diffcal_ros.cli.main import main
from diffcal_ros.effects.registry import EFFECTS
from diffcal_ros.errors import SceneError
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.reading.quantities import QUANTITY_RULES
from diffcal_ros.scene.reading.section import Section
from diffcal_ros.scene.reading.shapes import Keys, ListOf, OneOf
from diffcal_ros.scene.save import save_fitted_scene
from diffcal_ros.scene.scene_shape import SCENE_SHAPE
from diffcal_ros.scene.schema import scene_schema, scene_schema_text
from diffcal_ros.scene.sections.modulus_field import FIELD_FILE, write_modulus_field
import numpy as np
import pytest
from support.scene_files import BOARD
import yaml

jsonschema = pytest.importorskip('jsonschema')

ROOT = Path(__file__).resolve().parents[2]
EXAMPLE = ROOT / 'config' / 'example_scene.yaml'
SCENES = [EXAMPLE, ROOT / 'bags' / 'sample' / 'scene.yaml']
VIA = [[-0.09, 0.0, 0.01], [0.0, 0.001, 0.012], [0.09, 0.0, 0.01]]
# Known nowhere, no number, and no name of anything.
STRANGE = 'kwyjibo'
BOUNDED = {'start': 0.1, 'min': 0.0, 'max': 0.3, 'prior': {'mean': 0.1, 'std': 0.02}}
BOUNDED_CABLE = {'start': 0.18, 'min': 0.1, 'max': 0.2, 'prior': {'mean': 0.18, 'std': 0.02}}
TURN = {'axis': [1, 0, 0], 'angle_deg': 9, 'center': [0, 0, 0], 'translation': [0, 0, 0]}
PLACED = {'translation': [0.0, 0.0, 0.4], 'quaternion_xyzw': [0, 0, 0, 1]}
EVERYTHING_ELSE = {
    'bag': 'bag',
    'mesh.element': 'linear',
    'cables': {
        'tendon': {'via': VIA, 'pull': 0.01, 'stiffness': BOUNDED_CABLE, 'crosses_gaps': True},
        'other': {'via': VIA, 'rest_length': BOUNDED_CABLE},
    },
    'observations': [
        {
            'name': 'only',
            'pulls': {'tendon': 0.01},
            'held_parts': ['clamp'],
            'held_turns': {'clamp': TURN},
            'pose': {'source': 'topic', 'topic': '/pose', 'world_frame': 'rig'},
            'placement': {'translation': [0, 0, 0], 'rotation_matrix': np.eye(3).tolist()},
            'stored_depth_from_world': PLACED,
            'gravity': [0, -9.81, 0],
            'bag': 'bag',
        },
        {'name': 'as above'},
    ],
    'effects': {
        name: {
            **{part.name: max(part.lower, 0.0) for part in effect.components},
            **effect.settings,
        }
        for name, effect in EFFECTS.items()
    },
    'marker': {**BOARD, 'id': 1, 'placement': PLACED},
    'color_camera': {
        'width': 64, 'height': 48, 'fx': 50.0, 'fy': 51.0, 'cx': 31, 'cy': 23,
        'distortion': [0.0, 0.0, 0.0, 0.0],
    },
    'modulus_field': {'file': FIELD_FILE},
    'fixture': {'file': 'clamp.stl', 'unit': 'mm'},
}  # fmt: skip
MOVING = {
    'held.ledge': {'vertices': [0, 1, 2, 3]},
    'motion': {'released': ['ledge'], 'at': BOUNDED, 'time_step': 0.004, 'tolerance': 1e-5},
}
BOUNDED_REGION = {
    name: {'start': 0.45, 'min': 0.1, 'max': 0.49, 'prior': {'mean': 0.45, 'std': 0.1}}
    for name in QUANTITY_RULES
}
LISTED = {
    'regions.body': {**BOUNDED_REGION, 'tets': list(range(192))},
    'mesh.edge_length': None,
}


@pytest.fixture(scope='module')
def accepts() -> Any:
    schema = scene_schema()
    jsonschema.Draft7Validator.check_schema(schema)
    return jsonschema.Draft7Validator(schema).is_valid


@pytest.fixture
def specimens(write_scene, beam_mesh, tmp_path) -> list[dict[str, Any]]:
    """Sound scenes that together use every key; the files they name stand in `tmp_path`."""
    import trimesh

    trimesh.creation.box((20.0, 20.0, 20.0)).export(tmp_path / 'clamp.stl')
    write_modulus_field(tmp_path / FIELD_FILE, beam_mesh, np.ones(beam_mesh.tet_count))
    paths = [EXAMPLE]
    found = [yaml.safe_load(path.read_text()) for path in paths]
    for changes in (EVERYTHING_ELSE, MOVING, LISTED):
        found.append(yaml.safe_load(write_scene(changes).read_text()))
    return found


@pytest.fixture
def reads(tmp_path) -> Any:
    def read(document: dict[str, Any]) -> bool:
        (tmp_path / 'scene.yaml').write_text(yaml.dump(document, Dumper=yaml.CSafeDumper))
        try:
            load_scene(tmp_path / 'scene.yaml')
        except SceneError:
            return False
        return True

    return read


def test_the_committed_schema_is_what_the_reader_gives(capsys):
    committed = (ROOT / 'config' / 'scene.schema.json').read_text(encoding='utf-8')
    assert committed == scene_schema_text(), 'run `diffcal schema > config/scene.schema.json`'
    assert main(['schema']) == 0
    assert capsys.readouterr().out == committed


@pytest.mark.parametrize('path', SCENES, ids=lambda path: path.name)
def test_scenes_of_the_project_are_valid_and_name_the_schema(path, accepts):
    text = path.read_text()
    assert accepts(yaml.safe_load(text))
    named = text.partition('\n')[0].partition('$schema=')[2]
    assert (path.parent / named).resolve() == ROOT / 'config' / 'scene.schema.json'


def test_written_scenes_are_valid(write_scene, tmp_path, accepts):
    scene = load_scene(write_scene())
    save_fitted_scene(scene, tmp_path / 'fitted.yaml', {'youngs_modulus': 7e4})
    assert accepts(yaml.safe_load((tmp_path / 'fitted.yaml').read_text()))


def test_an_effect_of_another_form_is_valid_where_the_effect_has_it(specimens, accepts, reads):
    document = specimens[1]
    for own, is_valid in (({'a': 1.0, 'a_3': 2.0}, True), ({'a_33': 2.0}, False)):
        document['effects'] = {'rest_curvature': own}
        assert accepts(document) is is_valid
        assert reads(document) is is_valid


def test_synthetic_scenes_are_valid(recorded_beam, accepts):
    assert accepts(yaml.safe_load(recorded_beam.scene.read_text()))


def test_specimens_are_sound(specimens, accepts, reads):
    for document in specimens:
        assert accepts(document)
        assert reads(document)


def test_the_reader_asks_for_every_declared_key(specimens, reads, monkeypatch):
    asked: set[tuple[int, str]] = set()
    original = Section._ask

    def ask(section: Section, name: str) -> None:
        asked.add((id(section._shape), name))
        original(section, name)

    monkeypatch.setattr(Section, '_ask', ask)
    for document in specimens:
        reads(document)
    missing = {
        f'{where}.{name}'
        for where, keys in _mappings(SCENE_SHAPE, '')
        for name in keys.entries
        if (id(keys), name) not in asked
    }
    assert not missing


def test_both_refuse_unknown_keys(specimens, accepts, reads):
    for document in specimens:
        for where, place in _mappings_in(document, ''):
            place[STRANGE] = STRANGE
            assert not accepts(document), f'the schema takes {where}.{STRANGE}'
            assert not reads(document), f'the reader takes {where}.{STRANGE}'
            del place[STRANGE]


@pytest.mark.slow
def test_both_refuse_values_of_another_kind(specimens, accepts, reads):
    """A mapping of an unknown key in place of each value."""
    for document in specimens[:2]:
        for where, place, key in _values_in(document, ''):
            kept = place[key]
            place[key] = {STRANGE: {STRANGE: 1}}
            assert not accepts(document), f'the schema takes {where}'
            assert not reads(document), f'the reader takes {where}'
            place[key] = kept


@pytest.mark.parametrize('dotted', ['format', 'mesh.file', 'mesh.unit', 'held', 'regions.body'])
def test_both_refuse_a_scene_without(dotted, specimens, accepts, reads):
    document = specimens[1]
    place, (*folders, key) = document, dotted.split('.')
    for folder in folders:
        place = place[folder]
    del place[key]
    assert not accepts(document)
    assert not reads(document)


@pytest.mark.parametrize(
    ('dotted', 'value'),
    [
        ('format', 2),
        ('mesh.unit', 'inch'),
        ('mesh.element', 'cubic'),
        ('regions.body.youngs_modulus', 60),
        ('regions.body.poissons_ratio', 0.5),
        ('regions.body.density', '1 g'),
        ('gravity', [0, -9810, 0]),
        ('gravity', [0, -9.81]),
        ('masks', {'held_margin': 5}),
        ('masks', {'boxes': [[0, 0, 1]]}),
        ('pose', {'source': 'gps'}),
        ('sensor', {'noise': 0}),
        ('law', {'name': 'hookean'}),
        ('fit', 'youngs_modulus'),
        ('observations', []),
    ],
)
def test_both_refuse_values_out_of_range(dotted, value, write_scene, accepts):
    path = write_scene({dotted: value})
    assert not accepts(yaml.safe_load(path.read_text()))
    with pytest.raises(SceneError, match=dotted.replace('.', r'\.')):
        load_scene(path)


def test_both_take_numbers_that_yaml_reads_as_texts(write_scene, accepts):
    path = write_scene({'regions.body.youngs_modulus': '6e4'})
    assert accepts(yaml.safe_load(path.read_text()))
    assert load_scene(path).regions[0].youngs_modulus.start == 6e4


def _mappings(shape: Any, where: str) -> Iterator[tuple[str, Keys]]:
    if isinstance(shape, Keys):
        yield where, shape
        for name, entry in shape.entries.items():
            yield from _mappings(entry, f'{where}.{name}')
        yield from _mappings(shape.named, f'{where}.*')
    elif isinstance(shape, OneOf):
        for one in shape.shapes:
            yield from _mappings(one, where)
    elif isinstance(shape, ListOf):
        yield from _mappings(shape.item, f'{where}[]')


def _mappings_in(value: Any, where: str) -> Iterator[tuple[str, dict[str, Any]]]:
    if isinstance(value, dict):
        yield where, value
    for key, item in _items(value):
        yield from _mappings_in(item, f'{where}.{key}')


def _values_in(value: Any, where: str) -> Iterator[tuple[str, Any, Any]]:
    for key, item in _items(value):
        yield f'{where}.{key}', value, key
        yield from _values_in(item, f'{where}.{key}')


def _items(value: Any) -> list[tuple[Any, Any]]:
    if isinstance(value, dict):
        return list(value.items())
    return list(enumerate(value[:1])) if isinstance(value, list) else []
