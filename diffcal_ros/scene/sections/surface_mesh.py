# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Cut a watertight surface into tetrahedra, once: the result is kept and found again."""

from collections.abc import Iterator
from contextlib import contextmanager
import hashlib
from importlib import import_module
import os
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from zipfile import BadZipFile

from diffcal_ros.errors import InputError
from diffcal_ros.user_folders import cache_home
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

SURFACE_SUFFIXES = ('.stl', '.obj', '.ply')

_EDGES_PER_DIAGONAL = 20.0
# A finer cut would take hours; and an edge in the wrong unit ends up here.
_MOST_EDGES_PER_DIAGONAL = 200.0


def cut_surface(path: Path, edge_length: float | None) -> tuple[FloatArray, IntArray, str]:
    """Read a surface and fill it with tetrahedra.

    Cutting draws random numbers, so the same surface gives another mesh each time; the first
    one is therefore kept in the user's cache folder.

    Args:
        path: .stl, .obj or .ply.
        edge_length: wanted, in the file's unit; None for a twentieth of the diagonal.

    Returns:
        Positions in the file's unit, shape (V, 3), tetrahedra, shape (T, 4), and a phrase that
        says where the result is kept.

    Raises:
        InputError: when it is no watertight surface, or the extra `mesh` is not installed.
    """
    kept = _kept_file(path, edge_length)
    found = _load(kept)
    if found is None:
        found = _cut(path, edge_length)
        where = f'kept as {kept}' if _keep(kept, *found) else 'not kept: next time it differs'
        return *found, where
    return *found, f'taken from {kept}'


def _cut(path: Path, edge_length: float | None) -> tuple[FloatArray, IntArray]:
    surface = read_closed_surface(path)
    tetrahedralize = _tetrahedralize(path)
    diagonal = float(np.linalg.norm(np.ptp(surface.vertices, axis=0)))
    fraction = 1.0 / _EDGES_PER_DIAGONAL if edge_length is None else edge_length / diagonal
    if not 1.0 / _MOST_EDGES_PER_DIAGONAL <= fraction <= 1.0:
        raise InputError(
            f'edge_length is {fraction:.3g} of the size of {path.name}: give it in metres, '
            f'between {1.0 / _MOST_EDGES_PER_DIAGONAL:g} and 1 of the diagonal'
        )
    with _working_elsewhere():
        positions, tets = tetrahedralize(
            np.asarray(surface.vertices, dtype=np.float64),
            np.asarray(surface.faces, dtype=np.int32),
            edge_length_fac=fraction,
        )
    return np.asarray(positions, dtype=np.float64), np.asarray(tets, dtype=np.int64)


@contextmanager
def _working_elsewhere() -> Iterator[None]:
    """Work in a temporary folder: pytetwild leaves a file in the current one."""
    before = Path.cwd()
    with TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            yield
        finally:
            os.chdir(before)


def read_closed_surface(path: Path) -> Any:
    """Read a watertight surface whose triangles all face outward or all inward, as trimesh does.

    Raises:
        InputError: when it is none.
    """
    import trimesh

    try:
        surface: Any = trimesh.load(path, force='mesh')
        surface.merge_vertices(merge_tex=True, merge_norm=True)
    except Exception as error:  # The parsers raise whatever a broken file makes them trip over.
        raise InputError(
            f'{path.name} cannot be read as {path.suffix} ({error or type(error).__name__}): '
            'export it again'
        ) from error
    if len(surface.faces) == 0:
        raise InputError(f'{path.name} holds no triangles: export the surface as triangles')
    if not surface.is_watertight:
        edges = np.sort(surface.edges, axis=1)
        _, count = np.unique(edges, axis=0, return_counts=True)
        raise InputError(
            f'{path.name} is not watertight ({np.sum(count != 2)} edges have no partner or too '
            'many): close its holes (MeshLab, Blender), or give a volume mesh'
        )
    if not surface.is_winding_consistent:
        raise InputError(
            f'{path.name} has triangles that face both ways: make the normals consistent'
        )
    return surface


def _tetrahedralize(path: Path) -> Any:
    try:
        module = import_module('pytetwild')
    except ImportError as error:
        raise InputError(
            f'{path.name} is a surface, and cutting it into tetrahedra needs the extra `mesh` '
            f'({error}): `pip install pytetwild pyvista`, or give a volume mesh'
        ) from error
    return module.tetrahedralize


def _kept_file(path: Path, edge_length: float | None) -> Path:
    """Where the mesh cut from exactly these bytes in this way is kept."""
    digest = hashlib.sha256(path.read_bytes() + repr(edge_length).encode())
    return cache_home() / 'diffcal' / 'meshes' / f'{path.stem}_{digest.hexdigest()[:16]}.npz'


def _load(kept: Path) -> tuple[FloatArray, IntArray] | None:
    try:
        with np.load(kept) as content:
            return content['positions'], content['tets']
    except (OSError, ValueError, KeyError, EOFError, BadZipFile):
        return None


def _keep(kept: Path, positions: FloatArray, tets: IntArray) -> bool:
    """Store a mesh; tell whether that worked (a home folder may be read-only)."""
    fresh = kept.with_name(f'{kept.stem}.{os.getpid()}.npz')
    try:
        kept.parent.mkdir(parents=True, exist_ok=True)
        np.savez(fresh, positions=positions, tets=tets)
        fresh.replace(kept)
    except OSError:
        return False
    return True
