# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Manifests: what they say, and every mistake with its line."""

from pathlib import Path
import re

from diffcal_ros.batch.manifest import load_manifest
from diffcal_ros.errors import SceneError
import pytest

_GOOD = """format: 1
scene: scene.yaml
options: --fit youngs_modulus
bodies:
  - body: one
    recordings: [take1, take2]
    material: soft
  - body: two
    scene: other.yaml
    material: {tip: soft, root: hard}
    options: --max-iterations 5
"""


@pytest.fixture
def load(tmp_path):
    """Load a manifest beside two scenes and two recordings."""
    for name in ('scene.yaml', 'other.yaml', 'take1', 'take2'):
        (tmp_path / name).touch()

    def run(text, name='batch.yaml', check=lambda body: ''):
        (tmp_path / name).write_text(text)
        return load_manifest(tmp_path / name, check)

    return run


def test_what_a_body_does_not_say_is_said_for_all(load, tmp_path) -> None:
    one, two = load(_GOOD)
    takes = [str(tmp_path / name) for name in ('take1', 'take2')]
    assert one.arguments() == [
        *('calibrate', *takes, '--scene', str(tmp_path / 'scene.yaml')),
        *('--fit', 'youngs_modulus'),
    ]
    assert one.material == {'': 'soft'}
    assert two.scene == tmp_path / 'other.yaml'
    assert two.material == {'tip': 'soft', 'root': 'hard'}
    assert two.options == ('--fit', 'youngs_modulus', '--max-iterations', '5')


def test_a_table_says_the_same(load, tmp_path) -> None:
    table = (
        'body,scene,recordings,material,options\n'
        'one,scene.yaml,take1; take2,soft,--fit youngs_modulus\n\n'
        'two,other.yaml,,,"--fit youngs_modulus --max-iterations 5"\n'
    )
    one, two = load(table, 'batch.csv')
    assert one == load(_GOOD)[0]
    assert (two.recordings, two.material) == ((), {})


def test_the_manifests_of_the_page_can_be_read(load, tmp_path) -> None:
    page = (Path(__file__).parents[2] / 'docs' / 'batch.md').read_text(encoding='utf-8')
    for name in ('finger.yaml', 'beam.yaml', 'take_01', 'take_02', 'take_02a', 'take_02b'):
        (tmp_path / name).touch()
    (table,) = re.findall(r'```\n(body,.*?)```', page, re.DOTALL)
    assert [body.name for body in load(table, 'batch.csv')] == [
        'finger_01',
        'finger_02',
        'beam_01',
    ]
    (text,) = re.findall(r'```yaml\n(.*?)```', page, re.DOTALL)
    assert load(text)[1].material == {'tip': 'ecoflex', 'root': 'dragon skin'}


def test_a_diagnosis_keeps_to_one_process(load) -> None:
    bodies = load(_GOOD.replace('format: 1', 'format: 1\ncommand: diagnose'))
    assert [body.arguments()[0] for body in bodies] == ['diagnose', 'diagnose']
    assert all('--jobs 1' in ' '.join(body.arguments()) for body in bodies)


@pytest.mark.parametrize(
    ('old', 'new', 'sentence'),
    [
        ('format: 1', 'format: 2', 'line 1: format is 2: write `format: 1`'),
        ('body: two', 'body: one', 'line 8: bodies.1..body is .one.: line 5 has a body of that'),
        ('body: two', 'body: a/b', 'line 8: bodies.1..body is .a/b.: use up to 80 letters'),
        ('other.yaml', 'none.yaml', 'line 9: bodies.1..scene is .none.yaml.: there is no file'),
        ('take2]', 'take9]', 'line 6: bodies.0..recordings.1. is .take9.: there is no'),
        ('[take1, take2]', 'take1', 'line 6: bodies.0..recordings is .take1.: give a list'),
        ('material: soft', 'materiel: soft', 'line 7: .*no key that is known.*`material`'),
        ('material: soft', 'material: [soft]', 'line 7: .*give the name of a material'),
        ('--max-iterations 5', '--fit "a', 'line 11: .*No closing quotation'),
        ('scene: scene.yaml\n', '', 'bodies.0..scene is missing'),
    ],
)
def test_a_mistake_is_told_with_its_line(load, old, new, sentence) -> None:
    with pytest.raises(SceneError, match=sentence):
        load(_GOOD.replace(old, new, 1))


def test_all_mistakes_are_told_at_once(load) -> None:
    text = _GOOD.replace('take1', 'x').replace('other.yaml', 'y').replace('body: two', 'body: .')
    with pytest.raises(SceneError, match='3 mistakes') as raised:
        load(text)
    assert [f'line {n}' in str(raised.value) for n in (6, 8, 9)] == [True] * 3


def test_what_the_command_would_refuse_is_refused_with_the_line(load) -> None:
    with pytest.raises(SceneError, match=r'line 11: bodies.1..options are wrong somehow'):
        load(_GOOD, check=lambda body: 'are wrong somehow' if body.name == 'two' else '')


@pytest.mark.parametrize(
    ('table', 'sentence'),
    [
        ('', 'is empty: its first line names columns'),
        ('body,colour\n', "line 1: it has the column 'colour'"),
        ('scene\nscene.yaml\n', 'line 1: it has no column `body`'),
        ('body,body\n', "line 1: it has the column 'body' twice"),
        ('body,scene\none,scene.yaml\ntwo\n', 'line 3: it has 1 cells, and 2 columns'),
        ('body,scene\none,"scene.yaml\n', 'line 2: not readable as CSV'),
        ('body,scene\none,none.yaml\n', 'line 2: bodies.0..scene is .none.yaml.: there is no'),
        ('body,scene\n', 'line 1: bodies is ..: give a list'),
    ],
)
def test_a_mistake_in_a_table_is_told_with_its_line(load, table, sentence) -> None:
    with pytest.raises(SceneError, match=sentence):
        load(table, 'batch.csv')


def test_a_manifest_that_is_not_there_is_told(tmp_path) -> None:
    with pytest.raises(SceneError, match=r'there is no manifest file .*none.yaml: check the path'):
        load_manifest(tmp_path / 'none.yaml', lambda body: '')
