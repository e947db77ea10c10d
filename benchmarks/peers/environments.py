# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""One virtual environment for each peer, and its runs there."""

from collections.abc import Sequence
from dataclasses import dataclass
import json
import os
from pathlib import Path
import subprocess
import sys
from typing import Any

from benchmarks.peers.clock import last_line

_ONE_THREAD = {
    **dict.fromkeys(('OMP_NUM_THREADS', 'MKL_NUM_THREADS', 'OPENBLAS_NUM_THREADS'), '1'),
    'XLA_FLAGS': '--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1',
    'JAX_PLATFORMS': 'cpu',
}
_DONE = 'installed.txt'
_LONGEST = 900.0


@dataclass(frozen=True)
class Peer:
    """A package: what pip installs, and the script that measures it."""

    packages: tuple[str, ...]
    script: str


# jax-fem's wheel does not say what it needs.
_JAX_FEM = ('jax-fem', 'jax[cpu]', 'pyfiglet', 'fenics-basix', 'meshio', 'gmsh', 'matplotlib')
PEERS = {
    # torch-fem solves faster with Pardiso, and then needs no compiler for it.
    'torch-fem': Peer(('torch-fem', 'pypardiso'), 'torch_fem_peer.py'),
    'jax-fem': Peer(_JAX_FEM, 'jax_fem_peer.py'),
    'newton': Peer(('newton',), 'newton_peer.py'),
    'mitsuba': Peer(('mitsuba', 'numpy'), 'mitsuba_peer.py'),
    'mujoco': Peer(('mujoco',), 'mujoco_peer.py'),
}


def install(name: str, folder: Path) -> Path:
    """Make a peer's environment where there is none; return its Python.

    Raises:
        RuntimeError: with pip's last line, when it cannot be installed here.
    """
    place = folder / 'envs' / name
    python, done = place / 'bin' / 'python', place / _DONE
    if not done.exists():
        place.parent.mkdir(parents=True, exist_ok=True)
        packages = PEERS[name].packages
        for command in (
            [sys.executable, '-m', 'venv', str(place)],
            [str(python), '-m', 'pip', 'install', '--quiet', *packages],
        ):
            ran = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
            if ran.returncode:
                raise RuntimeError(f'not installable here: {last_line(ran.stderr)}')
        done.write_text('\n'.join(packages) + '\n')
    return python


def measure(command: Sequence[str], folder: Path, name: str) -> tuple[dict[str, Any], Path]:
    """Run one measurement on one thread; return its figures and the file of its arrays.

    Args:
        command: that is given the case's file and the arrays' file.
        folder: of the case; what a package leaves behind lies there and not in the checkout.
        name: of the package.

    Raises:
        RuntimeError: with the last line of its error, when it does not end well.
    """
    arrays = folder / f'{name}.npz'
    own = [Path(__file__).parents[2], os.environ.get('PYTHONPATH', '')]
    path = {'PYTHONPATH': os.pathsep.join(str(each) for each in own if str(each))}
    # One core as well: some packages start threads whatever they are told.
    core = str(max(os.sched_getaffinity(0)))
    ran = subprocess.run(
        ['taskset', '-c', core, *command, str(folder / 'case.npz'), str(arrays)],
        cwd=folder,
        env={**os.environ, **_ONE_THREAD, **path},
        capture_output=True,
        text=True,
        timeout=_LONGEST,
        check=False,
    )
    if ran.returncode:
        raise RuntimeError(f'ended with {ran.returncode}: {last_line(ran.stderr)}')
    figures: dict[str, Any] = json.loads(ran.stdout.strip().splitlines()[-1])
    return figures, arrays


def run_peer(name: str, folder: Path) -> tuple[dict[str, Any], Path | None]:
    """Install and measure one peer; a failure is a figure as well."""
    try:
        python = install(name, folder)
        script = Path(__file__).with_name(PEERS[name].script)
        return measure([str(python), str(script.resolve())], folder, name)
    except (RuntimeError, OSError, ValueError, subprocess.TimeoutExpired) as fault:
        return {'failed': last_line(str(fault))}, None
