# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""torch-fem: equilibrium and the tip's derivative by its own adjoint, linear and quadratic."""

from importlib.metadata import version
import time
from typing import Any

from clock import Case, run_studies, timed
import numpy as np
import torch
from torchfem import Solid
from torchfem.materials import Hyperelastic3D

# So many equal parts of the load are tried: the fastest that arrives is what is reported.
_PARTS = (1, 2, 4, 8)
_TOLERANCE = 1e-8
_BUDGET = 15.0


def energy(F: Any, constants: Any) -> Any:
    """Return our own law's energy density [J/m^3]: torch-fem takes any."""
    mu, lam = constants[..., 0], constants[..., 1]
    stretch = (F * F).sum((-1, -2))
    volume = (F[..., 0, :] * torch.linalg.cross(F[..., 1, :], F[..., 2, :], dim=-1)).sum(-1)
    shear = mu / 2 * (stretch - 3) - mu / 2 * torch.log((stretch + 1) / 4)
    return shear + lam / 2 * (volume - 1) ** 2 - 0.75 * mu * (volume - 1)


class Cantilever:
    """One mesh, solved from rest by a number of load steps."""

    def __init__(self, case: Case, suffix: str) -> None:
        nodes = case['nodes10'] if suffix else case['positions']
        self.case, self.nodes = case, torch.tensor(nodes)
        self.cells = torch.tensor(case['tets' + suffix])
        self.loads = torch.tensor(case['loads' + suffix])
        self.held = torch.tensor(np.asarray(case['held' + suffix], dtype=np.int64))
        self.displacement, self.slope = self.nodes, 0.0

    def solve(self, parts: int, *, with_gradient: bool) -> None:
        """Find the equilibrium, and the tip's derivative by the logarithm of E [m]."""
        logarithm = torch.zeros((), requires_grad=with_gradient)
        plain = torch.tensor([self.case['law_mu'], self.case['law_lambda']])
        constants = (torch.exp(logarithm) * plain).expand(len(self.cells), 2)
        body = Solid(self.nodes, self.cells, Hyperelastic3D(energy, constants))
        body.forces = self.loads
        body.constraints[self.held] = True
        # torch-fem's tolerance is relative to one part of the load, ours to the whole.
        moved = body.solve(
            increments=torch.linspace(0.0, 1.0, parts + 1),
            max_iter=25,
            rtol=_TOLERANCE * parts,
            atol=0.0,
            method='direct',
            differentiable_parameters=logarithm if with_gradient else None,
        )[0]
        if with_gradient:
            moved[self.case['tip'], 1].backward()
            self.slope = float(logarithm.grad)
        self.displacement = moved.detach()


def study(case: Case, suffix: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """Time one element with the best number of load steps."""
    body = Cantilever(case, suffix)
    _seconds(body, _PARTS[-1])  # Its first call does more.
    tried = {parts: _seconds(body, parts) for parts in _PARTS}
    arrived = {parts: seconds for parts, seconds in tried.items() if seconds is not None}
    best = min(arrived, key=lambda parts: arrived[parts])
    forward = timed(lambda: body.solve(best, with_gradient=False), budget=_BUDGET)
    both = timed(lambda: body.solve(best, with_gradient=True), budget=_BUDGET)
    figures = {
        'law': 'ours, given to it as an energy',
        'load_steps': best,
        'load_steps_tried_cpu_s': tried,
        'forward': forward,
        'both': both,
        'tip_slope_mm': 1e3 * body.slope,
    }
    return figures, {'displacement': body.displacement.numpy()}


def _seconds(body: Cantilever, parts: int) -> float | None:
    begun = time.process_time()
    try:
        body.solve(parts, with_gradient=False)
    except Exception:  # Too few steps: torch-fem says so in more than one way.
        return None
    return time.process_time() - begun


def main() -> None:
    """Measure both elements."""
    torch.set_default_dtype(torch.float64)
    torch.set_num_threads(1)
    run_studies(
        {name: version(name) for name in ('torch-fem', 'torch', 'pypardiso')},
        {
            'equilibrium_linear': lambda case: study(case, ''),
            'equilibrium_quadratic': lambda case: study(case, '10'),
        },
    )


if __name__ == '__main__':
    main()
