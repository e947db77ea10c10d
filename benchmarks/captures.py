# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Diagnose the real captures of the public DiffCal data; resumes where it stopped.

    python -m benchmarks.captures --data DATASET --out DIR [--only 'h_em_c*']

DATASET is a clone of the data set, or what the archive unpacks to. Writes DIR/<study>/verdict.json
and benchmarks/results/captures.json.
"""

import argparse
from collections.abc import Callable
from dataclasses import dataclass, replace
from fnmatch import fnmatch
import json
from pathlib import Path
import sys
from typing import Any

from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.diagnosis.settings import DiagnosisSettings
from diffcal_ros.offline.calibrate_recordings import open_inputs
from diffcal_ros.offline.diagnose_recordings import run_diagnosis
from diffcal_ros.recording.dataset.import_case import import_case
from diffcal_ros.scene.load import load_scene
import numpy as np
import yaml

from benchmarks.measuring import machine, write

Edit = Callable[[dict[str, Any]], None]


def _as_it_is(document: dict[str, Any]) -> None:
    """Leave a scene as the import wrote it."""


def _one_material(document: dict[str, Any]) -> None:
    """Take both materials for one, as somebody would who does not know of the second."""
    constants = next(iter(document['regions'].values()))
    document['regions'] = {'body': {k: v for k, v in constants.items() if k != 'box'}}


def _as_seen(observation: Observation) -> Observation:
    return observation


def _against_ray_length(observation: Observation) -> Observation:
    """Let the data look to a z model as they do to a renderer that returns ray length."""
    depth = observation.depth
    stretched = np.linalg.norm(observation.camera.rays(), axis=-1)
    return replace(observation, depth=(depth / stretched).astype(depth.dtype))


@dataclass(frozen=True)
class Study:
    """One capture, and how it is looked at.

    Attributes:
        case: of the data set.
        edit: of the scene.
        pose: where the camera's pose comes from.
        fit: parameters; None: as the scene says, with a rigid offset.
        see: what is done to the observation.
    """

    case: str
    edit: Edit = _as_it_is
    pose: str = 'estimated'
    fit: tuple[str, ...] | None = None
    see: Callable[[Observation], Observation] = _as_seen


STUDIES = {
    'h_e_c_modulus_alone': Study('h_e_c', pose='stored', fit=('youngs_modulus',)),
    'h_e_c': Study('h_e_c'),
    'h_e_s': Study('h_e_s'),
    'h_em_c_one_material': Study('h_em_c', edit=_one_material),
    'h_em_c_two_materials': Study('h_em_c'),
    't_em_c_one_material': Study('t_em_c', edit=_one_material),
    't_em_c_two_materials': Study('t_em_c'),
    'h_e_c_ray_length': Study('h_e_c', see=_against_ray_length),
    'h_e_c_ray_length_modulus_alone': Study(
        'h_e_c', pose='stored', fit=('youngs_modulus',), see=_against_ray_length
    ),
}


def main() -> int:
    """Run the program; return its exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--data', type=Path, required=True)
    parser.add_argument('--out', type=Path, required=True)
    parser.add_argument('--only', default='*', help='pattern of study names')
    given = parser.parse_args()
    for name, study in STUDIES.items():
        folder = given.out / name
        if fnmatch(name, given.only) and not (folder / 'verdict.json').is_file():
            print(name, flush=True)
            look(given.data, study, folder)
    found = {
        name: summary(json.loads(file.read_text()))
        for name in STUDIES
        if (file := given.out / name / 'verdict.json').is_file()
    }
    print(write('captures', {'machine': machine(), 'studies': found}))
    return 0


def look(data: Path, study: Study, folder: Path) -> None:
    """Diagnose one capture."""
    imported = import_case(data, study.case, folder / 'scene', overwrite=True)
    document = yaml.safe_load(imported.scene.read_text())
    study.edit(document)
    path = imported.scene.with_name('studied.yaml')
    path.write_text(yaml.safe_dump(document, sort_keys=False))
    inputs = open_inputs(load_scene(path), [], pose_source=study.pose)
    takes = tuple(tuple(study.see(o) for o in take) for take in inputs.takes)
    inputs = replace(inputs, takes=takes)
    run_diagnosis(inputs, DiagnosisSettings(fit=study.fit), folder)


def summary(verdict: dict[str, Any]) -> dict[str, Any]:
    """Keep what the table shows."""
    candidates = {c['identifier']: c for c in verdict['details']['candidates']}
    told = [c for name, c in candidates.items() if name in verdict['ambiguity_set'][:3]]
    nearest = told or list(candidates.values())[:1]
    return {
        'verdict': verdict['verdict'],
        'evidence': verdict['evidence'],
        'ambiguity_set': verdict['ambiguity_set'],
        'unknown_class': verdict['unknown_class'],
        'amplitudes': {
            c['identifier']: {
                name: [c['amplitude'][name], c['std_error'][name], c['unit'][name]]
                for name in c['amplitude']
            }
            for c in nearest
        },
        'gap_mm': verdict['gap_mm'],
        'closure': verdict['closure'],
        'moduli_kPa': {
            when: {
                name: [None if p[own] is None else 1e-3 * p[own] for own in ('value', 'std_error')]
                for name, p in verdict['parameters'][when].items()
                if name.startswith('youngs_modulus')
            }
            for when in ('before', 'after')
        },
        'separating_recording': verdict['separating_recording'],
        'seconds': verdict['seconds'],
    }


if __name__ == '__main__':
    sys.exit(main())
