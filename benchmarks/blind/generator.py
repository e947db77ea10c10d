# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Write the cases of a set.

    python -m benchmarks.blind.generator --set development --out DIR [--only 'clean_0*'] [--jobs 2]
                                         [--motion] [--forms]

With --motion they are of released bodies instead of bodies at rest, with --forms of effects in
other forms than the library's, in worlds where sensor and poses are a little off. DIR/cases/<id>
is what the workflow sees, DIR/labels/<id>.json what it must not. Cases that are there already are
left as they are.
"""

import argparse
from concurrent.futures import as_completed, ProcessPoolExecutor
from dataclasses import replace
from fnmatch import fnmatch
import json
import os
from pathlib import Path
import shutil
import sys
import time

import numpy as np

from benchmarks.blind.amplitudes import combined, direction, Effect, LIBRARY, MOTION, OUTSIDE
from benchmarks.blind.bag import write_bag
from benchmarks.blind.cases import (
    Case,
    FORM_SETS,
    list_cases,
    list_form_cases,
    list_motion_cases,
    list_motion_form_cases,
    SETS,
)
from benchmarks.blind.eighteenth_outside import EIGHTEENTH_OUTSIDE
from benchmarks.blind.eighth_outside import EIGHTH_OUTSIDE
from benchmarks.blind.eleventh_outside import ELEVENTH_OUTSIDE
from benchmarks.blind.faults import Faults
from benchmarks.blind.fifteenth_outside import FIFTEENTH_OUTSIDE
from benchmarks.blind.forms import BY_KEY, off_the_truth, placed_again
from benchmarks.blind.fourteenth_outside import FOURTEENTH_OUTSIDE
from benchmarks.blind.labels import label_of, write_json
from benchmarks.blind.laying import lay_on_plane, softer
from benchmarks.blind.motion_forms import MOTION_FORMS
from benchmarks.blind.nineteenth_outside import NINETEENTH_OUTSIDE
from benchmarks.blind.ninth_outside import NINTH_OUTSIDE
from benchmarks.blind.observe import camera_center, film, record, true_rendering
from benchmarks.blind.other_rigs import OtherSetup
from benchmarks.blind.other_sets import (
    draw_other_case,
    list_other_cases,
    OTHER_SETS,
    rig_label,
)
from benchmarks.blind.outside_forms import FURTHER_OUTSIDE
from benchmarks.blind.rubber import draw_rubber
from benchmarks.blind.scene_file import extra_text, scene_text
from benchmarks.blind.sensor import smooth_field
from benchmarks.blind.setups import draw_setup, Setup
from benchmarks.blind.seventeenth_outside import SEVENTEENTH_OUTSIDE
from benchmarks.blind.seventh_outside import SEVENTH_OUTSIDE
from benchmarks.blind.shutter import filmed_views
from benchmarks.blind.simulation import make_specimen, settle, Specimen
from benchmarks.blind.sixteenth_outside import SIXTEENTH_OUTSIDE
from benchmarks.blind.stamping import stamps
from benchmarks.blind.swing_set import (
    draw_swing_set_timing,
    list_swing_set_cases,
    SWING_SET_EFFECTS,
    SWING_SETS,
)
from benchmarks.blind.tenth_outside import TENTH_OUTSIDE
from benchmarks.blind.tetrahedra import mesh_tetrahedra, write_vtk
from benchmarks.blind.thirteenth_outside import THIRTEENTH_OUTSIDE
from benchmarks.blind.thirtieth_outside import THIRTIETH_OUTSIDE
from benchmarks.blind.thirtyfirst_outside import THIRTYFIRST_OUTSIDE
from benchmarks.blind.thirtysecond_outside import THIRTYSECOND_OUTSIDE
from benchmarks.blind.thirtythird_outside import THIRTYTHIRD_OUTSIDE
from benchmarks.blind.timing import draw_hold, draw_swing, Timing
from benchmarks.blind.twelfth_outside import TWELFTH_OUTSIDE
from benchmarks.blind.twentieth_outside import TWENTIETH_OUTSIDE
from benchmarks.blind.twentyeighth_outside import TWENTYEIGHTH_OUTSIDE
from benchmarks.blind.twentyfifth_outside import TWENTYFIFTH_OUTSIDE
from benchmarks.blind.twentyfirst_outside import TWENTYFIRST_OUTSIDE
from benchmarks.blind.twentyfourth_outside import TWENTYFOURTH_OUTSIDE
from benchmarks.blind.twentyninth_outside import TWENTYNINTH_OUTSIDE
from benchmarks.blind.twentysecond_outside import TWENTYSECOND_OUTSIDE
from benchmarks.blind.twentyseventh_outside import TWENTYSEVENTH_OUTSIDE
from benchmarks.blind.twentysixth_outside import TWENTYSIXTH_OUTSIDE
from benchmarks.blind.twentythird_outside import TWENTYTHIRD_OUTSIDE

# A motion is many simulations: its mesh has longer cells.
_MOTION_COARSENING = 1.7
_FIXTURE_ERROR = 1.0  # Of where a fixture is stated [mm].


def write_case(case: Case, out: Path) -> float:
    """Write one case and its label; return the seconds it took."""
    begun = time.perf_counter()
    target, label = out / 'cases' / case.id, out / 'labels' / f'{case.id}.json'
    if target.exists() and label.exists():
        return 0.0
    setup, effects, faults = draw_case(case)
    timing = draw_timing(case, effects) if case.is_moving else None
    specimen = make_specimen(setup, faults)
    fresh = target.with_name(f'.{case.id}.{os.getpid()}')
    shutil.rmtree(fresh, ignore_errors=True)
    fresh.mkdir(parents=True)
    try:
        _write_seen(case, setup, specimen, faults, timing, fresh)
        label.parent.mkdir(parents=True, exist_ok=True)
        center = camera_center(specimen, setup)
        told = timing if case.set_name in SWING_SETS else None
        content = label_of(case, setup, effects, faults, center, told)
        if isinstance(setup, OtherSetup):
            content['rig'] = rig_label(setup)
        write_json(label, content)
        shutil.rmtree(target, ignore_errors=True)
        fresh.rename(target)
    finally:
        shutil.rmtree(fresh, ignore_errors=True)
    return time.perf_counter() - begun


def draw_case(case: Case) -> tuple[Setup, tuple[Effect, ...], Faults]:
    """Draw a case's set-up, effects and faults."""
    if case.set_name in OTHER_SETS:
        return draw_other_case(case)
    setup = draw_setup(
        case.family,
        is_sealed=case.set_name != 'development',
        poses=case.poses,
        random=case.random('setup'),
    )
    if case.sensor is not None:
        setup = off_the_truth(setup, case.sensor, case.random('world'))
    if case.law is not None:
        setup = _in_a_world(setup, case.law, case.random('law'))
    forms = {form.key: form.effect for form in (*BY_KEY.values(), *MOTION_FORMS)}
    forms = {**forms, **SWING_SET_EFFECTS}
    earlier = {**OUTSIDE, **FURTHER_OUTSIDE, **SEVENTH_OUTSIDE, **EIGHTH_OUTSIDE}
    later = {**NINTH_OUTSIDE, **TENTH_OUTSIDE, **ELEVENTH_OUTSIDE, **TWELFTH_OUTSIDE}
    last = {**THIRTEENTH_OUTSIDE, **FOURTEENTH_OUTSIDE, **FIFTEENTH_OUTSIDE, **SIXTEENTH_OUTSIDE}
    newest = {**SEVENTEENTH_OUTSIDE, **EIGHTEENTH_OUTSIDE}
    newest = {**newest, **NINETEENTH_OUTSIDE, **TWENTIETH_OUTSIDE, **TWENTYFIRST_OUTSIDE}
    newest = {**newest, **TWENTYSECOND_OUTSIDE, **TWENTYTHIRD_OUTSIDE, **TWENTYFOURTH_OUTSIDE}
    newest = {**newest, **TWENTYFIFTH_OUTSIDE, **TWENTYSIXTH_OUTSIDE, **TWENTYSEVENTH_OUTSIDE}
    newest = {**newest, **TWENTYEIGHTH_OUTSIDE, **TWENTYNINTH_OUTSIDE, **THIRTIETH_OUTSIDE}
    newest = {**newest, **THIRTYFIRST_OUTSIDE, **THIRTYSECOND_OUTSIDE, **THIRTYTHIRD_OUTSIDE}
    drawers = {**LIBRARY, **MOTION, **earlier, **later, **last, **newest, **forms}
    random = case.random('effects')
    effects = tuple(drawers[name](size, setup, random) for name, size in case.effects)
    faults = combined(effects)
    if case.is_moving:
        # A body that hardly sags hardly swings.
        setup = softer(setup, 0.6)
    if faults.yeoh_ratio or faults.stiffening:
        # Stiffening shows where the strain is large.
        setup = softer(setup, 0.6 if faults.yeoh_ratio else 0.3)
    if faults.contact_height is not None:
        laid, faults = lay_on_plane(setup, faults, random)
        setup = placed_again(laid, setup)
    return setup, effects, faults


