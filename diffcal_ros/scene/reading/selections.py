# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Parts of a mesh by box or by list."""

from dataclasses import dataclass
import math

from diffcal_ros.scene.reading.problems import shown
from diffcal_ros.scene.reading.section import as_number, Section, whole_numbers
from diffcal_ros.scene.reading.shapes import Keys, ListOf, Number, Shape, Whole
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]

# A face of the box that runs through mesh vertices takes them along: mesh files of single
# precision are off by 1e-7 of the body's size.
_FACE_TOLERANCE = 1e-6

_LIMITS = ListOf(Number(), '[low, high] in m; .inf and -.inf: no limit', fewest=2, most=2)
BOX_SHAPE = Keys(
    dict.fromkeys('xyz', _LIMITS), about='object frame; an axis left out has no limit', fewest=1
)


def selection_shape(list_name: str) -> dict[str, Shape]:
    """Return what selects a part of the mesh: a box or a list."""
    listed = ListOf(Whole(low=0), 'instead of a box, counted from 0', fewest=1)
    return {'box': BOX_SHAPE, list_name: listed}


@dataclass(frozen=True)
class Selection:
    """A choice of vertices or tetrahedra; exactly one of `box` and `indices` is given.

    Attributes:
        section: where it stands, for messages.
        box: lower and upper corner in the object frame [m], shape (2, 3).
        indices: vertices or tetrahedra.
    """

    section: Section
    box: FloatArray | None = None
    indices: tuple[int, ...] = ()


def read_selection(section: Section, list_name: str) -> Selection | None:
    """Read `box` or the list of indices; None when neither is given or it is wrong."""
    has_box, has_list = section.has('box'), section.has(list_name)
    if has_box and has_list:
        section.problems.add(section.key, f'has box and {list_name}: keep one of the two')
        return None
    if has_box:
        box = read_box(section)
        return None if box is None else Selection(section, box=box)
    if has_list:
        indices = _read_indices(section, list_name)
        return None if indices is None else Selection(section, indices=indices)
    return None


def select_vertices(selection: Selection, mesh: TetMesh) -> IntArray:
    """Return the mesh vertices of a selection; the faces of a box belong to it."""
    if selection.box is None:
        return _listed(selection, 'vertices', mesh.vertex_count)
    slack = _FACE_TOLERANCE * float((mesh.extent[1] - mesh.extent[0]).max())
    low, high = selection.box[0] - slack, selection.box[1] + slack
    inside = (mesh.rest_positions >= low) & (mesh.rest_positions <= high)
    return _found(selection, inside, 'vertex', mesh)


def select_tets(selection: Selection, mesh: TetMesh) -> IntArray:
    """Return the tetrahedra whose centroids lie in a box, or the listed ones.

    A box's lower faces belong to it and its upper ones do not, so that boxes which share a
    face share no tetrahedron.
    """
    if selection.box is None:
        return _listed(selection, 'tets', mesh.tet_count)
    inside = (mesh.centroids >= selection.box[0]) & (mesh.centroids < selection.box[1])
    return _found(selection, inside, "tetrahedron's centroid", mesh)


def _found(selection: Selection, inside: NDArray[np.bool_], what: str, mesh: TetMesh) -> IntArray:
    found = np.flatnonzero(inside.all(axis=1)).astype(np.int32)
    if not len(found):
        span = ', '.join(
            f'{axis} {low:.4g} to {high:.4g}'
            for axis, low, high in zip('xyz', mesh.extent[0], mesh.extent[1], strict=True)
        )
        selection.section.wrong(
            'box', f'no {what} lies in it; the body spans {span} m in its own frame'
        )
    return found


def _listed(selection: Selection, name: str, count: int) -> IntArray:
    indices = np.array(selection.indices)
    outside = indices[(indices < 0) | (indices >= count)]
    if len(outside):
        selection.section.problems.add(
            selection.section.at(name),
            f'names {outside[0]}: the mesh has {count} of them, 0 to {count - 1}',
        )
        return np.zeros(0, np.int32)
    return indices.astype(np.int32)


def read_box(section: Section) -> FloatArray | None:
    """Read the entry `box`: lower and upper corner [m], shape (2, 3); None where it is wrong."""
    box = section.child('box')
    return None if box is None else box_corners(box)


def box_corners(box: Section) -> FloatArray | None:
    """Read a box: lower and upper corner [m], shape (2, 3); None where it is wrong."""
    corners = np.array([[-math.inf] * 3, [math.inf] * 3])
    for axis, name in enumerate('xyz'):
        if box.has(name):
            corners[:, axis] = _read_limits(box, name)
    box.refuse_unknown()
    if box.is_sound and not np.isfinite(corners).any():
        box.problems.add(box.key, 'limits nothing: give x, y or z as [low, high] in metres')
    return corners if box.is_sound else None


def _read_limits(box: Section, name: str) -> tuple[float, float]:
    needed = 'give [low, high] in metres, .inf and -.inf where there is no limit'
    value = box.raw(name)
    numbers = [as_number(item) for item in value] if isinstance(value, list) else []
    if len(numbers) != 2:
        box.wrong(name, needed)
        return -math.inf, math.inf
    low, high = numbers
    if low is None or high is None:
        box.wrong(name, needed)
        return -math.inf, math.inf
    if low > high:
        box.wrong(name, f'low is {shown(low)} and above high, {shown(high)}: swap them')
    return low, high


def _read_indices(section: Section, name: str) -> tuple[int, ...] | None:
    value = section.raw(name)
    indices = whole_numbers(value) if isinstance(value, list) else None
    if not indices:
        section.wrong(name, 'give a list of whole numbers, counted from 0')
        return None
    distinct = sorted(set(indices))
    if len(distinct) < len(indices):
        section.problems.add(
            section.at(name),
            f'names {len(indices) - len(distinct)} of its {len(indices)} numbers twice: '
            'keep one of each',
        )
        return None
    return tuple(distinct)
