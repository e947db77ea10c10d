# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The same released cantilever by Newton physics: semi-implicit steps and a Warp tape.

Run by the Python of an environment with `pip install newton` (its Warp need not be ours). Reads
arrays from an .npz file and prints one line of JSON.
"""

import json
import sys
import time

import newton
import numpy as np
import warp as wp

wp.config.quiet = True


@wp.kernel
def tip_height(positions: wp.array(dtype=wp.vec3), tip: int, loss: wp.array(dtype=float)):
    """Read the loss."""
    loss[0] = positions[tip][1]


def main() -> None:
    """Simulate, go back through the tape, and tell."""
    data = np.load(sys.argv[1])
    duration, dt = float(sys.argv[2]), float(sys.argv[3])
    builder = newton.ModelBuilder(up_axis=newton.Axis.Y, gravity=(0.0, 9.8, 0.0))
    builder.add_soft_mesh(
        pos=(0.0, 0.0, 0.0),
        rot=wp.quat_identity(),
        scale=1.0,
        vel=(0.0, 0.0, 0.0),
        vertices=[tuple(p) for p in data['positions'].tolist()],
        indices=data['tets'].ravel().tolist(),
        density=float(data['density']),
        k_mu=float(data['mu']),
        k_lambda=float(data['lam']),
        k_damp=float(data['beta']),
        add_surface_mesh_edges=False,
    )
    for vertex in data['held'].tolist():
        builder.particle_mass[vertex] = 0.0
    begun = time.perf_counter()
    model = builder.finalize(device='cpu', requires_grad=True)
    model.particle_grid = None  # Else its particles push each other away.
    solver = newton.solvers.SolverSemiImplicit(model, enable_tri_contact=False)
    steps = round(duration / dt)
    states = [model.state(requires_grad=True) for _ in range(steps + 1)]
    control, loss = model.control(), wp.zeros(1, dtype=float, requires_grad=True)
    set_up = time.perf_counter() - begun
    solver.step(states[0], states[1], control, None, dt)  # Compiles.
    states[0] = model.state(requires_grad=True)
    begun = time.perf_counter()
    tape = wp.Tape()
    with tape:
        for step in range(steps):
            states[step].clear_forces()
            solver.step(states[step], states[step + 1], control, None, dt)
        wp.launch(
            tip_height,
            dim=1,
            inputs=[states[-1].particle_q, int(data['tip'])],
            outputs=[loss],
        )
    forward = time.perf_counter() - begun
    tape.backward(loss=loss)
    total = time.perf_counter() - begun
    gradient = model.tet_materials.grad.numpy()
    print(
        json.dumps(
            {
                'newton': newton.__version__,
                'warp': wp.config.version,
                'steps': steps,
                'set_up_s': set_up,
                'forward_s': forward,
                'forward_and_gradient_s': total,
                'tip_m': states[-1].particle_q.numpy()[int(data['tip'])].tolist(),
                'gradient_is_finite': bool(np.isfinite(gradient).all()),
            }
        )
    )


if __name__ == '__main__':
    main()
