# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where in a scene's document each fitted value stands."""

from collections.abc import Mapping
import copy
from typing import Any

from diffcal_ros.effects.registry import effects_by_fit_name
from diffcal_ros.scene.fit_names import (
    CABLE_NAMES,
    MATERIAL_NAMES,
    RELEASE_TIME,
    REST_LENGTH,
)
from diffcal_ros.scene.model import Scene


def with_values(scene: Scene, values: Mapping[str, float]) -> dict[str, Any]:
    """Return the scene's document with fitted values in place of start values.

    Effects that were accepted for the scene become part of the document. One that is of a
    recording, as the camera's offset, is left out unless the scene states it.

    Args:
        scene: as read from a file.
        values: by name, as a fit names its parameters.

    Raises:
        ValueError: for a name that no scene has a place for.
    """
    document = copy.deepcopy(scene.document)
    if scene.effects:
        document['effects'] = copy.deepcopy(scene.effects)
    if 'fit' in document or scene.effects:
        document['fit'] = list(scene.fit)
    effects = effects_by_fit_name()
    for name, value in values.items():
        key, _, part = name.partition('.')
        if key == RELEASE_TIME:
            _put_release(document, scene, part, float(value))
        elif key in CABLE_NAMES:
            _put_cable(document, scene, name, float(value))
        elif key in effects and part:
            own = effects[key]
            if not own.is_of_recording or own.identifier in scene.effects:
                stated = document.setdefault('effects', {}).setdefault(own.identifier, {})
                stated[part] = float(value)
        else:
            _put_material(document, scene, name, float(value))
    return document


def _put_material(document: dict[str, Any], scene: Scene, name: str, value: float) -> None:
    key, _, region = name.partition('.')
    regions = [region.name for region in scene.regions]
    if key not in MATERIAL_NAMES or (region and region not in regions):
        raise ValueError(
            f'{name} is no material number of the scene: give {", ".join(MATERIAL_NAMES)}, '
            f'each with one of {", ".join(regions)} after a dot, or for all regions without'
        )
    for owner in [region] if region else regions:
        _put(document['regions'][owner], key, value)


def _put_cable(document: dict[str, Any], scene: Scene, name: str, value: float) -> None:
    key, _, cable = name.partition('.')
    cables = [cable.name for cable in scene.cables]
    if not cables or (cable and cable not in cables):
        raise ValueError(
            f'{name} is of no cable of the scene: its cables are {", ".join(cables) or "none"}'
        )
    key = key if key == REST_LENGTH else 'stiffness'
    for owner in [cable] if cable else cables:
        section = document['cables'][owner]
        section.setdefault(key, value)
        _put(section, key, value)
        if key == REST_LENGTH:
            section.pop('pull', None)


def _put_release(document: dict[str, Any], scene: Scene, name: str, value: float) -> None:
    """Set when the support of one observation lets go; without a name, of all that move."""
    owners = document.get('observations') or [document]
    for owner, setup in zip(owners, scene.observations, strict=True):
        if setup.motion is None or name not in ('', setup.name):
            continue
        # One that shares the scene's motion gets a copy of its own.
        section = owner.setdefault('motion', copy.deepcopy(document.get('motion')))
        _put(section, 'at', value)


def _put(section: dict[str, Any], key: str, value: float) -> None:
    if isinstance(section[key], dict):
        section[key]['start'] = value
    else:
        section[key] = value
