# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Load body.xml into MuJoCo and let the body sink: `python play_mjcf.py [--view]`.

Needs `pip install mujoco` (4.0 or newer).
"""

import argparse
from pathlib import Path

import mujoco
import numpy as np


def play(path: Path, seconds: float) -> np.ndarray:
    """Step the model and print how far it sinks; return the displacements [m], shape (V, 3)."""
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    rest = _vertices(model, data)
    print(f'{len(rest)} vertices, {model.body_mass.sum():.4g} kg, {model.nflex} flexes')
    moved = np.zeros_like(rest)
    report = 0.0
    while data.time < seconds:
        mujoco.mj_step(model, data)
        if data.time >= report:
            moved = _vertices(model, data) - rest
            print(f'{data.time:6.3f} s  moved by up to {1e3 * _largest(moved):.3f} mm')
            report += 0.1
    return _vertices(model, data) - rest


def _vertices(model: mujoco.MjModel, data: mujoco.MjData) -> np.ndarray:
    """Return the bodies v0, v1, ... that carry the vertices [m], shape (V, 3)."""
    count = sum(model.body(number).name.startswith('v') for number in range(1, model.nbody))
    return np.array([data.body(f'v{number}').xpos for number in range(count)])


def _largest(moved: np.ndarray) -> float:
    return float(np.linalg.norm(moved, axis=1).max())


def main() -> None:
    """Play the asset beside this script."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--seconds', type=float, default=2.0)
    parser.add_argument('--view', action='store_true', help="open MuJoCo's window")
    args = parser.parse_args()
    path = Path(__file__).with_name('body.xml')
    if args.view:
        import mujoco.viewer

        mujoco.viewer.launch_from_path(str(path))
    else:
        play(path, args.seconds)


if __name__ == '__main__':
    main()
