# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The section `fixture`: a rigid part of the rig that a camera sees beside the body."""

from pathlib import Path
from typing import Any

from diffcal_ros.errors import InputError
from diffcal_ros.scene.model import Fixture
from diffcal_ros.scene.reading.section import Section
from diffcal_ros.scene.reading.selections import BOX_SHAPE, read_box
from diffcal_ros.scene.reading.shapes import Choice, Keys, Text
from diffcal_ros.scene.sections.mesh_files import UNITS_PER_METRE
from diffcal_ros.scene.sections.surface_mesh import read_closed_surface, SURFACE_SUFFIXES
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# A rig is no larger [m]; what is was written in millimetres.
_LARGEST = 3.0
FIXTURE_SHAPE = Keys(
    {
        'box': BOX_SHAPE,
        'file': Text('or instead: a closed surface, .stl, .obj or .ply, in the frame of the mesh'),
        'unit': Choice(tuple(UNITS_PER_METRE), "of the file's coordinates"),
    },
    about='a rigid part of the rig that the depth camera sees beside the body',
)

_NEEDED = 'give {box: {x: [low, high], y: .., z: ..}} in metres or {file: .., unit: ..}'


def read_fixture(scene: Section, folder: Path) -> Fixture | None:
    """Read `fixture`; None where there is none, or a mistake was noted."""
    if not scene.has('fixture'):
        return None
    section = scene.child('fixture')
    if section is None:
        return None
    if section.has('box') == section.has('file'):
        section.problems.add(section.key, f'names no single shape: {_NEEDED}')
        return None
    return _from_box(section) if section.has('box') else _from_file(section, folder)


def box_fixture(corners: FloatArray) -> Fixture:
    """Return a block between two corners of the object frame [m], shape (2, 3)."""
    import trimesh

    block: Any = trimesh.creation.box(bounds=corners)
    return Fixture(block.vertices.astype(np.float64), block.faces.astype(np.int32))


def _from_box(section: Section) -> Fixture | None:
    corners = read_box(section)
    section.refuse_unknown()
    if corners is None or not section.is_sound:
        return None
    if not np.isfinite(corners).all() or np.abs(corners).max() > _LARGEST:
        section.wrong('box', 'limit x, y and z, in metres')
        return None
    return box_fixture(corners)


def _from_file(section: Section, folder: Path) -> Fixture | None:
    path = section.path('file', folder, needed='name the surface file')
    unit = section.choice('unit')
    section.refuse_unknown()
    if not section.is_sound:
        return None
    if path.suffix.lower() not in SURFACE_SUFFIXES or not path.is_file():
        section.wrong('file', f'there must be a surface there, {", ".join(SURFACE_SUFFIXES)}')
        return None
    try:
        surface = read_closed_surface(path)
    except InputError as error:
        section.wrong('file', str(error))
        return None
    positions = np.asarray(surface.vertices, dtype=np.float64) / UNITS_PER_METRE[unit]
    if np.abs(positions).max() > _LARGEST:
        section.wrong('unit', f'in {unit} the fixture would lie metres from the body')
        return None
    triangles = np.asarray(surface.faces, dtype=np.int32)
    # A surface that was exported inside out has a negative volume.
    return Fixture(positions, triangles if surface.volume > 0.0 else triangles[:, ::-1])