def _in_a_world(setup: Setup, law: str, random: np.random.Generator) -> Setup:
    """Make the body of a rubber, and state the fixture a millimetre off in every other case."""
    setup = replace(setup, rubber=draw_rubber(law, random))
    if random.random() < 0.5:
        return setup
    x, y, z = direction(1e-3 * _FIXTURE_ERROR, 3, random, digits=7)
    return replace(setup, fixture_shift=(x, y, z))


def draw_timing(case: Case, effects: tuple[Effect, ...]) -> Timing:
    """Draw when a case's body is let go; creep and every fourth clean case are held loads."""
    random = case.random('timing')
    if case.set_name in SWING_SETS:
        return draw_swing_set_timing(case, random)
    creeps = any(effect.identifier == 'creep' for effect in effects)
    is_slow = creeps or (case.kind == 'clean' and int(case.id[-3:]) % 4 == 3)
    return draw_hold(random) if is_slow else draw_swing(random)


def _write_seen(
    case: Case,
    setup: Setup,
    specimen: Specimen,
    faults: Faults,
    timing: Timing | None,
    folder: Path,
) -> None:
    """Write what the workflow sees."""
    coarsening = 1.0 if timing is None else _MOTION_COARSENING
    write_vtk(mesh_tetrahedra(setup.shape, coarsening), folder / 'mesh.vtk')
    (folder / 'scene.yaml').write_text(scene_text(setup, timing))
    (folder / 'extra.yaml').write_text(extra_text(setup, case.without))
    camera = setup.camera
    shape = (camera.height, camera.width)
    pattern = smooth_field(shape, setup.sensor.bias_length, case.random('pattern'))
    for observation in setup.observations:
        if timing is not None:
            views = filmed_views(specimen, setup, observation, faults, timing)
            filmed = film(views, setup, pattern, case.random(f'noise {observation.name}'))
            when = stamps(timing, faults)
            write_bag(folder / f'bag_{observation.name}', camera, filmed, when)
            continue
        positions = settle(specimen, setup, observation, faults)
        rendering = true_rendering(specimen, setup, observation, faults, positions)
        frames = record(rendering, setup, pattern, case.random(f'noise {observation.name}'))
        write_bag(folder / f'bag_{observation.name}', camera, frames)


