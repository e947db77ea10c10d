# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Equilibrium and gradient of a hanging cantilever, cold and after a 5 % change of modulus."""

import argparse
import time
from typing import Any

from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.statics.force_changes import Change
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.material import LameConvention, Material
from measuring import cantilevers, timed, write
import numpy as np

GRAVITY = np.array([0.0, 9.8, 0.0])
MODULUS = 2.0 * 69.27e3 * 1.49


def uniform_material(count: int, modulus: float = MODULUS) -> Material:
    """Return the cantilevers' material."""
    ones = np.ones(count)
    return Material(modulus * ones, 0.49 * ones, 1080.0 * ones, LameConvention.PAPER)


def measure(mesh: Any, element: Element, solver: str, repeats: int) -> dict[str, Any]:
    """Time one mesh, element and solver."""
    held = np.flatnonzero(mesh.rest_positions[:, 0] >= 0.07 - 1e-9).astype(np.int32)
    begun = time.perf_counter()
    body = StaticBody(mesh, element, held, solver=solver)
    setup = time.perf_counter() - begun
    first = uniform_material(mesh.tet_count)
    second = uniform_material(mesh.tet_count, 1.05 * MODULUS)
    begun = time.perf_counter()
    state = body.solve_equilibrium(first, GRAVITY)
    first_call = time.perf_counter() - begun

    def gradient() -> None:
        body.gradient(np.ones_like(body.state.positions))

    def cold() -> None:
        body.forget()
        body.solve_equilibrium(first, GRAVITY)
        gradient()

    tangent = None

    def go_back() -> None:
        nonlocal tangent
        body.forget()
        body.solve_equilibrium(first, GRAVITY)
        tangent = body.tangents([Change(youngs_modulus=first.youngs_modulus)])[0]

    def warm() -> None:
        body.solve_equilibrium(second, GRAVITY, prediction=np.log(1.05) * tangent)
        gradient()

    sag = float((state.positions - body.discretisation.rest_nodes)[:, 1].max())
    return {
        'tets': mesh.tet_count,
        'unknowns': body.solver.stiffness.pattern.size,
        'element': element.value,
        'solver': body.solver.stiffness.solver_name,
        'sag_mm': 1e3 * sag,
        'set_up_s': setup,
        'first_call_s': first_call,
        'cold': timed(cold, repeats=repeats),
        'warm': timed(warm, repeats=repeats, before=go_back),
    }


def main() -> None:
    """Run all combinations."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--solvers', nargs='+', default=['qdldl', 'multifrontal', 'superlu'])
    parser.add_argument('--repeats', type=int, default=15)
    parser.add_argument('--name', default='equilibrium')
    arguments = parser.parse_args()
    meshes = {name: mesh for name, mesh in cantilevers().items() if name != 'middle'}
    rows = []
    for name, mesh in meshes.items():
        for element in Element:
            if name == 'fine' and element is Element.QUADRATIC:
                continue
            for solver in arguments.solvers:
                repeats = arguments.repeats if name == 'coarse' else max(3, arguments.repeats // 3)
                rows.append({'mesh': name, **measure(mesh, element, solver, repeats)})
    write(arguments.name, {'rows': rows})


if __name__ == '__main__':
    main()
