# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Equilibrium and gradient of a hanging cantilever, cold and after a 5 % change of modulus."""

import argparse
import time
from typing import Any

from diffcal_ros.fem.element import Element
from diffcal_ros.fem.force_changes import Change
from diffcal_ros.fem.static_body import StaticBody
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


def torch_fem(mesh: Any) -> dict[str, Any]:
    """The same equilibrium and gradient by torch-fem, where it is installed."""
    import torch
    from torchfem import Solid
    from torchfem.materials import Hyperelastic3D

    torch.set_default_dtype(torch.float64)
    torch.set_num_threads(1)

    def energy(F: Any, numbers: Any) -> Any:
        mu, lam = numbers[..., 0], numbers[..., 1]
        stretch = (F * F).sum((-1, -2))
        volume = (F[..., 0, :] * torch.linalg.cross(F[..., 1, :], F[..., 2, :], dim=-1)).sum(-1)
        shear = mu / 2 * (stretch - 3) - mu / 2 * torch.log((stretch + 1) / 4)
        return shear + lam / 2 * (volume - 1) ** 2 - 0.75 * mu * (volume - 1)

    mu = torch.tensor(69.27e3, requires_grad=True)
    numbers = torch.stack([mu, 49 * mu]).expand(mesh.tet_count, 2)
    body = Solid(
        torch.tensor(mesh.rest_positions),
        torch.tensor(mesh.tets.astype(np.int64)),
        Hyperelastic3D(energy, numbers),
    )
    masses = np.bincount(mesh.tets.ravel(), np.repeat(mesh.volumes / 4.0, 4)) * 1080.0
    body.forces[:, 1] = torch.tensor(masses * 9.8)
    body.constraints[torch.tensor(mesh.rest_positions[:, 0] >= 0.07 - 1e-9)] = True
    begun = time.perf_counter()
    displacement = body.solve(
        increments=torch.linspace(0, 1, 41), max_iter=40, differentiable_parameters=mu
    )[0]
    displacement.sum().backward()
    return {
        'tets': mesh.tet_count,
        'sag_mm': 1e3 * float(displacement[:, 1].max().detach()),
        'cold_s': time.perf_counter() - begun,
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
    figures: dict[str, Any] = {'rows': rows}
    try:
        figures['torch_fem'] = torch_fem(meshes['coarse'])
    except ImportError:
        figures['torch_fem'] = 'not installed'
    else:
        ours = next(
            r for r in rows if r['mesh'] == 'coarse' and r['element'] == Element.LINEAR.value
        )
        figures['torch_fem']['ratio'] = figures['torch_fem']['cold_s'] / ours['cold']['median_s']
    write(arguments.name, figures)


if __name__ == '__main__':
    main()