def main(arguments: list[str] | None = None) -> int:
    """Run the program; return its exit status."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        '--set', choices=(*FORM_SETS, *SWING_SETS, *OTHER_SETS), required=True, dest='set_name'
    )
    parser.add_argument('--out', type=Path, required=True)
    parser.add_argument('--only', default='*', help='pattern of case names')
    parser.add_argument('--kind', default='*', help='clean, single, pair, outside, denied or form')
    parser.add_argument('--salt', default='', help='secret of a sealed set')
    parser.add_argument('--jobs', type=int, default=1)
    parser.add_argument('--motion', action='store_true', help='released bodies')
    parser.add_argument('--forms', action='store_true', help='effects in other forms')
    given = parser.parse_args(arguments)
    if given.set_name not in SETS and not given.forms:
        parser.error(f'the set {given.set_name} has other forms only: add --forms')
    if given.set_name in SWING_SETS and not given.motion:
        parser.error(f'the set {given.set_name} has motions only: add --motion')
    moving = ('sealed', *SWING_SETS)
    if given.motion and given.forms and given.set_name not in moving:
        parser.error(f'motions have other forms in some sets only: --set {" or ".join(moving)}')
    listed = {
        (False, False): list_cases,
        (True, False): list_motion_cases,
        (False, True): list_form_cases,
        (True, True): list_motion_form_cases,
    }[given.motion, given.forms]
    if given.set_name in SWING_SETS:
        listed = list_swing_set_cases
    if given.set_name in OTHER_SETS:
        listed = list_other_cases
    every = listed(given.set_name, given.salt)
    cases = [
        case for case in every if fnmatch(case.id, given.only) and fnmatch(case.kind, given.kind)
    ]
    if not cases:
        print(f'no case matches {given.only!r} and {given.kind!r}', file=sys.stderr)
        return 2
    return _write_all(cases, given.out, given.jobs)


def _write_all(cases: list[Case], out: Path, jobs: int) -> int:
    failures: dict[str, str] = {}
    begun = time.perf_counter()
    with ProcessPoolExecutor(jobs) as pool:
        tasks = {pool.submit(write_case, case, out): case for case in cases}
        for done, task in enumerate(as_completed(tasks), start=1):
            case = tasks[task]
            error = task.exception()
            if error is not None:
                failures[case.id] = f'{type(error).__name__}: {error}'
                print(f'{case.id} FAILED: {failures[case.id]}', file=sys.stderr, flush=True)
                continue
            spent = time.perf_counter() - begun
            print(
                f'{done}/{len(cases)} {case.id} {task.result():.1f} s, {spent:.0f} s in all',
                flush=True,
            )
    if failures:
        print(json.dumps(failures, indent=2), file=sys.stderr)
    return 1 if failures else 0


if __name__ == '__main__':
    sys.exit(main())
