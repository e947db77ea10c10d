# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fit scenes that `diffcal init` proposes beside those made by hand; resumes where it stopped.

    python -m benchmarks.proposed_scenes --out DIR [--data DATASET] [--only NAME]

Nothing is typed but the marker; the unit where sizes leave it open. DATASET is a clone of the
public DiffCal data; without it its captures are left out. The synthetic bodies are those of the
zoo, filmed as 20-node hexahedra smaller than the tetrahedra that are fitted; their scenes by hand
state the true placement and clamp. Writes DIR/<name>/answer.json and
benchmarks/results/proposed_scenes.json of all that are in DIR.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatch
import json
import math
from pathlib import Path
import sys
import time
from typing import Any

from diffcal_ros.atomic_file import write_text_atomically
from diffcal_ros.calibration.calibrate import calibrate
from diffcal_ros.errors import InputError
from diffcal_ros.offline.calibrate_recordings import open_inputs
from diffcal_ros.proposal.hold import Hold
from diffcal_ros.proposal.propose import Proposal, propose, Question
from diffcal_ros.proposal.save_draft import save_draft
from diffcal_ros.recording.dataset.import_case import import_case
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.model import Scene
import numpy as np

from benchmarks.measuring import write
from benchmarks.zoo.recording import film, Filmed

CAPTURES = ('h_e_c', 'h_e_s')
FILMED = {
    'synthetic_notched_finger': Filmed('notched_finger', 800e3, ((-90.0, 0.0, 0.0),)),
    'synthetic_tube': Filmed('tube', 150e3, ((0.0, 0.0, -25.0),)),
    'synthetic_fin_ray': Filmed('fin_ray', 200e3),
}
_SAMPLE = Path(__file__).parents[1] / 'bags' / 'sample' / 'scene.yaml'
_MODULUS = 'youngs_modulus'
_CLOSE = 0.003  # What the plane of a clamp may be off without a doubt [m].


@dataclass(frozen=True)
class Task:
    """A recording, and the scene that a person made for it.

    Attributes:
        scene: file of that.
        truth: true modulus [Pa], or None.
    """

    scene: Path
    truth: float | None = None


