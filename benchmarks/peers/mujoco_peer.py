# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""MuJoCo's flex: the same body settled by its implicit integrator, and let go; no derivative."""

from importlib.metadata import version
from typing import Any

from clock import Case, run_studies, timed
import mujoco
import numpy as np

# Of the march to rest [s]: the implicit integrator takes energy out of so long steps by itself.
_SETTLE_STEP = 0.03
_MOST_STEPS = 2000
# Force left on the nodes as a share of all loads, as the finite-element packages measure it.
_TOLERANCE = 1e-8
_DIFFERENCE = 0.01
_MOTION_STEP = 1.0 / 240.0  # As our own.
_FINE_STEP = 1.0 / 3840.0


def _words(values: Any) -> str:
    return ' '.join(repr(value) for value in np.asarray(values).ravel().tolist())


def make_model(case: Case) -> Any:
    """Return the model: every free vertex a body on three slides, our lumped masses."""
    text = f"""
    <mujoco>
      <option gravity="0 {case['gravity']} 0" timestep="{_MOTION_STEP}" integrator="discrete"
              solver="Newton" tolerance="1e-12"/>
      <worldbody>
        <flexcomp name="body" type="direct" dim="3" radius="0.0001" mass="1"
                  point="{_words(case['positions'])}" element="{_words(case['tets'])}">
          <pin id="{_words(case['held'])}"/>
          <contact contype="0" conaffinity="0" selfcollide="none"/>
          <elasticity young="{case['modulus']}" poisson="{case['poisson']}" damping="0"/>
        </flexcomp>
      </worldbody>
    </mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    masses = np.asarray(case['loads'])[:, 1] / case['gravity']
    free = np.setdiff1d(np.arange(len(masses)), case['held'])
    model.body_mass[model.flex_vertbodyid[free]] = masses[free]
    mujoco.mj_setConst(model, mujoco.MjData(model))
    return model


class Flex:
    """One model; steps and settles."""

    def __init__(self, case: Case) -> None:
        self.model, self.tip = make_model(case), case['tip']
        self.data = mujoco.MjData(self.model)
        self.free = np.setdiff1d(np.arange(len(case['positions'])), case['held'])
        # Each free vertex has its three slides in the order of the axes.
        bodies = self.model.flex_vertbodyid[self.free]
        self.slots = self.model.body_dofadr[bodies][:, None] + np.arange(3)
        self.stiffness = self.model.flex_stiffness.copy()
        self.rest, self.steps, self.heights = case['positions'], 0, np.zeros(2)

    def begin(self, start: Any, step: float) -> None:
        """Put the vertices somewhere at rest, and choose a time step [s]."""
        mujoco.mj_resetData(self.model, self.data)
        self.model.opt.timestep = step
        self.data.qpos[self.slots] = (start - self.rest)[self.free]

    def settle(self, scale: float = 1.0, *, again: bool = False) -> float:
        """March to rest, with E scaled; return the tip's height over that at rest [m]."""
        self.model.flex_stiffness[:] = scale * self.stiffness
        if not again:
            self.begin(self.rest, _SETTLE_STEP)
        for self.steps in range(1, _MOST_STEPS + 1):
            mujoco.mj_step(self.model, self.data)
            loads = -self.data.qfrc_bias
            left = np.linalg.norm(self.data.qfrc_passive + loads)
            if self.steps > 1 and left < _TOLERANCE * np.linalg.norm(loads):
                return float(self.displacement()[self.tip, 1])
        raise RuntimeError(f'not at rest after {_MOST_STEPS} steps: {left:g} N left')

    def difference(self) -> None:
        """Settle, then twice more from there with E up and down."""
        self.settle()
        ends = [self.settle(1.0 + sign * _DIFFERENCE, again=True) for sign in (1.0, -1.0)]
        self.heights = np.array(ends)

    def displacement(self) -> Any:
        """Return where the vertices are less where they rest [m], shape (V, 3)."""
        moved = np.zeros_like(self.rest)
        moved[self.free] = self.data.qpos[self.slots]
        return moved

    def swing(self, case: Case, step: float) -> None:
        """Let the body go."""
        self.model.flex_stiffness[:] = self.stiffness
        self.begin(case['start'], step)
        for _ in range(round(case['duration'] / step)):
            mujoco.mj_step(self.model, self.data)


def equilibrium(case: Case) -> tuple[dict[str, Any], dict[str, Any]]:
    """Time settling alone, and with a central difference."""
    flex = Flex(case)
    forward = timed(flex.settle, budget=6.0)
    steps, moved = flex.steps, flex.displacement()
    both = timed(flex.difference, budget=6.0)
    slope = (flex.heights[0] - flex.heights[1]) / np.log((1 + _DIFFERENCE) / (1 - _DIFFERENCE))
    figures = {
        'law': 'its own, St. Venant-Kirchhoff',
        'derivative': 'a central difference of settled bodies',
        'steps': steps,
        'forward': forward,
        'both': both,
        'tip_slope_mm': 1e3 * float(slope),
    }
    return figures, {'displacement': moved}


def motion(case: Case) -> tuple[dict[str, Any], dict[str, Any]]:
    """Time the released body, forward only."""
    flex = Flex(case)
    forward = timed(lambda: flex.swing(case, _MOTION_STEP), budget=6.0)
    moved = flex.displacement()
    flex.swing(case, _FINE_STEP)
    figures = {
        'law': 'its own, St. Venant-Kirchhoff',
        'derivative': 'none',
        'time_step_s': _MOTION_STEP,
        'steps': round(case['duration'] / _MOTION_STEP),
        'forward': forward,
        'fine_step_s': _FINE_STEP,
    }
    return figures, {'tip': moved[flex.tip], 'fine_tip': flex.displacement()[flex.tip]}


if __name__ == '__main__':
    run_studies(
        {'mujoco': version('mujoco')}, {'equilibrium_linear': equilibrium, 'motion': motion}
    )
