# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""One experiment: what is filmed, how it is fitted, where fits start, what the paper found."""

from collections.abc import Mapping, Sequence
import copy
from dataclasses import dataclass, field
import os
from pathlib import Path
from typing import Any

from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.errors import SceneError
from diffcal_ros.scene.reading.yaml_document import read_yaml
from diffcal_ros.user_path import user_path

ROWS = Path(__file__).parent / 'rows'
_ROW_KEYS = {'title', 'question', 'variants', 'finding'}
_SETTINGS = ('loss', 'optimizer', 'max_iterations')
_VARIANT_KEYS = {
    'name',
    'title',
    'case',
    'scene_file',
    'mesh',
    'simulate',
    'scene',
    'pose',
    'pixel_step',
    'modulus_field',
    'start',
    'starts',
    'paper',
    'members',
    'shared',
    *_SETTINGS,
}
_SOURCES = ('case', 'scene_file', 'members')
_POSES = ('estimated', 'stored')


@dataclass(frozen=True)
class Variant:
    """One way of doing an experiment; a row has at least one.

    Attributes:
        name: of its folder.
        title: for people.
        case: of the public data set, or None.
        scene_file: a scene instead of a case, or None.
        mesh: folder of the data set with the mesh that is fitted, in place of the case's own.
        simulate: how a synthetic recording is made; None where the case's own frames are used.
        scene: what replaces keys of the scene, as nested mappings.
        settings: how to fit.
        pose: of the camera, `estimated` or `stored`.
        pixel_step: only one row and column in as many of the depth image are used.
        modulus_field: fit a modulus that varies over the body beside the other parameters.
        start: range that starts are drawn from, by the parameter's name, or the part before its
            first dot; moduli, densities and damping evenly in their logarithms.
        starts: how many are enough; None: as many as are asked for.
        paper: the paper's figures by the names of ours.
        members: bodies that are fitted together, each with a case of its own.
        shared: for each parameter that they have in common, what it is called in which member.
    """

    name: str
    title: str
    case: str | None = None
    scene_file: Path | None = None
    mesh: str | None = None
    simulate: Mapping[str, Any] | None = None
    scene: Mapping[str, Any] = field(default_factory=dict)
    settings: CalibrationSettings = field(default_factory=CalibrationSettings)
    pose: str = 'estimated'
    pixel_step: int = 1
    modulus_field: bool = False
    start: Mapping[str, Sequence[float]] = field(default_factory=dict)
    starts: int | None = None
    paper: Mapping[str, Any] = field(default_factory=dict)
    members: tuple['Variant', ...] = ()
    shared: Mapping[str, Mapping[str, str]] = field(default_factory=dict)


@dataclass(frozen=True)
class Row:
    """One experiment.

    Attributes:
        name: of its file and folder.
        title: for people.
        question: what it is done for.
        finding: what is known about it that its numbers do not say.
        variants: ways of doing it, the main one first.
    """

    name: str
    title: str
    question: str
    finding: str
    variants: tuple[Variant, ...]


def row_names(folder: Path = ROWS) -> list[str]:
    """List the experiments."""
    return sorted(path.stem for path in folder.glob('*.yaml'))


def load_row(name: str, folder: Path = ROWS) -> Row:
    """Read an experiment by its name, or from the path of a YAML file.

    Raises:
        SceneError: when there is none, or it has a key that is not known.
    """
    path = user_path(name) if name.endswith(('.yaml', '.yml')) else folder / f'{name}.yaml'
    if not os.path.isfile(path):  # `Path.is_file` raises for names that are too long.
        known = ', '.join(row_names(folder))
        raise SceneError(f'there is no experiment {name!r}: use all, a YAML file, or {known}')
    content = read_yaml(path).content
    shared = {key: value for key, value in content.items() if key not in _ROW_KEYS}
    variants = content.get('variants') or [{'name': 'fit', 'title': 'fit'}]
    return Row(
        name=path.stem,
        title=str(content.get('title', path.stem)),
        question=str(content.get('question', '')),
        finding=str(content.get('finding', '')),
        variants=tuple(_variant(path, merged(shared, own)) for own in variants),
    )


def merged(base: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return nested mappings with some keys replaced; a null removes a key."""
    result = copy.deepcopy(dict(base))
    for key, value in changes.items():
        if value is None:
            result.pop(key, None)
        elif isinstance(value, Mapping) and isinstance(result.get(key), Mapping):
            result[key] = merged(result[key], value)
        else:
            result[key] = copy.deepcopy(value)
    return result


def _variant(path: Path, content: dict[str, Any]) -> Variant:
    unknown = sorted(set(content) - _VARIANT_KEYS)
    if unknown:
        known = ', '.join(sorted(_VARIANT_KEYS))
        raise SceneError(f'{path} has {unknown[0]!r}, which is not known: use {known}')
    if sum(key in content for key in _SOURCES) != 1:
        raise SceneError(
            f'{path} needs a `case` of the public data set, a `scene_file`, or `members`, one of '
            'them'
        )
    if 'scene_file' in content and 'simulate' not in content:
        raise SceneError(f'{path} has a `scene_file` but nothing was filmed: add `simulate`')
    if content.get('pose', _POSES[0]) not in _POSES:
        raise SceneError(f'{path}: pose is {content["pose"]!r}: use {" or ".join(_POSES)}')
    if not isinstance(content.get('modulus_field', False), bool):
        raise SceneError(
            f'{path}: modulus_field is {content["modulus_field"]!r}: use true or false'
        )
    given = {key: content[key] for key in _VARIANT_KEYS & set(content) - set(_SETTINGS)}
    if 'scene_file' in given:
        given['scene_file'] = path.parent / str(given['scene_file'])
    given['members'] = tuple(
        _variant(path, {'name': member, **own})
        for member, own in content.get('members', {}).items()
    )
    name = str(given.setdefault('name', 'fit'))
    given.setdefault('title', name)
    settings = {key: content[key] for key in _SETTINGS if key in content}
    return Variant(**{**given, 'settings': CalibrationSettings(**settings)})
