# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fixtures shared by all tests."""

from collections.abc import Callable
import copy
import gc
from itertools import permutations
import os
from pathlib import Path
import shutil
import tarfile
from typing import Any, TYPE_CHECKING

from diffcal_ros.tet_mesh import TetMesh
import numpy as np
import pytest
import yaml

if TYPE_CHECKING:
    from diffcal_ros.synthetic.recorder import SyntheticRecording

_ARCHIVE = Path(__file__).resolve().parents[2] / 'shared' / 'data' / 'diffcal_public_data.tar.xz'


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark as slow all but the first of a test's sets of parameters, where it asks for that."""
    begun = set[str]()
    for item in items:
        if item.get_closest_marker('slow_but_first') is None:
            continue
        function = item.nodeid.partition('[')[0]
        if function in begun:
            item.add_marker(pytest.mark.slow)
        begun.add(function)


def pytest_collection_finish() -> None:
    """Take what was collected for no garbage: each collection would look through all of it."""
    gc.collect()
    gc.freeze()


@pytest.fixture(scope='session')
def diffcal_data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of the public data set (CAD_models, exp_data, reference), or skip."""
    if 'DIFFCAL_DATA' in os.environ:
        folder = Path(os.environ['DIFFCAL_DATA'])
        if not (folder / 'exp_data').is_dir():
            pytest.fail(f'DIFFCAL_DATA is {folder}, which has no exp_data folder')
        return folder
    if not _ARCHIVE.is_file():
        pytest.skip('public data not found: set DIFFCAL_DATA to a clone of the DiffCal data set')
    return _unpacked(tmp_path_factory)


def _unpacked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Unpack the archive once, into a cache outside the checkout."""
    size = _ARCHIVE.stat().st_size
    cache = Path(os.environ.get('XDG_CACHE_HOME', Path.home() / '.cache')) / 'diffcal'
    folder = cache / f'public_data_{size}'
    if not folder.is_dir():
        fresh = tmp_path_factory.mktemp('public_data')
        with tarfile.open(_ARCHIVE) as archive:
            archive.extractall(fresh, filter='data')
        cache.mkdir(parents=True, exist_ok=True)
        shutil.move(str(fresh), folder)
    return folder / 'diffcal_public_data'


@pytest.fixture
def random() -> np.random.Generator:
    """Random numbers that are the same in every run."""
    return np.random.default_rng(20231115)


@pytest.fixture
def make_beam() -> Callable[..., TetMesh]:
    """Cut a box around the origin into six tetrahedra a cell: `make_beam(cells, size)`."""
    return _beam


@pytest.fixture
def beam_mesh() -> TetMesh:
    """Beam of 200 x 30 x 30 mm along x, 192 tetrahedra."""
    return _beam()


def _beam(
    cells: tuple[int, int, int] = (8, 2, 2),
    size: tuple[float, float, float] = (0.2, 0.03, 0.03),
) -> TetMesh:
    counts = np.array(cells) + 1
    grid = np.stack(np.meshgrid(*map(np.arange, counts), indexing='ij'), axis=-1).reshape(-1, 3)
    positions = (grid / np.array(cells) - 0.5) * np.array(size)
    steps = np.array([counts[1] * counts[2], counts[2], 1])
    lows = grid[(grid < np.array(cells)).all(axis=1)] @ steps
    # Each order of the three axes is a path along a cell's edges from corner to far corner.
    paths = [np.cumsum([0, *steps[list(order)]]) for order in permutations(range(3))]
    tets = np.concatenate([lows[:, None] + path for path in paths])
    corners = positions[tets]
    turned = np.linalg.det(corners[:, 1:] - corners[:, :1]) < 0.0
    tets[turned] = tets[turned][:, [0, 1, 3, 2]]
    return TetMesh(positions, tets.astype(np.int32))


@pytest.fixture
def write_tet() -> Callable[..., Path]:
    """Write a mesh as .tet: `write_tet(path, mesh, units_per_metre)`."""
    return _write_tet


def _write_tet(path: Path, mesh: TetMesh, units_per_metre: float = 1000.0) -> Path:
    lines = [f'v {x} {y} {z}' for x, y, z in (mesh.rest_positions * units_per_metre).tolist()]
    lines += [f't {a} {b} {c} {d}' for a, b, c, d in mesh.tets.tolist()]
    path.write_text('\n'.join(lines) + '\n')
    return path


_MINIMAL_SCENE: dict[str, Any] = {
    'format': 1,
    'mesh': {'file': 'beam.tet', 'unit': 'mm'},
    'held': {'clamp': {'box': {'x': [0.08, float('inf')]}}},
    'regions': {'body': {'youngs_modulus': 6e4, 'poissons_ratio': 0.49, 'density': 1080}},
    'gravity': [0, -9.81, 0],
    'placement': {'translation': [0, 0, 0]},
}


@pytest.fixture
def write_scene(tmp_path: Path, beam_mesh: TetMesh) -> Callable[..., Path]:
    """Write a small scene with dotted keys changed: `write_scene({'mesh.unit': 'cm'})`.

    `...` as a value removes the key.
    """
    _write_tet(tmp_path / 'beam.tet', beam_mesh)

    def write(changes: dict[str, Any] | None = None) -> Path:
        document = copy.deepcopy(_MINIMAL_SCENE)
        for dotted, value in (changes or {}).items():
            *sections, key = dotted.split('.')
            section = document
            for name in sections:
                section = section.setdefault(name, {})
            if value is ...:
                del section[key]
            else:
                section[key] = value
        path = tmp_path / 'scene.yaml'
        path.write_text(yaml.safe_dump(document, sort_keys=False))
        return path

    return write


@pytest.fixture(scope='session')
def recorded_beam(tmp_path_factory: pytest.TempPathFactory) -> 'SyntheticRecording':
    """A beam filmed by the synthetic recorder; not to be changed."""
    from support.recorded_beam import record_beam  # It loads Warp, which most tests do not need.

    return record_beam(tmp_path_factory.mktemp('beam'))
