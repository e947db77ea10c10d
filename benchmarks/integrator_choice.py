# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Implicit rules side by side: energy kept in an undamped swing, error of the path, time.

Behind docs/decisions/implicit-integrator.md. Every rule is put as x' -> (v', a', A'), so that
all share the same Newton steps.
"""

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
import time
from typing import Any

from diffcal_ros.damping import Damping
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.motion.dynamics import Dynamics
from diffcal_ros.fem.motion.generalised_alpha import StepRule, StepState
from diffcal_ros.fem.motion.held_nodes import HeldNodes
from diffcal_ros.fem.motion.implicit_march import _step, _StepFailedError, _tolerance
from diffcal_ros.fem.motion.inputs import MotionInputs, Release
from diffcal_ros.fem.motion.start import Start
from diffcal_ros.fem.motion.step_system import StepSystem
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.material import Material
from measuring import cantilevers, write
import numpy as np

GRAVITY = np.array([0.0, 9.8, 0.0])
_ALPHA = 'generalised-alpha {:g}'


@dataclass(frozen=True)
class LinearRule:
    """v' = rate x' + known, A' = rate v' + known: backward Euler, BDF2 and stages of TR-BDF2."""

    step: float
    rate: float
    position: Any
    velocity: Any

    @property
    def inertia(self) -> float:
        """Return dA'/dx'."""
        return self.rate**2

    def known(self, begin: StepState) -> StepState:
        """Return v', A' at x' = 0."""
        zero = np.zeros_like(begin.positions)
        return StepState(zero, self.position, zero, self.rate * self.position + self.velocity)

    def end(self, known: StepState, positions: Any) -> StepState:
        """Return the end for its positions."""
        return StepState(
            positions,
            known.velocities + self.rate * positions,
            np.zeros_like(positions),
            known.accelerations + self.inertia * positions,
        )


def _backward_euler(h: float, states: list[StepState]) -> Iterator[LinearRule]:
    now = states[-1]
    yield LinearRule(h, 1.0 / h, -now.positions / h, -now.velocities / h)


def _bdf2(h: float, states: list[StepState]) -> Iterator[LinearRule]:
    if len(states) < 2:
        yield from _backward_euler(h, states)
        return
    now, last = states[-1], states[-2]
    yield LinearRule(
        h,
        1.5 / h,
        (-2.0 * now.positions + 0.5 * last.positions) / h,
        (-2.0 * now.velocities + 0.5 * last.velocities) / h,
    )


def _tr_bdf2(h: float, states: list[StepState]) -> Iterator[LinearRule]:
    begin, share = states[-1], 2.0 - np.sqrt(2.0)
    rate = 2.0 / (share * h)
    yield LinearRule(
        share * h,
        rate,
        -rate * begin.positions - begin.velocities,
        -rate * begin.velocities - begin.accelerations,
    )
    middle = states[-1]
    rate = (2.0 - share) / ((1.0 - share) * h)
    near, far = 1.0 / (share * (2.0 - share)), (1.0 - share) ** 2 / (share * (2.0 - share))
    yield LinearRule(
        (1.0 - share) * h,
        rate,
        -rate * (near * middle.positions - far * begin.positions),
        -rate * (near * middle.velocities - far * begin.velocities),
    )
    del states[-2]


def _alpha(rho_inf: float) -> Any:
    def rules(h: float, states: list[StepState]) -> Iterator[StepRule]:
        yield StepRule(h, rho_inf)

    return rules


RULES = {
    'backward Euler': _backward_euler,
    'BDF2': _bdf2,
    'TR-BDF2': _tr_bdf2,
    **{_ALPHA.format(rho_inf): _alpha(rho_inf) for rho_inf in (0.0, 0.5, 0.7, 0.8, 0.9, 1.0)},
}


