# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The section `fixture`: a rigid part of the rig that a camera sees beside the body."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from diffcal_ros.errors import InputError
from diffcal_ros.scene.model import Fixture
from diffcal_ros.scene.reading.section import Section
from diffcal_ros.scene.reading.selections import box_corners, BOX_SHAPE, read_box
from diffcal_ros.scene.reading.shapes import Choice, Keys, ListOf, Text
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
        'boxes': ListOf(BOX_SHAPE, 'or instead: blocks that move together, as of two clamps', 1),
        'file': Text('or instead: a closed surface, .stl, .obj or .ply, in the frame of the mesh'),
        'unit': Choice(tuple(UNITS_PER_METRE), "of the file's coordinates"),
    },
    about='a rigid part of the rig that the depth camera sees beside the body',
)

_NEEDED = (
    'give {box: {x: [low, high], y: .., z: ..}} in metres, {boxes: [{x: ..}, {x: ..}]} or '
    '{file: .., unit: ..}'
)
_EACH = 'give a list, `- {x: [low, high], y: .., z: ..}` each'


def read_fixture(scene: Section, folder: Path) -> Fixture | None:
    """Read `fixture`; None where there is none, or a mistake was noted."""
    if not scene.has('fixture'):
        return None
    section = scene.child('fixture')
    if section is None:
        return None
    if sum(map(section.has, ('box', 'boxes', 'file'))) != 1:
        section.problems.add(section.key, f'names no single shape: {_NEEDED}')
        return None
    if section.has('file'):
        return _from_file(section, folder)
    return _from_boxes(section)


def blocks_fixture(corners: Sequence[FloatArray]) -> Fixture:
    """Return blocks, each between two corners of the object frame [m], shape (2, 3) each."""
    import trimesh

    blocks: Any = trimesh.util.concatenate([trimesh.creation.box(bounds=own) for own in corners])
    return Fixture(blocks.vertices.astype(np.float64), blocks.faces.astype(np.int32))


def _from_boxes(section: Section) -> Fixture | None:
    """Read the one block of `box`, or all of `boxes`."""
    name = 'box' if section.has('box') else 'boxes'
    found = [read_box(section)] if name == 'box' else _each_box(section)
    section.refuse_unknown()
    corners = [own for own in found if own is not None]
    if len(corners) < len(found) or not corners or not section.is_sound:
        return None
    if not np.isfinite(corners).all() or np.abs(corners).max() > _LARGEST:
        section.wrong(name, 'limit x, y and z, in metres')
        return None
    return blocks_fixture(corners)


def _each_box(section: Section) -> list[FloatArray | None]:
    items = section.raw('boxes')
    if not isinstance(items, list) or not items:
        section.wrong('boxes', _EACH)
        return []
    found = list[FloatArray | None]()
    for number, item in enumerate(items):
        key = f'{section.at("boxes")}[{number}]'
        if isinstance(item, dict):
            found.append(box_corners(Section(item, key, section.problems, BOX_SHAPE)))
        else:
            section.problems.add(key, f'is no mapping: {_EACH}')
            found.append(None)
    return found


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
