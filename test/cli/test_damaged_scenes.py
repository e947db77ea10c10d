# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whatever stands in a scene, `diffcal check` reads it or says what is wrong."""

from pathlib import Path
import random
import shutil
import sys

from diffcal_ros.cli.main import EXIT_BAD_INPUT, EXIT_DONE
import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))
from benchmarks.faults.damaged_scenes import DAMAGE, damaged, EXAMPLE, example, places  # noqa: E402

# A few of thousands of pairs; other seeds are for hunting.
_SEED, _COUNT = 20260901, 120
_LONGEST = 4000


@pytest.fixture
def folder(tmp_path, beam_mesh, write_tet, monkeypatch):
    """The example beside its mesh."""
    write_tet(tmp_path / 'beam.tet', beam_mesh)
    shutil.copy(EXAMPLE, tmp_path / 'scene.yaml')
    monkeypatch.chdir(tmp_path)
    return tmp_path


def check(run_cli, folder, text) -> None:
    (folder / 'scene.yaml').write_text(text, encoding='utf-8', errors='surrogatepass')
    ran = run_cli('check', 'scene.yaml', '--no-draw')
    assert ran.code in (EXIT_DONE, EXIT_BAD_INPUT), ran.err
    is_refused = ran.code == EXIT_BAD_INPUT
    assert bool(ran.err) == is_refused
    assert ran.err.startswith('diffcal check: scene.yaml' if is_refused else '')
    assert not (is_refused and ran.out)
    assert len(ran.err) < _LONGEST


@pytest.mark.slow
def test_one_entry_is_replaced_by_anything(run_cli, folder):
    document = example()
    pairs = [(place, value) for place in places(document) for value in DAMAGE]
    for place, value in random.Random(_SEED).sample(pairs, _COUNT):
        check(run_cli, folder, yaml.safe_dump(damaged(document, place, value)))


def test_the_text_itself_is_damaged(run_cli, folder):
    text = EXAMPLE.read_text()
    numbers = random.Random(_SEED)
    for _ in range(15):
        place = numbers.randrange(len(text))
        check(run_cli, folder, text[:place] + numbers.choice('\0\t:[{&*!|%@`"\'-') + text[place:])
    check(run_cli, folder, text[: len(text) // 2])


@pytest.mark.parametrize(
    'value',
    [
        *('!!int ""', '!!bool maybe', '!!timestamp never', '!!float abc', '!!binary "é"'),
        *('!!python/object/apply:os.system [ls]', '1:2:3:4:5:6:7:8:9', '2026-13-45', '<<: 1'),
        *('0x' + 'f' * 9000, '!!set {a, b}', '!!omap [a: 1]', '? [1, 2]', '!!null x', '= '),
    ],
)
def test_tags_that_do_not_fit(run_cli, folder, value):
    check(run_cli, folder, EXAMPLE.read_text().replace('name: hanging_beam', f'name: {value}'))
    check(run_cli, folder, EXAMPLE.read_text().replace('format: 1', f'format: {value}'))


@pytest.mark.parametrize('name', ['a $ b $ c', '\\udcff$\\frac$', '☃ %s {0}'])
def test_odd_names_are_drawn(run_cli, folder, name):
    document = example()
    document['name'] = name.encode().decode('unicode_escape') if '\\u' in name else name
    document['observations'] = document['observations'][:1]
    (folder / 'scene.yaml').write_text(yaml.safe_dump(document))
    ran = run_cli('check', 'scene.yaml', '--draw', 'x.png')
    assert ran.code == EXIT_DONE, ran.err
    assert (folder / 'x.png').stat().st_size > 10_000