@dataclass
class Swing:
    """A cantilever under way from a start with no velocity."""

    body: StaticBody
    inputs: MotionInputs
    start: Any

    def run(self, name: str, h: float, duration: float) -> dict[str, Any]:
        """March with one rule."""
        dynamics = Dynamics(self.body)
        dynamics.take(self.inputs)
        system, held = StepSystem(dynamics), HeldNodes(self.body, None, np.zeros(6)).at(0.0)
        still = np.zeros_like(self.start)
        pull = dynamics.accelerations(self.start, still)
        states = [StepState(self.start, still, pull, pull)]
        tolerance, path, energies = _tolerance(dynamics), [], [self.energy(dynamics, states[0])]
        tip = int(np.argmin(self.start[:, 0]))
        begun = time.process_time()
        try:
            for _ in range(round(duration / h)):
                for rule in RULES[name](h, states):
                    now = states[-1]
                    guess = now.positions + rule.step * now.velocities
                    states.append(_step(dynamics, system, rule, now, held, guess, tolerance))
                del states[:-2]
                path.append(states[-1].positions[tip])
                energies.append(self.energy(dynamics, states[-1]))
        except _StepFailedError:
            return {'rule': name, 'step_s': h, 'fails_after_s': len(path) * h}
        seconds = time.process_time() - begun
        rest = self.body.solve_equilibrium(self.inputs.material, GRAVITY).positions
        swing = energies[0] - self.energy(dynamics, StepState(rest, still, pull, pull))
        return {
            'rule': name,
            'step_s': h,
            'loss': (energies[0] - energies[-1]) / swing,
            'loss_after_50_ms': (energies[0] - energies[round(0.05 / h)]) / swing,
            'cpu_s': seconds,
            'path': np.array(path),
        }

    @staticmethod
    def energy(dynamics: Dynamics, state: StepState) -> float:
        """Return kinetic, elastic and gravity's energy [J]."""
        body = dynamics.body
        moved = state.positions - body.discretisation.rest_nodes
        kinetic = 0.5 * float((dynamics.masses * state.velocities**2).sum())
        return (
            kinetic + body.elastic.energy(state.positions) - float((dynamics.loads * moved).sum())
        )


def swings(mesh: Any, element: Element) -> dict[str, Swing]:
    """Return a start that only the slow modes know, and the end let go from a ledge."""
    held = np.flatnonzero(mesh.rest_positions[:, 0] >= 0.07 - 1e-9).astype(np.int32)
    ledge = np.flatnonzero(mesh.rest_positions[:, 0] <= -0.09 + 1e-9).astype(np.int32)
    ones = np.ones(mesh.tet_count)
    material = Material(206e3 * ones, 0.49 * ones, 1080.0 * ones)
    body = StaticBody(mesh, element, held)
    inputs = MotionInputs(material, Damping(0.0 * ones), GRAVITY)
    weightless = body.solve_equilibrium(material, 0.2 * GRAVITY).positions
    supported = Start(body, Release(ledge, 0.0)).solve_equilibrium(
        inputs, mesh.rest_positions[held]
    )
    return {
        'weight set on': Swing(body, inputs, weightless),
        'ledge let go': Swing(body, inputs, supported),
    }


def main() -> None:
    """Run all rules."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--duration', type=float, default=2.0)
    parser.add_argument('--elements', nargs='+', default=['linear'])
    arguments = parser.parse_args()
    mesh, rows = cantilevers()['coarse'], []
    for element in map(Element, arguments.elements):
        for start, swing in swings(mesh, element).items():
            fine = swing.run(_ALPHA.format(0.8), 1.0 / 3840.0, 0.4).pop('path')[15::16]
            for name in RULES:
                row = swing.run(name, 1.0 / 240.0, arguments.duration)
                path = row.pop('path', None)
                if path is not None:
                    error = np.linalg.norm(path[:96] - fine, axis=1)
                    row['tip_error_mm'] = 1e3 * float(error.max())
                rows.append({'element': element.value, 'start': start, **row})
                print(rows[-1], flush=True)
    write('integrator_choice', {'duration_s': arguments.duration, 'rows': rows})


if __name__ == '__main__':
    main()
