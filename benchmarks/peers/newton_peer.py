# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Newton physics: the released body by semi-implicit steps and a Warp tape."""

from importlib.metadata import version
import math
from typing import Any

from clock import Case, run_studies, timed
import newton
import numpy as np
import warp as wp

wp.config.quiet = True

# Tried from the longest on: the first whose tip ends where the shortest one's does is taken [s].
_STEPS = (8e-5, 6e-5, 5e-5, 4e-5, 3e-5, 2e-5)
_NEAR = 2e-3


@wp.kernel
def tip_height(positions: wp.array(dtype=wp.vec3), tip: int, loss: wp.array(dtype=float)):
    """Read the loss."""
    loss[0] = positions[tip][1]


class Swing:
    """One model with a state for every step: what the tape needs to go back."""

    def __init__(self, case: Case, step: float) -> None:
        self.case = case
        self.count = math.ceil(case['duration'] / step)
        self.step = case['duration'] / self.count
        self.model = self._model()
        # Else its particles push each other away.
        self.model.particle_grid = None
        self.solver = newton.solvers.SolverSemiImplicit(self.model, enable_tri_contact=False)
        self.control = self.model.control()
        self.loss = wp.zeros(1, dtype=float, requires_grad=True)
        self.states: list[Any] = []
        self.tape: Any = None

    def _model(self) -> Any:
        case = self.case
        builder = newton.ModelBuilder(up_axis=newton.Axis.Y, gravity=(0.0, case['gravity'], 0.0))
        builder.add_soft_mesh(
            pos=(0.0, 0.0, 0.0),
            rot=wp.quat_identity(),
            scale=1.0,
            vel=(0.0, 0.0, 0.0),
            vertices=[tuple(point) for point in case['positions'].tolist()],
            indices=case['tets'].ravel().tolist(),
            density=case['density'],
            k_mu=case['law_mu'],
            k_lambda=case['law_lambda'],
            k_damp=0.0,
            add_surface_mesh_edges=False,
        )
        for vertex in case['held'].tolist():
            builder.particle_mass[vertex] = 0.0
        return builder.finalize(device='cpu', requires_grad=True)

    def forward(self) -> None:
        """Swing on the tape."""
        if not self.states:
            self.states = [self.model.state(requires_grad=True) for _ in range(self.count + 1)]
        self.states[0].particle_q.assign(self.case['start'].astype(np.float32))
        self.tape = wp.Tape()
        with self.tape:
            for now, after in zip(self.states, self.states[1:], strict=False):
                now.clear_forces()
                self.solver.step(now, after, self.control, None, self.step)
            wp.launch(
                tip_height,
                dim=1,
                inputs=[self.states[-1].particle_q, self.case['tip']],
                outputs=[self.loss],
            )

    def both(self) -> None:
        """Swing and go back."""
        self.forward()
        self.model.tet_materials.grad.zero_()
        self.tape.zero()
        self.tape.backward(loss=self.loss)

    def tip(self) -> Any:
        """Return where the tip is at the end [m], shape (3,)."""
        return self.states[-1].particle_q.numpy()[self.case['tip']]

    def arrive(self) -> Any:
        """Return where the tip ends, holding no states."""
        now, after = self.model.state(), self.model.state()
        now.particle_q.assign(self.case['start'].astype(np.float32))
        for _ in range(self.count):
            now.clear_forces()
            self.solver.step(now, after, self.control, None, self.step)
            now, after = after, now
        return now.particle_q.numpy()[self.case['tip']]


def motion(case: Case) -> tuple[dict[str, Any], dict[str, Any]]:
    """Time the longest stable step, forward and back."""
    ends = {step: Swing(case, step).arrive() for step in _STEPS}
    last = ends[_STEPS[-1]]
    stable = [step for step in _STEPS if np.abs(ends[step] - last).max() < _NEAR]
    swing = Swing(case, stable[0])
    forward = timed(swing.forward, budget=8.0)
    both = timed(swing.both, budget=16.0)
    by_constants = swing.model.tet_materials.grad.numpy().astype(float).sum(axis=0)
    slope = by_constants[:2] @ np.array([case['law_mu'], case['law_lambda']])
    figures = {
        'law': 'ours',
        'precision': 'single',
        'time_step_s': swing.step,
        'steps': swing.count,
        'time_steps_stable_s': stable,
        'forward': forward,
        'both': both,
        'tip_slope_at_fixed_start_mm': 1e3 * float(slope),
    }
    by_start = swing.states[0].particle_q.grad.numpy()
    return figures, {'tip': swing.tip(), 'fine_tip': last, 'by_start': by_start}


if __name__ == '__main__':
    names = {'newton': 'newton', 'warp': 'warp-lang'}
    run_studies({key: version(name) for key, name in names.items()}, {'motion': motion})
