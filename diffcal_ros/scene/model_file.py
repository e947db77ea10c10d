# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The model file beside a scene: effects that were accepted, version by version.

`scene.yaml` is the user's and stays as it is; `scene.model.yaml` holds what a diagnosis added to
its model. Versions are never deleted: one that was taken out again is marked so.
"""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from diffcal_ros.atomic_file import write_text_atomically
from diffcal_ros.effects.registry import EFFECTS
from diffcal_ros.errors import SceneError
import yaml

_FORMAT = 1
_HEADER = (
    '# Effects that were added to the model of {scene}, written by `diffcal accept`.\n'
    '# `diffcal revert` takes the last one out again. Amplitudes are in SI units.\n'
)


@dataclass(frozen=True)
class ModelVersion:
    """One effect that was accepted.

    Attributes:
        number: 1 for the first.
        effect: identifier.
        amplitudes: and settings, SI units, by name.
        std_errors: of the amplitudes, SI units.
        verdict: what the diagnosis said.
        evidence: confirmed or suspected.
        confidence: of the name.
        data: recordings that it rests on: name and sha256 of each.
        accepted: when, ISO 8601, UTC.
        is_reverted: whether it was taken out again.
    """

    number: int
    effect: str
    amplitudes: dict[str, float]
    std_errors: dict[str, float]
    verdict: str
    evidence: str
    confidence: float
    data: list[dict[str, str]]
    accepted: str
    is_reverted: bool = False


def model_path(scene: Path) -> Path:
    """Return where the model file of a scene is."""
    return scene.with_name(f'{scene.stem}.model.yaml')


def read_versions(scene: Path) -> list[ModelVersion]:
    """Read the model file of a scene; empty where there is none.

    Raises:
        SceneError: when it is not what `diffcal accept` writes.
    """
    path = model_path(scene)
    if not path.is_file():
        return []
    try:
        content = yaml.safe_load(path.read_text(encoding='utf-8'))
        if content['format'] != _FORMAT:
            raise ValueError(f'format is {content["format"]!r}')
        versions = [ModelVersion(**entry) for entry in content['versions']]
        unknown = [version.effect for version in versions if version.effect not in EFFECTS]
        if unknown:
            raise ValueError(f'effect is {unknown[0]!r}')
    except (OSError, yaml.YAMLError, LookupError, TypeError, ValueError, RecursionError) as error:
        raise SceneError(
            f'{path} cannot be used ({error}): restore it, or remove it to use the scene alone'
        ) from error
    return versions


def write_versions(scene: Path, versions: list[ModelVersion]) -> Path:
    """Write the model file, completely or not at all; return where.

    Raises:
        InputError: when it cannot be written.
    """
    path = model_path(scene)
    content: dict[str, Any] = {
        'format': _FORMAT,
        'scene': scene.name,
        'versions': [asdict(version) for version in versions],
    }
    body = yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=99)
    write_text_atomically(path, _HEADER.format(scene=scene.name) + body)
    return path


def effects_in_force(versions: list[ModelVersion]) -> dict[str, dict[str, float]]:
    """Return the effects that count, the last version of each; SI units."""
    return {
        version.effect: dict(version.amplitudes) for version in versions if not version.is_reverted
    }


def fit_names_in_force(versions: list[ModelVersion]) -> tuple[str, ...]:
    """Return what a fit must free so that errors of the effects are part of every answer."""
    names: list[str] = []
    for version in versions:
        if not version.is_reverted:
            names += EFFECTS[version.effect].fit_names(tuple(version.std_errors))
    return tuple(dict.fromkeys(names))
