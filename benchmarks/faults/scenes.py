# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Scenes in which stands what nobody would write: `diffcal check` reads or refuses them."""

from collections.abc import Iterator
import contextlib
import io
import os
from pathlib import Path
import random
import shutil

from diffcal_ros.cli.main import main
import numpy as np
import yaml

from benchmarks.faults.damaged_scenes import DAMAGE, damaged, EXAMPLE, example, places
from benchmarks.faults.oracle import HangError, time_limit
from benchmarks.faults.outcome import Outcome
from benchmarks.live_scene import cantilever

_LONGEST = 4000
_READ, _REFUSED = 0, 2
# Of the beam that the example speaks of, its middle at the origin [mm].
_SIZE_MM = np.array([200.0, 30.0, 30.0])
# One scene in so many has its text damaged, the others a value.
_TEXTS = 5


def scene_cases(folder: Path, count: int, seed: int) -> Iterator[Outcome]:
    """Damage the example scene `count` times; yield what came of each."""
    shutil.copy(EXAMPLE, folder / 'scene.yaml')
    _write_mesh(folder / 'beam.tet')
    document, text = example(), EXAMPLE.read_text()
    pairs = [(place, value) for place in places(document) for value in DAMAGE]
    numbers = random.Random(seed)
    with _inside(folder):
        if count:
            outcome, detail = _check()
            # A control: what nobody damaged is read.
            is_read = outcome == 'read whole'
            yield Outcome(
                'scene', 'as it is', outcome if is_read else 'refused needlessly', detail
            )
        for number in range(1, count):
            if number % _TEXTS == 0:
                name, content = _damaged_text(text, numbers)
            else:
                place, value = numbers.choice(pairs)
                name = f'{".".join(map(str, place))} = {value!r:.60}'
                content = yaml.safe_dump(damaged(document, place, value))
            Path('scene.yaml').write_text(content, encoding='utf-8', errors='surrogatepass')
            yield Outcome('scene', name, *_check())


def _damaged_text(text: str, numbers: random.Random) -> tuple[str, str]:
    place = numbers.randrange(len(text))
    how = numbers.choice(('insert', 'remove', 'cut', 'repeat'))
    if how == 'insert':
        letter = numbers.choice('\0\t:[{&*!|%@`"\'-é\x1b')
        return f'{letter!r} at {place}', text[:place] + letter + text[place:]
    if how == 'remove':
        return f'40 letters gone at {place}', text[:place] + text[place + 40 :]
    if how == 'cut':
        return f'cut at {place}', text[:place]
    return f'repeated from {place}', text + text[place:]


def _check() -> tuple[str, str]:
    """Run the command in this process; judge by its code and what it says."""
    out, err = io.StringIO(), io.StringIO()
    try:
        with time_limit(), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = main(['check', 'scene.yaml', '--no-draw'])
    except HangError:
        return 'hang', ''
    except BaseException as error:  # SystemExit as well: a sentence is what is owed.
        return 'traceback', repr(error)
    said = err.getvalue()
    if code not in (_READ, _REFUSED) or 'Traceback' in said or len(said) > _LONGEST:
        return 'traceback', f'exit code {code}: {said[-300:]}'
    if (code == _REFUSED) != said.startswith('diffcal check: scene.yaml'):
        return 'refused unsaid', f'exit code {code}: {said[:300]}'
    return ('refused' if code == _REFUSED else 'read whole'), ''


def _write_mesh(path: Path) -> None:
    mesh = cantilever((8, 2, 2))
    own = mesh.rest_positions / np.ptp(mesh.rest_positions, axis=0) - 0.5
    lines = [f'v {x} {y} {z}' for x, y, z in (own * _SIZE_MM).tolist()]
    lines += [f't {a} {b} {c} {d}' for a, b, c, d in mesh.tets.tolist()]
    path.write_text('\n'.join(lines) + '\n')


@contextlib.contextmanager
def _inside(folder: Path) -> Iterator[None]:
    before = Path.cwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)
