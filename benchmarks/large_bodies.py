# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How the cost of an equilibrium with its gradient grows with the body, quadratic elements.

Each body is settled in a process of its own, which tells its largest memory. Seconds are of the
processor: other work on the machine counts less than by the clock.
"""

import argparse
from concurrent.futures import ProcessPoolExecutor
from itertools import permutations, product
import math
import multiprocessing
import resource
import time
from typing import Any

from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.statics.force_changes import Change
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.tet_mesh import TetMesh
from equilibrium import GRAVITY, MODULUS, uniform_material
from measuring import cantilevers, write
import numpy as np

# Mesh of the public data set, and into how many parts each of its edges is cut.
BODIES = {
    'coarse': ('coarse', 1),
    'middle': ('middle', 1),
    'fine': ('fine', 1),
    'middle refined': ('middle', 2),
    'coarse in thirds': ('coarse', 3),
    'fine refined': ('fine', 2),
}


def body_mesh(name: str) -> TetMesh:
    """Return the mesh of one of `BODIES`."""
    mesh_name, parts = BODIES[name]
    mesh = cantilevers()[mesh_name]
    return subdivided(mesh, parts) if parts > 2 else refined(mesh, parts - 1)


def refined(mesh: TetMesh, times: int) -> TetMesh:
    """Return a mesh with each tetrahedron cut into eight so many times."""
    for _ in range(times):
        mesh = mesh.refined()[0]
    return mesh


def subdivided(mesh: TetMesh, parts: int) -> TetMesh:
    """Return a mesh whose edges are cut into so many parts each, its tetrahedra into their cube.

    Each tetrahedron, its corners in the order of their numbers, is the image of parts >= x >= y >=
    z >= 0, which the six paths along the edges of each unit cube cut (Freudenthal, 1942). The
    order makes neighbours agree on their common face.
    """
    corners = np.array(list(product(range(parts), repeat=3)))
    paths = np.array([np.cumsum(np.eye(3, dtype=int)[list(o)], 0) for o in permutations(range(3))])
    cut = corners[:, None, None] + np.insert(paths, 0, 0, axis=1)
    cut = cut.reshape(-1, 4, 3)
    inside = (cut[..., 0] >= cut[..., 1]) & (cut[..., 1] >= cut[..., 2])
    cut = cut[inside.all(axis=1)]
    shares = -np.diff(cut, axis=-1, prepend=parts, append=0)
    counted = np.sort(mesh.tets, axis=1)
    # Nodes are the same where the same corners have the same shares.
    weights = np.broadcast_to(shares, (mesh.tet_count, *shares.shape)).reshape(-1, 4)
    owners = np.broadcast_to(counted[:, None, None], (mesh.tet_count, *shares.shape)).reshape(
        -1, 4
    )
    keys = np.sort(np.where(weights > 0, owners * (parts + 1) + weights, -1), axis=1)
    _, first, nodes = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    places = mesh.rest_positions[owners[first]]
    positions = np.einsum('nk,nki->ni', weights[first] / parts, places)
    tets = nodes.reshape(-1, 4).astype(np.int32)
    edges = positions[tets[:, 1:]] - positions[tets[:, :1]]
    turned = np.linalg.det(edges) < 0.0
    tets[turned] = tets[turned][:, [0, 1, 3, 2]]
    return TetMesh(positions, tets)


def measure(name: str, solver: str) -> dict[str, Any]:
    """Settle one body from rest, and again with 5 % more modulus."""
    _warm_up(solver)
    mesh = body_mesh(name)
    held = np.flatnonzero(mesh.rest_positions[:, 0] >= 0.07 - 1e-9).astype(np.int32)
    begun = time.process_time()
    body = StaticBody(mesh, Element.QUADRATIC, held, solver=solver)
    set_up = time.process_time() - begun
    first, second = (uniform_material(mesh.tet_count, factor * MODULUS) for factor in (1.0, 1.05))
    begun = time.process_time()
    cold_state = body.solve_equilibrium(first, GRAVITY)
    body.gradient(np.ones_like(cold_state.positions))
    cold = time.process_time() - begun
    tangent = body.tangents([Change(youngs_modulus=first.youngs_modulus)])[0]
    begun = time.process_time()
    warm_state = body.solve_equilibrium(second, GRAVITY, prediction=math.log(1.05) * tangent)
    body.gradient(np.ones_like(warm_state.positions))
    warm = time.process_time() - begun
    sag = float((cold_state.positions - body.discretisation.rest_nodes)[:, 1].max())
    return {
        'body': name,
        'tets': mesh.tet_count,
        'unknowns': body.solver.stiffness.pattern.size,
        'solver': body.solver.stiffness.solver_name,
        'sag_mm': 1e3 * sag,
        'set_up_cpu_s': set_up,
        'cold_cpu_s': cold,
        'cold_factorisations': cold_state.newton_steps,
        'warm_cpu_s': warm,
        'warm_factorisations': warm_state.newton_steps,
        'peak_gb': resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6,
    }


def _warm_up(solver: str) -> None:
    """Load the kernels, which are compiled once a machine."""
    mesh = cantilevers()['coarse']
    held = np.flatnonzero(mesh.rest_positions[:, 0] >= 0.07 - 1e-9).astype(np.int32)
    body = StaticBody(mesh, Element.QUADRATIC, held, solver=solver)
    body.solve_equilibrium(uniform_material(mesh.tet_count), GRAVITY)
    body.gradient(np.ones_like(body.state.positions))


def growth(rows: list[dict[str, Any]]) -> float:
    """Return the power of the number of tetrahedra that the cold cost grows with."""
    count, cost = (np.log([row[key] for row in rows]) for key in ('tets', 'cold_cpu_s'))
    return float(np.polyfit(count, cost, 1)[0])


def main() -> None:
    """Measure bodies with solvers."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--solvers', nargs='+', default=['auto'])
    parser.add_argument('--bodies', nargs='+', choices=tuple(BODIES), default=list(BODIES))
    parser.add_argument('--name', default='large_bodies')
    arguments = parser.parse_args()
    context = multiprocessing.get_context('spawn')
    figures: dict[str, Any] = {}
    for solver in arguments.solvers:
        rows = []
        for body in arguments.bodies:
            with ProcessPoolExecutor(1, mp_context=context) as pool:
                rows.append(pool.submit(measure, body, solver).result())
            figures[solver] = {'rows': rows}
            if len(rows) > 1:
                figures[solver]['cold_grows_with_the_power'] = growth(rows)
            write(arguments.name, figures)


if __name__ == '__main__':
    main()
