# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Add what a diagnosis found to the model, on explicit request, and take it out again."""

from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime, timezone
import json
from pathlib import Path
from typing import Any

from diffcal_ros.effects.registry import EFFECTS, what_settles
from diffcal_ros.errors import InputError
from diffcal_ros.scene.model_file import (
    effects_in_force,
    ModelVersion,
    read_versions,
    write_versions,
)
from diffcal_ros.user_path import require_plain_file

VERDICT_FILE = 'verdict.json'
_MOST_BYTES = 100_000_000


def accept(folder: Path, identifiers: Sequence[str] = ()) -> tuple[Path, tuple[str, ...]]:
    """Add the effects of a verdict to the model file of its scene.

    Args:
        folder: of the diagnosis.
        identifiers: which of the effects named or left open; default: all that were named.

    Returns:
        The model file, and the effects that were added.

    Raises:
        InputError: when there is no verdict, nothing to accept, an effect that is another one in
            each frame, or the effect is there already.
    """
    verdict = _read(folder)
    scene = Path(str(verdict['details']['scene']))
    found = {entry['identifier']: entry for entry in verdict['details']['candidates']}
    named = [entry['identifier'] for entry in verdict['effects']]
    wanted = list(identifiers) or named
    if not wanted:
        raise InputError(_nothing(folder, verdict))
    missing = [name for name in wanted if name not in found]
    if missing:
        known = ', '.join(found) or 'none'
        raise InputError(
            f'{folder / VERDICT_FILE} has no amplitude of {missing[0]!r}: it has {known}'
        )
    changing = [name for name in wanted if found[name].get('course')]
    if changing:
        raise InputError(
            f'{changing[0]} is another one in each frame of that recording, and a scene has one '
            f'for all: mend what is filmed, and record again ({what_settles(changing[:1])} tells '
            'whether it is gone)'
        )
    versions = read_versions(scene)
    there = [name for name in wanted if name in effects_in_force(versions)]
    if there:
        raise InputError(f'{there[0]} is in the model already: take it out with `diffcal revert`')
    now = datetime.now(timezone.utc).isoformat(timespec='seconds')
    for name in wanted:
        versions.append(_version(len(versions) + 1, found[name], verdict, now))
    return write_versions(scene, versions), tuple(wanted)


def revert(scene: Path) -> tuple[Path, str]:
    """Take the last effect out of a scene's model; return the model file and the effect.

    Raises:
        InputError: when there is none.
    """
    versions = read_versions(scene)
    standing = [index for index, version in enumerate(versions) if not version.is_reverted]
    if not standing:
        raise InputError(f'the model of {scene} holds no effect that could be taken out')
    last = standing[-1]
    versions[last] = replace(versions[last], is_reverted=True)
    return write_versions(scene, versions), versions[last].effect


def scene_of(folder: Path) -> Path:
    """Return the scene that a diagnosis was about.

    Raises:
        InputError: when there is no verdict.
    """
    return Path(str(_read(folder)['details']['scene']))


def _read(folder: Path) -> dict[str, Any]:
    path = folder / VERDICT_FILE
    try:
        require_plain_file(path, _MOST_BYTES)
        verdict: dict[str, Any] = json.loads(path.read_text(encoding='utf-8'))
        if not isinstance(verdict['details'], dict):
            raise ValueError('details is no mapping')
        return verdict
    except FileNotFoundError as error:
        raise InputError(
            f'there is no {path}: run `diffcal diagnose ... --out {folder}` first'
        ) from error
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise InputError(
            f'{path} cannot be read ({error}): run `diffcal diagnose ... --out {folder}` first'
        ) from error


def _nothing(folder: Path, verdict: dict[str, Any]) -> str:
    alike = verdict.get('ambiguity_set') or []
    if len(alike) == 1:
        return (
            f'{folder} is not sure of {alike[0]}: take it with --effect {alike[0]}, or record '
            f'what would settle it ({verdict.get("separating_recording")})'
        )
    if alike:
        return (
            f'{folder} names no single effect: choose one of {", ".join(alike)} with --effect, or '
            f'record what would tell them apart ({verdict.get("separating_recording")})'
        )
    return f'{folder} found no effect to accept: the verdict is {verdict["verdict"]}'


def _version(
    number: int, entry: dict[str, Any], verdict: dict[str, Any], now: str
) -> ModelVersion:
    effect = EFFECTS[entry['identifier']]
    factors = {part.name: part.shown_factor for part in effect.components}
    amplitudes = {name: value / factors[name] for name, value in entry['amplitude'].items()}
    return ModelVersion(
        number=number,
        effect=effect.identifier,
        amplitudes={**amplitudes, **entry['setting'], **entry.get('form', {})},
        std_errors={name: value / factors[name] for name, value in entry['std_error'].items()},
        verdict=str(verdict['verdict']),
        evidence=str(verdict['evidence']),
        confidence=float(entry['confidence']),
        data=list(verdict['details'].get('recordings', [])),
        accepted=now,
    )
