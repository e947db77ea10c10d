# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The scene that goes with a synthetic recording: started away from the truth."""

import copy
from pathlib import Path
import shutil
from typing import Any

from diffcal_ros.atomic_file import replacing
from diffcal_ros.errors import InputError
from diffcal_ros.rigid_transform import FloatArray
from diffcal_ros.scene.fit_names import RELEASE_TIME, REST_LENGTH
from diffcal_ros.scene.model import ObservationSetup, Scene
from diffcal_ros.scene.sections.modulus_field import FIELD_FILE, KEY, write_modulus_field
from diffcal_ros.synthetic.lidar import LidarModel
import yaml

_HEADER = """\
# Scene of a synthetic recording, written by `diffcal simulate` from {source}.
# The true values are in truth.json; the start values here are off by a factor {factor:g}.
"""
_OFF = ('youngs_modulus', 'density', 'damping')
_POSE, _POSE_SECTION = 'stored_depth_from_world', 'pose'
# What the recorder stores is what it filmed from.
_EXACT = {'position_std': 0.0, 'rotation_std_deg': 0.0}
_DIGITS = 9  # Nanometres.
_RELEASE_SHIFT = 0.02  # By which a release that is fitted starts too late [s].


def scene_text(
    scene: Scene,
    *,
    bags: dict[str, str],
    lidar: LidarModel,
    start_factor: float,
    poses: dict[str, FloatArray],
) -> str:
    """Write the scene file.

    Args:
        scene: as loaded from a file.
        bags: by observation, path of its recording, relative to the new scene.
        lidar: how depth was measured.
        start_factor: by which fitted moduli and densities start too high, or too low where the
            bounds leave no room above.
        poses: by observation, `depth_from_world`, shape (4, 4), where it is to be stored.

    Raises:
        InputError: when the bounds leave no room for the factor.
    """
    document = copy.deepcopy(scene.document)
    document['mesh']['file'] = Path(str(document['mesh']['file'])).name
    if scene.relative_modulus is not None:
        document[KEY] = {'file': FIELD_FILE}
        if document['mesh']['file'] == FIELD_FILE:
            document['mesh']['unit'] = 'm'
    document.pop('fixture', None)  # The body alone is rendered.
    _set_sensor(document, lidar)
    for name in _names_off(scene):
        _move_start(document, scene, name, start_factor)
    _pull_less(document, scene, start_factor)
    if any(name.partition('.')[0] == RELEASE_TIME for name in scene.fit):
        _move_releases(document, scene)
    owners = document.get('observations') or [document]
    for owner in (document, *owners):
        for key in ('bag', _POSE, _POSE_SECTION):
            owner.pop(key, None)
    for owner, setup in zip(owners, scene.observations, strict=True):
        owner['bag'] = bags[setup.name]
        if setup.name in poses:
            owner[_POSE] = _placement(poses[setup.name])
            owner[_POSE_SECTION] = {**_source(setup), **_EXACT}
    source = scene.path.name if scene.path else scene.name
    body = yaml.safe_dump(document, sort_keys=False, default_flow_style=None, width=99)
    return _HEADER.format(source=source, factor=start_factor) + body


def write_files(scene: Scene, out: Path) -> None:
    """Write the files that the scene of `scene_text` names beside it.

    Raises:
        InputError: when one cannot be written.
    """
    mesh = scene.file_of('mesh')
    assert mesh is not None
    with replacing(out / mesh.name) as fresh:
        shutil.copyfile(mesh, fresh)
    if scene.relative_modulus is not None:
        write_modulus_field(out / FIELD_FILE, scene.mesh, scene.relative_modulus)


def _names_off(scene: Scene) -> list[str]:
    """List the constants of regions that a fit is to find, as `youngs_modulus.body`."""
    names = []
    for name in scene.fit:
        head, _, region = name.partition('.')
        if head in _OFF:
            chosen = [region] if region else [region.name for region in scene.regions]
            names += [f'{head}.{own}' for own in chosen]
    return names


def _move_start(document: dict[str, Any], scene: Scene, name: str, factor: float) -> None:
    key, _, region_name = name.partition('.')
    region = next(region for region in scene.regions if region.name == region_name)
    quantity = getattr(region, key)
    tried = [quantity.start * factor, quantity.start / factor]
    inside = [value for value in tried if quantity.lower <= value <= quantity.upper]
    if not inside:
        raise InputError(
            f'the start factor is {factor:g}, but the bounds of {name}, {quantity.lower:g} to '
            f'{quantity.upper:g}, leave no room for it around {quantity.start:g}: use a smaller '
            'factor or widen the bounds'
        )
    section = document['regions'][region_name]
    if isinstance(section[key], dict):
        section[key]['start'] = float(f'{inside[0]:.6g}')
    else:
        section[key] = float(f'{inside[0]:.6g}')


def _pull_less(document: dict[str, Any], scene: Scene, factor: float) -> None:
    """Start fitted cables as if they were shortened less, by the factor."""
    for cable in scene.cables:
        asked = {REST_LENGTH, f'{REST_LENGTH}.{cable.name}'} & set(scene.fit)
        if not asked:
            continue
        start = cable.length - (cable.length - cable.rest_length.start) / factor
        start = min(max(start, cable.rest_length.lower), cable.rest_length.upper)
        section = document['cables'][cable.name]
        section.pop('pull', None)
        if isinstance(section.get(REST_LENGTH), dict):
            section[REST_LENGTH]['start'] = float(f'{start:.6g}')
        else:
            section[REST_LENGTH] = float(f'{start:.6g}')


def _move_releases(document: dict[str, Any], scene: Scene) -> None:
    """Start each time of release too late, or too early where the bounds leave no room."""
    owners = document.get('observations') or [document]
    moved: list[int] = []
    for owner, setup in zip(owners, scene.observations, strict=True):
        if setup.motion is None:
            continue
        section = owner['motion'] if 'motion' in owner else document['motion']
        if id(section) in moved:
            continue
        moved.append(id(section))
        quantity = setup.motion.release_time
        fits = quantity.start + _RELEASE_SHIFT <= quantity.upper
        start = quantity.start + (_RELEASE_SHIFT if fits else -_RELEASE_SHIFT)
        start = round(max(start, quantity.lower), 6)
        if isinstance(section['at'], dict):
            section['at']['start'] = start
        else:
            section['at'] = start


def _source(setup: ObservationSetup) -> dict[str, Any]:
    """Say that the pose is stored where the scene has it from elsewhere than a marker."""
    return {'source': 'stored'} if setup.pose.source not in ('', 'marker') else {}


def _set_sensor(document: dict[str, Any], lidar: LidarModel) -> None:
    is_cut = lidar.encoding == '16UC1'
    document['sensor'] = {
        'noise': max(lidar.noise, 1e-6),
        'quantization': 0.001 if is_cut else lidar.step,
        'quantization_mode': 'truncate' if is_cut else 'round',
    }


def _placement(matrix: FloatArray) -> dict[str, Any]:
    # Adding zero turns -0.0 into 0.0.
    rows = [[round(float(value), _DIGITS) + 0.0 for value in row] for row in matrix[:3]]
    return {
        'translation': [row[3] for row in rows],
        'rotation_matrix': [row[:3] for row in rows],
    }
