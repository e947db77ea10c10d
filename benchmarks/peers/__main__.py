# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Time torch-fem, jax-fem, Newton, Mitsuba 3 and MuJoCo's flex beside us on the same body.

    python -m benchmarks.peers --out DIR [--only NAME ...]

Each peer gets an environment under DIR/envs and stays there; one that cannot be installed or run
says why. Mitsuba needs an LLVM library: DRJIT_LIBLLVM_PATH names one that it does not find by
itself. Writes benchmarks/results/peers.json; with --only, figures of the other peers stay from
the last run in DIR. Times are processor seconds of one thread.
"""

import argparse
import json
import os
from pathlib import Path
import sys
from typing import Any

import numpy as np

from benchmarks.measuring import write
from benchmarks.peers.case import write_case
from benchmarks.peers.comparing import compare
from benchmarks.peers.environments import measure, PEERS, run_peer

_CONDITIONS = {
    'body': "the public data set's coarse cantilever: 1,750 tetrahedra, 534 vertices",
    'material': 'E = 200 kPa, nu = 0.45, 1080 kg/m^3, 9.8 m/s^2',
    'our_law': 'mu/2 (Ic - 3) - mu/2 log((Ic + 1)/4) + lambda/2 (J - 1)^2 - 3/4 mu (J - 1)',
    'st_venant_kirchhoff': 'mu tr(G^2) + lambda/2 tr(G)^2, G the Green strain',
    'residual': 'peers: norm of forces left below 1e-8 of that of the loads; ours: largest force '
    'left below 1e-7 of the mean load of a node',
    'gradient': 'equilibrium and motion: of the height of the tip by log E [mm]; depth: of the '
    'squared difference to a target picture by the vertices',
    'motion': '0.4 s after the ledge under the free end is gone, no damping',
    'both': 'forward and gradient in one call',
}


def main() -> int:
    """Run the program; return its exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--out', type=Path, required=True)
    parser.add_argument('--only', nargs='+', choices=tuple(PEERS), default=tuple(PEERS))
    given = parser.parse_args()
    out: Path = given.out.resolve()
    out.mkdir(parents=True, exist_ok=True)
    os.environ['OMP_NUM_THREADS'] = '1'  # What `measuring` tells of the processes started here.
    write_case(out / 'case.npz')
    ours, own = measure([sys.executable, '-m', 'benchmarks.peers.ours'], out, 'ours')
    arrays = {'ours': _arrays(own)}
    peers: dict[str, Any] = {}
    for name in PEERS:
        kept = out / f'{name}.json'
        if name in given.only:
            found, file = run_peer(name, out)
            if file is None:
                (out / f'{name}.npz').unlink(missing_ok=True)
            kept.write_text(json.dumps(found))
            print(name, found, flush=True)
        if kept.exists():
            peers[name] = json.loads(kept.read_text())
            arrays[name] = _arrays(out / f'{name}.npz')
    compare(ours, peers, arrays, _arrays(out / 'case.npz'))
    write('peers', {'conditions': _CONDITIONS, 'ours': ours, 'peers': peers})
    return 0


def _arrays(file: Path) -> dict[str, Any]:
    if not file.exists():
        return {}
    with np.load(file) as stored:
        return {name: stored[name] for name in stored.files}


if __name__ == '__main__':
    sys.exit(main())
