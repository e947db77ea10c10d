# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A modulus that varies over the body, as a file beside the scene.

The file is the mesh with one number a tetrahedron: its Young's modulus over that of its region.
A region's modulus thus stays one parameter, which scales the field there.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from diffcal_ros.atomic_file import replacing
from diffcal_ros.errors import InputError
from diffcal_ros.scene.reading.section import Section
from diffcal_ros.scene.reading.shapes import Keys, Text
from diffcal_ros.scene.sections.mesh_files import open_with_meshio
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

KEY = 'modulus_field'
FIELD_FILE = 'field.vtu'
MODULUS_FIELD_SHAPE = Keys(
    {'file': Text('.vtu, as `diffcal calibrate --field` writes it')},
    ('file',),
    'a modulus that varies within the regions',
)
RELATIVE_MODULUS = 'relative_modulus'

_SUFFIX = '.vtu'
# Of the body's size: a mesh that was written as text has lost digits.
_SAME_PLACE = 1e-5


def read_modulus_field(scene: Section, folder: Path, mesh: TetMesh | None) -> FloatArray | None:
    """Read `modulus_field`; None where there is none, or a mistake was noted.

    Args:
        scene: the whole file.
        folder: that paths are relative to.
        mesh: of the scene; None: a mistake was noted in it.

    Returns:
        Young's modulus of each tetrahedron over its region's, shape (T,).
    """
    section = scene.child(KEY)
    if section is None:
        return None
    file = section.path('file', folder, needed=f'name the file of the field, such as {FIELD_FILE}')
    section.refuse_unknown()
    if mesh is None or not section.is_sound:
        return None
    try:
        return _read(file, mesh)
    except InputError as error:
        section.wrong('file', str(error))
        return None


def write_modulus_field(
    path: Path,
    mesh: TetMesh,
    relative_modulus: FloatArray,
    *,
    cells: Mapping[str, FloatArray] | None = None,
    points: Mapping[str, FloatArray] | None = None,
) -> None:
    """Write a field as VTK's unstructured grid, whole or not at all.

    Args:
        path: .vtu file.
        mesh: of the scene.
        relative_modulus: Young's modulus of each tetrahedron over its region's, shape (T,).
        cells: more numbers of the tetrahedra, shape (T,) each.
        points: numbers of the vertices, shape (V, ..) each.

    Raises:
        InputError: when the file cannot be written.
    """
    import meshio

    columns = {RELATIVE_MODULUS: relative_modulus, **(cells or {})}
    content = meshio.Mesh(
        mesh.rest_positions,
        [('tetra', mesh.tets)],
        point_data=dict(points or {}),
        cell_data={name: [column] for name, column in columns.items()},
    )
    with replacing(path) as fresh:
        meshio.vtu.write(str(fresh), content)


def _read(path: Path, mesh: TetMesh) -> FloatArray:
    if path.suffix.lower() != _SUFFIX:
        raise InputError(f'a field is a {_SUFFIX} file, as `diffcal calibrate --field` writes it')
    if not path.is_file():
        raise InputError(f'there is no file {path}: keep it beside the scene, or fit it again')
    content = open_with_meshio(path)
    if RELATIVE_MODULUS not in content.cell_data:
        raise InputError(
            f'it has no cell data `{RELATIVE_MODULUS}`, the modulus of each tetrahedron over its '
            "region's: write it with `diffcal calibrate --field`"
        )
    is_tets = [block.type == 'tetra' for block in content.cells]
    tets = _of_tets([block.data for block in content.cells], is_tets, (0, 4))
    values = _of_tets(content.cell_data[RELATIVE_MODULUS], is_tets, (0,))
    _check_mesh(np.asarray(content.points, dtype=np.float64), tets, mesh)
    return _checked(values.astype(np.float64), mesh)


def _of_tets(blocks: list[Any], is_tets: list[bool], empty: tuple[int, ...]) -> NDArray[Any]:
    kept = [np.asarray(block) for block, keep in zip(blocks, is_tets, strict=True) if keep]
    return np.concatenate(kept) if kept else np.zeros(empty)


def _check_mesh(points: FloatArray, tets: NDArray[Any], mesh: TetMesh) -> None:
    """Refuse a field that was made for another mesh."""
    remedy = 'it belongs to another mesh, fit it again on this one with `--field`'
    if len(tets) != mesh.tet_count:
        raise InputError(f'it has {len(tets)} tetrahedra and the mesh {mesh.tet_count}: {remedy}')
    size = float(np.linalg.norm(np.ptp(mesh.rest_positions, axis=0)))
    if points.shape == mesh.rest_positions.shape and np.array_equal(tets, mesh.tets):
        off = float(np.abs(points - mesh.rest_positions).max())
        if off <= _SAME_PLACE * size:
            return
        raise InputError(
            f'its vertices are up to {1e3 * off:.3g} mm from those of the mesh (in metres, as '
            f'that is): {remedy}'
        )
    raise InputError(f'its tetrahedra have other corners than those of the mesh: {remedy}')


def _checked(values: FloatArray, mesh: TetMesh) -> FloatArray:
    if values.shape != (mesh.tet_count,):
        raise InputError(
            f'`{RELATIVE_MODULUS}` has shape {values.shape}: one number a tetrahedron is needed, '
            f'{mesh.tet_count}'
        )
    wrong = np.flatnonzero(~(np.isfinite(values) & (values > 0.0)))
    if len(wrong):
        raise InputError(
            f'`{RELATIVE_MODULUS}` is {values[wrong[0]]:g} in tetrahedron {wrong[0]} (of '
            f'{len(wrong)} such): it must be positive and finite everywhere'
        )
    return values