def main() -> int:
    """Run the program; return its exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--out', type=Path, required=True)
    parser.add_argument('--data', type=Path, help='public data set')
    parser.add_argument('--only', default='*', help='pattern of names')
    given = parser.parse_args()
    names = ('sample', *CAPTURES, *FILMED)
    for name in names:
        file = given.out / name / 'answer.json'
        is_here = given.data is not None or name not in CAPTURES
        if fnmatch(name, given.only) and is_here and not file.is_file():
            print(name, flush=True)
            answer = compare(_task(name, given.data, file.parent), file.parent)
            write_text_atomically(file, json.dumps(answer, indent=1) + '\n')
    found = {
        name: json.loads(file.read_text())
        for name in names
        if (file := given.out / name / 'answer.json').is_file()
    }
    write('proposed_scenes', found)
    for name, answer in found.items():
        print(_line(name, answer))
    return 0


def _task(name: str, data: Path | None, folder: Path) -> Task:
    if name == 'sample':
        truth = json.loads(_SAMPLE.with_name('truth.json').read_text())
        (region,) = truth['parameters'].values()
        return Task(_SAMPLE, region[_MODULUS])
    if name in FILMED:
        return Task(film(FILMED[name], folder / 'by_hand'), FILMED[name].youngs_modulus)
    assert data is not None
    return Task(import_case(data, name, folder / 'by_hand', overwrite=True).scene)


def compare(task: Task, folder: Path) -> dict[str, Any]:
    """Propose a scene, fit it and that made by hand, and return what came of it."""
    by_hand = load_scene(task.scene)
    asked: list[str] = []

    def answer_unit(question: str, units: Sequence[str]) -> str:
        asked.append(question)
        return str(by_hand.document['mesh']['unit'])

    begun = time.process_time()
    mesh = task.scene.parent / by_hand.document['mesh']['file']
    bag = task.scene.parent / by_hand.document['bag']
    known = Question(marker=by_hand.marker)
    try:
        proposal = propose(mesh, [bag], known, ask_unit=answer_unit)
    except InputError as error:
        return {'refused': str(error).replace(str(bag), 'the recording')}
    seconds = time.process_time() - begun
    path = save_draft(proposal.draft, folder / 'proposed' / 'scene.yaml')
    fits = {'by_hand': _fit(task.scene), 'proposed': _fit(path)}
    return {
        'truth_kPa': None if task.truth is None else 1e-3 * task.truth,
        **fits,
        'difference_over_error': _apart(fits['by_hand'], fits['proposed']),
        'clamp': _clamps(by_hand, proposal),
        'unit_was_asked': bool(asked),
        'doubts': list(proposal.doubts),
        'proposal_cpu_s': round(seconds, 1),
    }


def _fit(path: Path) -> dict[str, Any]:
    """Calibrate a scene as the command does."""
    begun = time.process_time()
    inputs = open_inputs(load_scene(path), [])
    result = calibrate(inputs.scene, inputs.observations)
    modulus = result[_MODULUS]
    return {
        'outcome': result.outcome.value,
        'kPa': 1e-3 * modulus.value,
        # Mesh error is left out: both scenes share the mesh.
        'error_kPa': 1e-3 * modulus.error_in_model,
        'without_mesh_error_kPa': 1e-3 * modulus.fine_value,
        'interval_95_kPa': [1e-3 * end for end in modulus.interval_95],
        'others_as_good_kPa': [
            1e-3 * own.values[_MODULUS] for own in result.alternatives if own.is_as_good
        ],
        'gap_median_mm': 1e3 * result.gap_end.median,
        'coverage': result.gap_end.coverage,
        'warnings': list(result.warnings),
        'cpu_s': round(time.process_time() - begun, 1),
    }


def _apart(one: dict[str, Any], other: dict[str, Any]) -> float:
    """Return how far two moduli are apart over their standard errors together."""
    error = math.hypot(one['error_kPa'], other['error_kPa'])
    return abs(one['kPa'] - other['kPa']) / error if error > 0.0 else math.nan


def _clamps(by_hand: Scene, proposal: Proposal) -> dict[str, Any]:
    """Compare how much of the body sticks out of either clamp."""
    rest = by_hand.mesh.rest_positions
    stated, own = _stated_hold(by_hand), proposal.draft.hold
    free = [1e3 * (hold.plane - float((rest @ hold.direction).min())) for hold in (stated, own)]
    clamp = proposal.found.fit.clamp
    apart = abs(free[1] - free[0])
    return {
        'free_by_hand_mm': free[0],
        'free_proposed_mm': free[1],
        'apart_mm': apart,
        'doubt_mm': 1e3 * clamp.doubt,
        'is_seen': clamp.is_seen,
        'is_same_end': bool(stated.direction @ own.direction > 0.5),
        'is_close': apart <= 1e3 * _CLOSE,
    }


def _stated_hold(scene: Scene) -> Hold:
    """Return the end and the plane that the only box of a scene holds the body from."""
    (part,) = scene.document['held'].values()
    ((axis, (low, high)),) = part['box'].items()
    direction = np.zeros(3)
    direction['xyz'.index(axis)] = 1.0 if math.isinf(high) else -1.0
    return Hold(direction, float(low) if math.isinf(high) else -float(high))


def _line(name: str, answer: dict[str, Any]) -> str:
    if 'refused' in answer:
        return f'{name}: refused, {answer["refused"]}'
    fits = [
        f'{own["kPa"]:.1f} +- {own["error_kPa"]:.1f} kPa ({own["outcome"]})'
        for own in (answer['by_hand'], answer['proposed'])
    ]
    return (
        f'{name}: by hand {fits[0]}, proposed {fits[1]}, {answer["difference_over_error"]:.1f} '
        f'errors apart, clamp {answer["clamp"]["apart_mm"]:.1f} mm off, '
        f'{len(answer["doubts"])} doubts, {answer["proposal_cpu_s"]:.0f} s'
    )


if __name__ == '__main__':
    sys.exit(main())
