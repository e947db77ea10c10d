# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Read the body's mesh: volume meshes as they are, surfaces cut into tetrahedra."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from diffcal_ros.errors import InputError
from diffcal_ros.scene.sections.surface_mesh import cut_surface, SURFACE_SUFFIXES
from diffcal_ros.tet_mesh import FloatArray, TetMesh
import numpy as np
from numpy.typing import NDArray

# Divided by, not multiplied with a factor: 5.7 cm then becomes 0.057 m exactly as written.
UNITS_PER_METRE = {'m': 1.0, 'cm': 100.0, 'mm': 1000.0}
VOLUME_SUFFIXES = ('.tet', '.msh', '.vtk', '.vtu')

_TET_CELLS = ('tetra', 'tetra10')
# Points, lines and faces beside the tetrahedra mark groups; they carry no volume.
_IGNORED_CELLS = ('vertex', 'line', 'line3', 'triangle', 'triangle6')


@dataclass(frozen=True)
class MeshFile:
    """What a mesh file holds.

    Attributes:
        mesh: positions in metres; not yet looked at by `mesh_problems`.
        notes: what was changed on the way, in sentences for the user.
    """

    mesh: TetMesh
    notes: tuple[str, ...] = ()


def read_mesh(path: Path, *, unit: str, edge_length: float | None = None) -> MeshFile:
    """Read a mesh file by its suffix.

    Args:
        path: .tet, .msh, .vtk or .vtu; or a watertight surface, .stl, .obj or .ply.
        unit: of the file's coordinates, a key of `UNITS_PER_METRE`.
        edge_length: of the tetrahedra a surface is cut into [m]; None for a twentieth of the
            bounding box's diagonal.

    Raises:
        InputError: when the file is missing or cannot be read as its suffix says.
    """
    suffix = path.suffix.lower()
    if suffix not in (*VOLUME_SUFFIXES, *SURFACE_SUFFIXES):
        raise InputError(
            f'{path.name} has suffix {suffix!r}: meshes are {", ".join(VOLUME_SUFFIXES)}; '
            f'watertight surfaces {", ".join(SURFACE_SUFFIXES)}'
        )
    if not path.is_file():
        raise InputError(f'there is no mesh file {path}: check the path')
    if suffix in SURFACE_SUFFIXES:
        length = None if edge_length is None else edge_length * UNITS_PER_METRE[unit]
        positions, tets, where = cut_surface(path, length)
        mesh, _ = _oriented(positions / UNITS_PER_METRE[unit], tets)
        return MeshFile(mesh, (_cut_note(path, mesh, where),))
    if edge_length is not None:
        raise InputError(
            f'{path.name} holds tetrahedra: edge_length is for surfaces, leave it out'
        )
    positions, tets = _read_tet(path) if suffix == '.tet' else _read_with_meshio(path)
    mesh, turned = _oriented(positions / UNITS_PER_METRE[unit], tets)
    note = (
        f'all {mesh.tet_count} tetrahedra of {path.name} are listed the other way round '
        '(negative volume); they were turned'
    )
    return MeshFile(mesh, (note,) if turned else ())


def _cut_note(path: Path, mesh: TetMesh, where: str) -> str:
    sides = mesh.rest_positions[mesh.edges[0]]
    median = 1e3 * float(np.median(np.linalg.norm(sides[:, 1] - sides[:, 0], axis=1)))
    return (
        f'the surface {path.name} was cut into {mesh.tet_count} tetrahedra, half of their edges '
        f'shorter than {median:.3g} mm ({where})'
    )


def _oriented(positions: FloatArray, tets: NDArray[np.integer[Any]]) -> tuple[TetMesh, bool]:
    """Turn all tetrahedra when every one has a negative volume: a habit of the writer."""
    # Too large for int32 is outside the vertex list too, and must not wrap around into it.
    indices = np.clip(tets, -1, np.iinfo(np.int32).max)
    mesh = TetMesh(positions, np.ascontiguousarray(indices, dtype=np.int32))
    in_range = mesh.tet_count and tets.min() >= 0 and tets.max() < len(positions)
    if not in_range or not np.isfinite(positions).all() or not (mesh.volumes < 0.0).all():
        return mesh, False
    return TetMesh(positions, np.ascontiguousarray(mesh.tets[:, [0, 1, 3, 2]])), True


