# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Timing, hardware and where results go, shared by the benchmarks."""

from collections.abc import Callable
import datetime
import importlib.metadata
import json
import os
from pathlib import Path
import platform
import statistics
import subprocess
import time
from typing import Any

RESULTS = Path(__file__).parent / 'results'
_PACKAGES = ('numpy', 'scipy', 'warp-lang', 'qdldl', 'cvxopt', 'pypardiso', 'torch')


def timed(work: Callable[[], Any], *, repeats: int = 15, before: Callable[[], Any] | None = None):
    """Return median and fastest seconds of a call; the first call is not counted."""
    seconds = []
    for _ in range(repeats + 1):
        if before is not None:
            before()
        begun = time.perf_counter()
        work()
        seconds.append(time.perf_counter() - begun)
    return {'median_s': statistics.median(seconds[1:]), 'fastest_s': min(seconds[1:])}


def machine() -> dict[str, Any]:
    """Describe what the figures were measured on."""
    model = platform.processor()
    for line in Path('/proc/cpuinfo').read_text().splitlines():
        if line.startswith('model name'):
            model = line.split(':', 1)[1].strip()
            break
    versions = {}
    for package in _PACKAGES:
        try:
            versions[package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            continue
    commit = subprocess.run(
        ['git', 'rev-parse', '--short', 'HEAD'], capture_output=True, text=True, check=False
    ).stdout.strip()
    return {
        'processor': model,
        'cores': os.cpu_count(),
        'threads': os.environ.get('OMP_NUM_THREADS', 'all'),
        'python': platform.python_version(),
        'versions': versions,
        'commit': commit,
        'date': datetime.date.today().isoformat(),
    }


def write(name: str, figures: dict[str, Any]) -> Path:
    """Write figures with the machine's description; print them."""
    RESULTS.mkdir(exist_ok=True)
    path = RESULTS / f'{name}.json'
    text = json.dumps({'machine': machine(), 'figures': figures}, indent=2)
    path.write_text(text + '\n')
    print(text)
    return path


def cantilevers() -> dict[str, Any]:
    """Return the public data set's cantilevers."""
    from diffcal_ros.scene.sections.mesh_files import read_mesh

    shapes = {
        'coarse': 'cantilever_coarse',
        'middle': 'cantilever',
        'fine': 'cantilever_fine',
    }
    return {
        name: read_mesh(next((data_set() / 'CAD_models' / shape).glob('*.tet')), unit='cm').mesh
        for name, shape in shapes.items()
    }


def data_set() -> Path:
    """Return the folder of the public data set."""
    folder = os.environ.get('DIFFCAL_DATA')
    if not folder:
        raise SystemExit('set DIFFCAL_DATA to a clone of the public DiffCal data set')
    return Path(folder)
