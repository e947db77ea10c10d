# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Build the body of body.npz in Newton and let it sink: `python play_newton.py`.

Needs `pip install newton`. `SolverVBD` is given Lame's parameters; for `SolverSemiImplicit` take
`neo_hookean_mu` and `neo_hookean_lambda` of the file instead.
"""

import argparse
from pathlib import Path

import newton
import numpy as np
import warp as wp

_STEP = 1.0 / 300.0


def build(path: Path) -> newton.ModelBuilder:
    """Return a builder with the body, its clamp and gravity."""
    body = np.load(path)
    builder = newton.ModelBuilder(gravity=tuple(body['gravity'].tolist()))
    builder.add_soft_mesh(
        pos=wp.vec3(0.0, 0.0, 0.0),
        rot=wp.quat_identity(),
        scale=1.0,
        vel=wp.vec3(0.0, 0.0, 0.0),
        vertices=[wp.vec3(*vertex) for vertex in body['vertices'].tolist()],
        indices=body['tets'].reshape(-1).tolist(),
        density=float(body['density'].mean()),
        k_mu=body['lame_mu'],
        k_lambda=body['lame_lambda'],
        k_damp=0.0,
    )
    # One density is taken; regions may have several, so the masses are set as they are.
    masses = body['vertex_masses'].copy()
    masses[body['held']] = 0.0
    builder.particle_mass[:] = masses.tolist()
    builder.color()
    return builder


def play(path: Path, seconds: float, iterations: int) -> np.ndarray:
    """Step the body and print how far it sinks; return the displacements [m], shape (V, 3)."""
    model = build(path).finalize()
    solver = newton.solvers.SolverVBD(model, iterations=iterations)
    state, after = model.state(), model.state()
    control, rest = model.control(), state.particle_q.numpy().copy()
    print(f'{len(rest)} vertices, {np.load(path)["vertex_masses"].sum():.4g} kg')
    for number in range(round(seconds / _STEP)):
        solver.step(state, after, control, None, _STEP)
        state, after = after, state
        if number % 30 == 29:
            moved = np.linalg.norm(state.particle_q.numpy() - rest, axis=1).max()
            print(f'{(number + 1) * _STEP:6.3f} s  moved by up to {1e3 * moved:.3f} mm')
    return np.asarray(state.particle_q.numpy() - rest, dtype=float)


def main() -> None:
    """Play the asset beside this script."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--seconds', type=float, default=1.0)
    parser.add_argument('--iterations', type=int, default=20, help='of VBD in each step')
    args = parser.parse_args()
    play(Path(__file__).with_name('body.npz'), args.seconds, args.iterations)


if __name__ == '__main__':
    main()
