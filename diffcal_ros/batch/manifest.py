# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is to be done: bodies, their scenes and recordings, and the material of each."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
import os
from pathlib import Path
import re
import shlex
from typing import Any

from diffcal_ros.batch.manifest_table import read_manifest_table
from diffcal_ros.errors import InputError
from diffcal_ros.scene.reading.problems import Problems
from diffcal_ros.scene.reading.section import Section
from diffcal_ros.scene.reading.shapes import Choice, Constant, Keys, ListOf, OneOf, Shape, Text
from diffcal_ros.scene.reading.yaml_document import read_yaml, YamlDocument
from diffcal_ros.user_path import user_path

FORMAT = 1
COMMANDS = ('calibrate', 'diagnose')
# Names of bodies become names of folders, on every system.
_NAME = re.compile(r'[A-Za-z0-9][A-Za-z0-9._-]{0,79}')
_NAMING = 'use up to 80 letters, digits, dots, hyphens and underscores, the first no dot or hyphen'
_OPTIONS = 'as on the command line, such as --fit youngs_modulus --no-search'
_SHARED: dict[str, Shape] = {
    'scene': Text('scene file, relative to this one'),
    'material': OneOf(
        (Text(), Keys(named=Text())), 'name of the material, or one for each region of the scene'
    ),
    'options': Text(_OPTIONS),
}
_BODY_SHAPE = Keys(
    {
        'body': Text('its name, and that of its folder of results'),
        'recordings': ListOf(Text(), 'bags, relative to this file; default: those of the scene'),
        **_SHARED,
    },
    ('body',),
)
MANIFEST_SHAPE = Keys(
    {
        'format': Constant(FORMAT),
        'command': Choice(COMMANDS),
        **_SHARED,
        'bodies': ListOf(_BODY_SHAPE, fewest=1),
    },
    ('format', 'bodies'),
)
# Says what is wrong with the options of a body's command, or nothing.
CheckArguments = Callable[['Body'], str]


@dataclass(frozen=True)
class Body:
    """One body, and what is done with it.

    Attributes:
        name: of the body.
        command: `calibrate` or `diagnose`.
        scene: its file.
        recordings: paths; none: those that the scene names.
        material: name of its material, by region; under the empty name that of every region.
        options: more arguments of the command.
    """

    name: str
    command: str
    scene: Path
    recordings: tuple[Path, ...]
    material: Mapping[str, str]
    options: tuple[str, ...]

    def arguments(self) -> list[str]:
        """Return what stands after `diffcal` to do this alone, but for `--out` and a folder."""
        # Side by side are the bodies already.
        alone = ['--jobs', '1'] if self.command == 'diagnose' else []
        recordings = map(str, self.recordings)
        return [self.command, *recordings, '--scene', str(self.scene), *alone, *self.options]


def load_manifest(path: Path, check: CheckArguments) -> tuple[Body, ...]:
    """Read a manifest, in YAML or, where its name ends so, as a table in CSV.

    Args:
        path: the file; paths in it are relative to its folder.
        check: see `CheckArguments`.

    Raises:
        SceneError: naming the file and, line by line, everything that is wrong.
    """
    is_table = path.suffix.lower() == '.csv'
    document = read_manifest_table(path) if is_table else read_yaml(path, 'manifest')
    problems = Problems(str(path), document.lines)
    root = Section(document.content, '', problems, MANIFEST_SHAPE)
    folder = Path(os.path.abspath(path.parent))
    bodies = _read(root, document, folder, check)
    root.refuse_unknown()
    problems.raise_if_any()
    return bodies


def _read(
    root: Section, document: YamlDocument, folder: Path, check: CheckArguments
) -> tuple[Body, ...]:
    if root.raw('format') != FORMAT or isinstance(root.raw('format'), bool):
        root.wrong('format', f'write `format: {FORMAT}`')
        root.problems.raise_if_any()
    command = root.choice('command', default=COMMANDS[0])
    for key in ('scene', 'material', 'options'):
        root.has(key)
    items = root.raw('bodies')
    if not isinstance(items, list) or not items:
        root.wrong('bodies', 'give a list, `- body: ..` each')
        return ()
    bodies: list[Body] = []
    places: dict[str, int] = {}
    for index, item in enumerate(items):
        key = f'bodies[{index}]'
        if not isinstance(item, dict):
            root.problems.add(key, 'is no mapping: start it with `body: ..`')
            continue
        section = Section(item, key, root.problems, _BODY_SHAPE)
        body = _read_body(section, root, folder, command)
        # What differs in case alone is one folder on some systems.
        other = places.setdefault(body.name.lower(), index)
        if other != index:
            line = document.lines.get(f'bodies[{other}]')
            section.wrong('body', f'line {line} has a body of that name: choose another')
        fault = check(body) if section.is_sound else ''
        if fault:
            root.problems.add(section.at('options'), fault)
        bodies.append(body)
    return tuple(bodies)


def _read_body(section: Section, root: Section, folder: Path, command: str) -> Body:
    name = section.text('body', needed='give each body a name')
    if name and not _NAME.fullmatch(name):
        section.wrong('body', _NAMING)
    owner = section if section.has('scene') else root
    scene = folder / 'scene.yaml'
    if owner is root and not root.has('scene'):
        section.required('scene', 'name the scene file, here or for all bodies')
    else:
        scene = owner.path('scene', folder, needed='name the scene file')
        if not os.path.isfile(scene):
            owner.wrong('scene', f'there is no file {scene}')
    recordings = tuple(_read_recordings(section, folder))
    material = _read_material(section if section.has('material') else root)
    options = (*_read_options(root), *_read_options(section))
    section.refuse_unknown()
    return Body(name, command, scene, recordings, material, options)


def _read_recordings(section: Section, folder: Path) -> list[Path]:
    if not section.has('recordings'):
        return []
    value = section.raw('recordings')
    if not isinstance(value, list) or not all(isinstance(item, str) and item for item in value):
        section.wrong('recordings', 'give a list of paths')
        return []
    paths = []
    for index, item in enumerate(value):
        try:
            path = folder / user_path(item)
        except InputError as error:
            section.problems.add(f'{section.at("recordings")}[{index}]', f'is no path: {error}')
            continue
        if not os.path.exists(path):
            section.problems.add(
                f'{section.at("recordings")}[{index}]',
                f'is {item!r}: there is no {path}, check the path',
            )
        paths.append(path)
    return paths


def _read_material(owner: Section) -> dict[str, str]:
    value: Any = owner.raw('material')
    if value is None:
        return {}
    if isinstance(value, str) and value:
        return {'': value}
    if isinstance(value, dict) and all(
        isinstance(part, str) and part for pair in value.items() for part in pair
    ):
        return dict(value)
    owner.wrong('material', 'give the name of a material, or {region: name, ..}')
    return {}


def _read_options(owner: Section) -> tuple[str, ...]:
    text = owner.text('options', default='', needed=f'write them {_OPTIONS}')
    try:
        return tuple(shlex.split(text))
    except ValueError as error:
        owner.wrong('options', f'{error}: write them {_OPTIONS}')
        return ()
