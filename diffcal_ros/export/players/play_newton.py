# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Build the body of body.npz in Newton and let it sink: `python play_newton.py`.

Needs `pip install newton`. `SolverSemiImplicit` is given the constants of Smith et al. 2018 and as
short a step as is stable, and damps the slowest swing as the material does; `--solver vbd` takes
Lame's parameters and longer steps, which it ends far from their solution unless it has many
iterations, and has no damping of the material.
"""

import argparse
from collections.abc import Mapping
import math
from pathlib import Path

import newton
import numpy as np
import warp as wp

_VBD_STEP = 1.0 / 300.0
# Of the time that a wave takes through the lowest tetrahedron at rest; with half of it bodies
# near nu = 0.5 burst once they are bent.
_STABLE = 0.2
_SEMI_IMPLICIT, _VBD = 'semi_implicit', 'vbd'


def load(path: Path) -> dict[str, np.ndarray]:
    """Return the arrays of a file by name."""
    with np.load(path) as content:
        return {name: content[name] for name in content.files}


def build(
    body: Mapping[str, np.ndarray],
    solver: str = _SEMI_IMPLICIT,
    damping: float | np.ndarray = 0.0,
) -> newton.ModelBuilder:
    """Return a builder with the body, its clamp and gravity, in a solver's own constants."""
    kind = 'neo_hookean' if solver == _SEMI_IMPLICIT else 'lame'
    builder = newton.ModelBuilder(gravity=tuple(body['gravity'].tolist()))
    builder.add_soft_mesh(
        pos=wp.vec3(0.0, 0.0, 0.0),
        rot=wp.quat_identity(),
        scale=1.0,
        vel=wp.vec3(0.0, 0.0, 0.0),
        vertices=[wp.vec3(*vertex) for vertex in body['vertices'].tolist()],
        indices=body['tets'].reshape(-1).tolist(),
        density=float(body['density'].mean()),
        k_mu=body[f'{kind}_mu'],
        k_lambda=body[f'{kind}_lambda'],
        k_damp=damping,
        # By default particles collide within decimetres: `SolverSemiImplicit` bursts the body.
        particle_radius=0.0,
    )
    # One density is taken; regions may have several, so the masses are set as they are.
    masses = body['vertex_masses'].copy()
    masses[body['held']] = 0.0
    builder.particle_mass[:] = masses.tolist()
    if solver == _VBD:
        builder.color()
    return builder


def stable_step(body: Mapping[str, np.ndarray]) -> float:
    """Return the longest step of `SolverSemiImplicit` that is taken [s]."""
    corners = body['vertices'][body['tets']]
    edges = np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2)
    # A tetrahedron's heights are one over the lengths of its shape functions' gradients.
    gradients = np.linalg.inv(edges)
    slopes = np.concatenate([gradients, -gradients.sum(axis=1, keepdims=True)], axis=1)
    heights = 1.0 / np.linalg.norm(slopes, axis=2).max(axis=1)
    speeds = np.sqrt((body['lame_lambda'] + 2.0 * body['lame_mu']) / body['density'])
    # What damps such a wave holds its step down, too.
    slowed = body['gradient_damping'] / (body['density'] * heights * speeds)
    return float(_STABLE * (heights / speeds / (1.0 + slowed)).min())


class Stepper:
    """A body in Newton that is stepped by `SolverSemiImplicit`, on the processor or a GPU.

    Attributes:
        step: [s].
    """

    def __init__(
        self, body: Mapping[str, np.ndarray], start: np.ndarray, smoothing: float | None = None
    ) -> None:
        """Build the body where a simulation begins.

        Args:
            body: arrays of the file.
            start: vertices [m], shape (V, 3).
            smoothing: damping of waves by the rate of the deformation gradient, as Rayleigh's
                factor in steps, in place of the material's damping.
        """
        self.step = stable_step(body)
        stiffness = float((body['lame_lambda'] + 2.0 * body['lame_mu']).min())
        damping = (
            body['gradient_damping'] if smoothing is None else smoothing * self.step * stiffness
        )
        model = build(body, damping=damping).finalize()
        self._solver = newton.solvers.SolverSemiImplicit(model, enable_tri_contact=False)
        self._now, self._next = model.state(), model.state()
        self._control = model.control()
        self._now.particle_q.assign(start.astype(np.float32))

    @property
    def positions(self) -> np.ndarray:
        """Of the vertices [m], shape (V, 3)."""
        return np.array(self._now.particle_q.numpy(), dtype=float)

    @property
    def velocities(self) -> np.ndarray:
        """Of the vertices [m/s], shape (V, 3)."""
        return np.array(self._now.particle_qd.numpy(), dtype=float)

    def advance(self, steps: int) -> None:
        """Take so many steps."""
        for _ in range(steps):
            self._now.clear_forces()
            self._solver.step(self._now, self._next, self._control, None, self.step)
            self._now, self._next = self._next, self._now

    def stop(self) -> None:
        """Take all velocity away."""
        self._now.particle_qd.zero_()


def play(path: Path, seconds: float) -> np.ndarray:
    """Step the body and print how far it sinks; return the displacements [m], shape (V, 3)."""
    body = load(path)
    rest = body['vertices']
    stepper = Stepper(body, rest)
    _introduce(body)
    reports = max(1, round(10.0 * seconds))
    for number in range(1, reports + 1):
        stepper.advance(math.ceil(seconds / reports / stepper.step))
        _tell(number * seconds / reports, stepper.positions - rest)
    return stepper.positions - rest


def play_vbd(path: Path, seconds: float, iterations: int) -> np.ndarray:
    """Do the same by `SolverVBD`."""
    body = load(path)
    _introduce(body)
    model = build(body, _VBD).finalize()
    solver = newton.solvers.SolverVBD(model, iterations=iterations)
    state, after = model.state(), model.state()
    control, rest = model.control(), state.particle_q.numpy().copy()
    for number in range(1, round(seconds / _VBD_STEP) + 1):
        solver.step(state, after, control, None, _VBD_STEP)
        state, after = after, state
        if number % 30 == 0:
            _tell(number * _VBD_STEP, state.particle_q.numpy() - rest)
    return np.asarray(state.particle_q.numpy() - rest, dtype=float)


def _introduce(body: Mapping[str, np.ndarray]) -> None:
    print(f'{len(body["vertices"])} vertices, {body["vertex_masses"].sum():.4g} kg')


def _tell(time: float, moved: np.ndarray) -> None:
    largest = np.linalg.norm(moved, axis=1).max()
    print(f'{time:6.3f} s  moved by up to {1e3 * largest:.3f} mm')


def main() -> None:
    """Play the asset beside this script."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--seconds', type=float, default=1.0)
    parser.add_argument('--solver', choices=(_SEMI_IMPLICIT, _VBD), default=_SEMI_IMPLICIT)
    parser.add_argument('--iterations', type=int, default=20, help='of VBD in each step')
    args = parser.parse_args()
    path = Path(__file__).with_name('body.npz')
    if args.solver == _VBD:
        play_vbd(path, args.seconds, args.iterations)
    else:
        play(path, args.seconds)


if __name__ == '__main__':
    main()
