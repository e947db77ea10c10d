# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Rest lengths of a finger's cable from random starts, and what a cable costs a solve.

    DIFFCAL_DATA=... python benchmarks/cables.py [FOLDER]

What is done in FOLDER (default: out/cables) is not done again.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
import os
from pathlib import Path
import sys
import time
from typing import Any

from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.fem.terms.conditions import Conditions
from diffcal_ros.recording.dataset.import_case import import_case
from diffcal_ros.reproduction.row import load_row, merged
from diffcal_ros.reproduction.run_row import run_row
from diffcal_ros.reproduction.summary import summarise
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.model import Scene
from diffcal_ros.scene.reading.yaml_document import read_yaml
from diffcal_ros.scene.sections.cables import cable_routes, start_cables
from diffcal_ros.scene.start_material import start_material
from measuring import write
import numpy as np
import yaml

_STARTS = 10
_ROUNDS = 7


def main() -> None:
    """Fit from ten starts a pull, then time solves with and without the cable."""
    dataset = os.environ.get('DIFFCAL_DATA')
    if not dataset:
        raise SystemExit('set DIFFCAL_DATA to a clone of the public DiffCal data set')
    out = Path(sys.argv[1] if len(sys.argv) > 1 else 'out/cables')
    row = load_row('cable')
    run_row(row, Path(dataset), out, starts=_STARTS, draw=lambda *_: None, report=print)
    fits: dict[str, Any] = {}
    for variant, summary in zip(row.variants, summarise(row, out, _STARTS), strict=True):
        assert variant.simulate is not None
        fits[variant.name] = {**summary.as_dict(), 'truth': _truths(out / row.name / variant.name)}
    write('cables', {'fits': fits, 'costs': _costs(Path(dataset), out)})


def _truths(folder: Path) -> dict[str, float]:
    """Return the true rest lengths [m]."""
    (path,) = folder.glob('recorded_*/truth.json')
    cables = yaml.safe_load(path.read_text())['cables']
    return {name: cable['rest_length'] for name, cable in cables.items()}


def _costs(dataset: Path, out: Path) -> dict[str, Any]:
    """Take CPU times of factorisations and equilibria of the finger pulled by 31 mm."""
    folder = out / 'costs'
    import_case(dataset, 'h_m_f', folder, overwrite=True)
    variant = next(v for v in load_row('cable').variants if v.name == 'pull_31')
    assert variant.simulate is not None
    document = merged(read_yaml(folder / 'scene.yaml').content, variant.simulate['truth'])
    (folder / 'pulled.yaml').write_text(yaml.safe_dump(document, sort_keys=False))
    scene = load_scene(folder / 'pulled.yaml')
    return {element.value: _cost(scene, element) for element in Element}


def _cost(scene: Scene, element: Element) -> dict[str, Any]:
    (setup,) = scene.observations
    held, via_count = setup.held[0].vertices, len(scene.cables[0].via_points)
    gravity = setup.world_from_object[:3, :3].T @ setup.gravity
    material, states = start_material(scene), start_cables(scene, setup)
    plain = StaticBody(scene.mesh, element, held)
    body = StaticBody(scene.mesh, element, held, cables=cable_routes(scene))
    works: dict[str, Callable[[], Any]] = {}
    for name, own in (('factor_without', plain), ('factor_with', body)):
        own.solve_equilibrium(material, gravity)
        values = own.solver.stiffness.values(own.state.positions)
        works[name] = partial(own.solver.stiffness._solver.factor, values)
    # What a low-rank update of every factorisation would take instead.
    sides = np.random.default_rng(0).normal(
        size=(plain.solver.stiffness.pattern.size, 3 * via_count)
    )
    works['solves_of_an_update'] = partial(plain.solver.stiffness._solver.solve, sides)

    def settle(length_change: float) -> None:
        longer = tuple(
            replace(state, rest_length=state.rest_length + length_change) for state in states
        )
        body.solve_equilibrium(material, gravity, conditions=Conditions(cables=longer))

    def settle_cold() -> None:
        body.forget()
        settle(0.0)

    works['equilibrium_cold'] = settle_cold
    # It follows the cold one in every round.
    works['equilibrium_after_1_mm'] = lambda: settle(0.001)
    figures = {name: min(seconds) for name, seconds in _cpu_seconds(works).items()}
    entries = {
        'without': plain.solver.stiffness.pattern.entry_count,
        'with': body.solver.stiffness.pattern.entry_count,
    }
    return {'cpu_s': figures, 'entries': entries}


def _cpu_seconds(works: dict[str, Callable[[], Any]]) -> dict[str, list[float]]:
    """Take turns, so that what else the machine does disturbs all alike."""
    seconds: dict[str, list[float]] = {name: [] for name in works}
    for _ in range(_ROUNDS):
        for name, work in works.items():
            begun = time.process_time()
            work()
            seconds[name].append(time.process_time() - begun)
    return seconds


if __name__ == '__main__':
    main()