def _read_tet(path: Path) -> tuple[FloatArray, NDArray[np.int64]]:
    """Read `v x y z` and `t a b c d` lines, 0-based; `#` starts a comment."""
    try:
        lines = path.read_text(encoding='utf-8').splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f'{path.name} cannot be read as text ({error})') from error
    rows = [line.split() for line in lines]
    vertices = [row for row in rows if row and row[0] == 'v']
    tets = [row for row in rows if row and row[0] == 't']
    others = (row for row in rows if row and row[0] not in ('v', 't') and row[0][0] != '#')
    try:
        if next(others, None) is not None:
            raise ValueError('another kind of line')
        return _numbers(vertices, 3, np.float64), _numbers(tets, 4, np.int64)
    except (ValueError, OverflowError) as error:
        raise InputError(f'{path.name}, {_first_bad_line(rows)}') from error


def _numbers(rows: list[list[str]], size: int, kind: type[np.generic]) -> NDArray[Any]:
    if not rows:
        return np.zeros((0, size), kind)
    return np.array([row[1:] for row in rows]).astype(kind).reshape(len(rows), size)


def _first_bad_line(rows: list[list[str]]) -> str:
    """Say which line is wrong; slow, and only asked after a fast reading failed."""
    shapes: dict[str, tuple[int, Callable[[str], float], str]] = {
        'v': (3, float, 'three numbers'),
        't': (4, int, 'four whole numbers'),
    }
    for number, row in enumerate(rows, start=1):
        if not row or row[0][0] == '#':
            continue
        size, read, what = shapes.get(row[0], (-1, float, ''))
        if size < 0:
            return f'line {number} starts with {row[0]!r}: a line is `v x y z` or `t a b c d`'
        try:
            is_sound = len([read(item) for item in row[1:]]) == size
        except ValueError:
            is_sound = False
        if not is_sound:
            return f'line {number} is {" ".join(row)[:60]!r}: {what} are needed after {row[0]}'
    return 'some line is not `v x y z` or `t a b c d`'


def open_with_meshio(path: Path) -> Any:
    """Return what a .msh, .vtk or .vtu file holds, as meshio gives it.

    Raises:
        InputError: when it cannot be read.
    """
    import meshio

    # Not meshio.read, which ends the whole program on a file that it cannot read.
    readers = {'.msh': meshio.gmsh.read, '.vtk': meshio.vtk.read, '.vtu': meshio.vtu.read}
    try:
        return readers[path.suffix.lower()](str(path))
    except Exception as error:  # The parsers raise whatever a broken file makes them trip over.
        raise InputError(
            f'{path.name} cannot be read as {path.suffix} ({error or type(error).__name__}): '
            'export it again'
        ) from error


def _read_with_meshio(path: Path) -> tuple[FloatArray, NDArray[np.int64]]:
    content = open_with_meshio(path)
    kinds = {block.type for block in content.cells}
    foreign = sorted(kinds - {*_TET_CELLS, *_IGNORED_CELLS})
    if foreign:
        raise InputError(
            f'{path.name} holds {foreign[0]} cells: only tetrahedra are taken, mesh it with those'
        )
    blocks = [
        block.data for block in content.cells if block.type in _TET_CELLS and len(block.data)
    ]
    if not blocks:
        raise InputError(
            f'{path.name} holds no tetrahedra: give a volume mesh, or its surface as .stl'
        )
    return _corners_only(np.asarray(content.points, dtype=np.float64), blocks)


def _corners_only(
    points: FloatArray, blocks: list[NDArray[np.int64]]
) -> tuple[FloatArray, NDArray[np.int64]]:
    """Keep the corners of 10-node tetrahedra and drop their mid-edge nodes."""
    tets = np.concatenate([block[:, :4] for block in blocks]).astype(np.int64)
    middle = np.concatenate([block[:, 4:].reshape(-1) for block in blocks])
    kept = np.ones(len(points), dtype=bool)
    kept[np.setdiff1d(middle, tets)] = False
    return points[kept], (np.cumsum(kept) - 1)[tets]
