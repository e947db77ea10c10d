# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""jax-fem: equilibrium and the tip's derivative by its own adjoint."""

from importlib.metadata import version
import importlib.util
import logging
import time
from typing import Any

from clock import Case, run_studies, timed
import jax
import jax.numpy as jnp
import numpy as np
from petsc_stand_in import stand_in

_HAS_PETSC = importlib.util.find_spec('petsc4py') is not None
if not _HAS_PETSC:
    stand_in()

from jax_fem.generate_mesh import Mesh  # noqa: E402
from jax_fem.problem import Problem  # noqa: E402
from jax_fem.solver import ad_wrapper, solver  # noqa: E402

_PARTS = (1, 2, 4, 8)
# jax-fem runs Newton's method until the residual is this share of the first one. It begins each
# part of the load at the end of the last one, so that the last first one is a part's load.
_TOLERANCE = 1e-8
_BUDGET = 6.0
_MOST_NEWTON_STEPS = 25
_DIRECT = {'umfpack_solver': {}}  # SciPy's, which is SuperLU where no UMFPACK is.


def energy(F: Any, mu: Any, lam: Any) -> Any:
    """Return our own law's energy density [J/m^3]."""
    stretch, volume = jnp.sum(F * F), jnp.linalg.det(F)
    shear = mu / 2 * (stretch - 3) - mu / 2 * jnp.log((stretch + 1) / 4)
    return shear + lam / 2 * (volume - 1) ** 2 - 0.75 * mu * (volume - 1)


class Hanging(Problem):
    """Our law under a share of the weight; parameters are (log of E over its value, share)."""

    def custom_init(self, mu: float, lam: float, weight: float) -> None:
        """Take the law's constants [Pa] and the weight of a volume [N/m^3]."""
        self.mu, self.lam, self.weight = mu, lam, weight

    def get_tensor_map(self) -> Any:
        """Return the first Piola-Kirchhoff stress."""

        def stress(gradient: Any, logarithm: Any, _: Any) -> Any:
            scale = jnp.exp(logarithm)
            return jax.grad(energy)(gradient + jnp.eye(3), scale * self.mu, scale * self.lam)

        return stress

    def get_mass_map(self) -> Any:
        """Return the weight, to be balanced."""
        return lambda _u, _x, _logarithm, share: jnp.array([0.0, -share * self.weight, 0.0])

    def newton_update(self, sol_list: Any) -> Any:
        """Count steps: jax-fem's own loop goes on for ever where it does not converge."""
        self.steps += 1
        if self.steps > _MOST_NEWTON_STEPS:
            raise RuntimeError(f'no equilibrium after {_MOST_NEWTON_STEPS} Newton steps')
        return super().newton_update(sol_list)

    def set_params(self, params: Any) -> None:
        """Spread (logarithm, share) over all quadrature points, and count steps anew."""
        self.steps = 0
        ones = jnp.ones((self.fes[0].num_cells, self.fes[0].num_quads))
        self.internal_vars = [params[0] * ones, params[1] * ones]


class Cantilever:
    """One mesh, solved from rest by a number of load steps."""

    def __init__(self, case: Case) -> None:
        nodes, held = case['positions'], np.asarray(case['held'])
        is_held = jnp.zeros(len(nodes), dtype=bool).at[held].set(True)
        clamp = [lambda _, index: is_held[index]] * 3, [0, 1, 2], [lambda _: 0.0] * 3
        self.problem = Hanging(
            Mesh(nodes, case['tets']),
            vec=3,
            dim=3,
            ele_type='TET4',
            dirichlet_bc_info=list(clamp),
            additional_info=(
                case['law_mu'],
                case['law_lambda'],
                case['density'] * case['gravity'],
            ),
        )
        self.tip, self.slope, self.moved = case['tip'], 0.0, nodes

    def solve(self, parts: int, *, with_gradient: bool) -> None:
        """Find the equilibrium, and the tip's derivative by the logarithm of E [m]."""
        options = {**_DIRECT, 'tol': 0.0, 'rel_tol': 1e-3}
        for part in range(1, parts):
            self.problem.set_params((0.0, part / parts))
            options['initial_guess'] = solver(self.problem, options)
        options['rel_tol'] = _TOLERANCE * parts
        find = ad_wrapper(self.problem, options, _DIRECT)
        if not with_gradient:
            self.moved = np.asarray(find((0.0, 1.0))[0])
            return
        found, pull_back = jax.vjp(lambda logarithm: find((logarithm, 1.0))[0], jnp.zeros(()))
        self.slope = float(pull_back(jnp.zeros_like(found).at[self.tip, 1].set(1.0))[0])
        self.moved = np.asarray(found)


def study(case: Case) -> tuple[dict[str, Any], dict[str, Any]]:
    """Time the linear element with the best number of load steps."""
    body = Cantilever(case)
    compiling = timed(lambda: body.solve(_PARTS[-1], with_gradient=False), repeats=1)
    tried = {parts: _seconds(body, parts) for parts in _PARTS}
    arrived = {parts: seconds for parts, seconds in tried.items() if seconds is not None}
    best = min(arrived, key=lambda parts: arrived[parts])
    forward = timed(lambda: body.solve(best, with_gradient=False), budget=_BUDGET)
    forward['compile_cpu_s'] = compiling['compile_cpu_s']
    both = timed(lambda: body.solve(best, with_gradient=True), budget=_BUDGET)
    figures = {
        'law': 'ours, given to it as an energy',
        'matrix': 'petsc4py' if _HAS_PETSC else 'SciPy in place of petsc4py, which has no wheel',
        'load_steps': best,
        'load_steps_tried_cpu_s': tried,
        'forward': forward,
        'both': both,
        'tip_slope_mm': 1e3 * body.slope,
    }
    return figures, {'displacement': body.moved}


def _seconds(body: Cantilever, parts: int) -> float | None:
    begun = time.process_time()
    try:
        body.solve(parts, with_gradient=False)
    except Exception:  # Too few steps end in numbers that are none.
        return None
    return time.process_time() - begun


def main() -> None:
    """Measure the linear element; the quadratic one was not run to its end."""
    logging.getLogger('jax_fem').setLevel(logging.WARNING)
    run_studies(
        {name: version(name) for name in ('jax-fem', 'jax', 'fenics-basix', 'scipy')},
        {'equilibrium_linear': study},
    )


if __name__ == '__main__':
    main()
