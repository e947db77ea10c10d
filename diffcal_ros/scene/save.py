# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Write a scene again with fitted values in place of the start values."""

from collections.abc import Mapping
import os
from pathlib import Path
from typing import Any

from diffcal_ros.atomic_file import write_text_atomically
from diffcal_ros.scene.fitted_values import with_values
from diffcal_ros.scene.model import Scene
from diffcal_ros.scene.sections.modulus_field import FIELD_FILE, KEY, write_modulus_field
from diffcal_ros.scene.sections.surface_mesh import SURFACE_SUFFIXES
import yaml

_HEADER = """\
# Scene with fitted values, written by diffcal from {source}.
# Fitted: {fitted}.
# Everything else is as it was there; comments are not copied, paths are made to fit this folder.
"""


def save_fitted_scene(
    scene: Scene, path: str | os.PathLike[str], values: Mapping[str, float]
) -> None:
    """Write the scene's document with start values replaced, completely or not at all.

    A modulus that varies over the body is written beside it first, as `field.vtu`.

    Args:
        scene: as `load_scene` gave it.
        path: where to write; its folder is made when it is missing.
        values: fitted values by name, `youngs_modulus.body` for one region and
            `youngs_modulus` for all of them; see `with_values`.

    Raises:
        ValueError: for a name that has no place in the scene, or a scene that was not read from
            a file.
        InputError: when the file cannot be written.
    """
    if scene.path is None or not scene.document:
        raise ValueError('the scene was built in memory: only one read from a file is written')
    target = Path(path)
    document = with_values(scene, values)
    _move_paths(document, scene.path.resolve().parent, target.resolve().parent)
    _put_field(document, scene, target)
    header = _HEADER.format(
        source=scene.path.name,
        fitted=', '.join(f'{name} = {value:.6g}' for name, value in values.items()) or 'nothing',
    )
    body = yaml.safe_dump(document, sort_keys=False, default_flow_style=None, width=99)
    write_text_atomically(target, header + body)


def _put_field(document: dict[str, Any], scene: Scene, target: Path) -> None:
    if scene.relative_modulus is None:
        return
    write_modulus_field(target.with_name(FIELD_FILE), scene.mesh, scene.relative_modulus)
    document[KEY] = {'file': FIELD_FILE}
    mesh = document['mesh']
    is_cut = Path(str(mesh['file'])).suffix.lower() in SURFACE_SUFFIXES
    if is_cut or mesh['file'] == FIELD_FILE:
        # Cut again, a surface may give other tetrahedra: those of the field are the mesh now.
        mesh.pop('edge_length', None)
        mesh.update(file=FIELD_FILE, unit='m')


def _move_paths(document: dict[str, Any], old_folder: Path, new_folder: Path) -> None:
    """Make relative paths of the document right for another folder."""
    owners = [(document['mesh'], 'file'), (document, 'bag')]
    owners.append((document.get('fixture') or {}, 'file'))
    owners += [(observation, 'bag') for observation in document.get('observations') or []]
    for owner, key in owners:
        if owner.get(key) is None:
            continue
        given = Path(str(owner[key])).expanduser()
        if not given.is_absolute():
            owner[key] = _relative(old_folder / given, new_folder)


def _relative(file: Path, folder: Path) -> str:
    try:
        return Path(os.path.relpath(file, folder)).as_posix()
    except ValueError:  # Another drive: there is no relative path.
        return str(file)
