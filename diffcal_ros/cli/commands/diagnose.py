# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""`diffcal diagnose`: say whether simulation and measurement disagree, and what is missing."""

import argparse
from typing import Any

from diffcal_ros.cli.options.recording_options import (
    add_input_options,
    add_recordings,
    asked_fit,
    open_asked,
)
from diffcal_ros.cli.say import say

_PAGE = 'diagnosis.html'
_UNKNOWN = 3
# A diagnosis of so many seconds is worth a faster solver.
_LONG = 30.0


def add_parser(subparsers: Any) -> None:
    """Add the subcommand."""
    parser = subparsers.add_parser(
        'diagnose',
        help='find out what the model lacks',
        description='Compare recordings with the model of SCENE, name the effect that the model '
        'lacks, and write DIR/verdict.json and DIR/diagnosis.html. Recordings of motions '
        'are diagnosed as well: the scene then needs `motion` (which support lets go, and when), '
        'as for `diffcal calibrate`. A swing also shows late stamps and drag of the air, a load '
        'that is held (`integrator: quasi_static`) creep. A rigid part in view, stated as '
        '`fixture` in the scene, tells whether the camera or the body is elsewhere.',
        epilog='Exit codes: 0 a verdict was reached; 2 bad input; 3 the data cannot tell.',
    )
    add_recordings(parser)
    add_input_options(parser)
    parser.add_argument(
        '--fit',
        metavar='NAME',
        nargs='+',
        action='extend',
        help="parameters of the model as it is (default: the scene's); an effect that is fitted "
        'is no candidate',
    )
    parser.add_argument(
        '--margin',
        metavar='MM',
        type=float,
        default=0.5,
        help='a gap above the floors that does not matter (default: %(default)g)',
    )
    parser.add_argument(
        '--without',
        metavar='EFFECT',
        nargs='+',
        default=[],
        help='effects that are ruled out beforehand',
    )
    parser.add_argument(
        '--jobs',
        metavar='N',
        type=int,
        help='models that are refitted at the same time, each in a process of its own, where '
        'there is much to refit (default: one a core)',
    )
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Diagnose, write the results and print them; return the exit code."""
    from diffcal_ros.diagnosis.answers import Verdict
    from diffcal_ros.offline.diagnose_recordings import run_diagnosis
    from diffcal_ros.report.pages.diagnosis_page import write_diagnosis_page
    from diffcal_ros.report.tables.verdict_text import verdict_lines
    from diffcal_ros.scene.load import load_scene

    scene = load_scene(args.scene)
    settings = _settings(args, scene)
    say('reading the recordings')
    inputs = open_asked(args, scene)
    for note in (*scene.notes, *inputs.notes):
        say(f'note: {note}')
    trace = run_diagnosis(inputs, settings, args.out, report=say)
    try:
        write_diagnosis_page(args.out / _PAGE, scene.name, trace)
    finally:
        print('\n'.join(verdict_lines(trace.diagnosis)))
    print(f'\npage      {args.out / _PAGE}')
    print(f'took      {trace.diagnosis.seconds:.0f} s')
    _suggest_solver(trace.diagnosis.seconds)
    effects = trace.diagnosis.effects
    if effects and not any(effect.course for effect in effects):
        print(f'to add it to the model: diffcal accept {args.out}')
    return _UNKNOWN if trace.diagnosis.verdict is Verdict.CANNOT_TELL else 0


def _settings(args: argparse.Namespace, scene: Any) -> Any:
    from diffcal_ros.calibration.forward.side_by_side import core_count
    from diffcal_ros.diagnosis.settings import DiagnosisSettings
    from diffcal_ros.effects.registry import EFFECTS
    from diffcal_ros.errors import InputError

    unknown = [name for name in args.without if name not in EFFECTS]
    if unknown:
        raise InputError(f'--without has {unknown[0]!r}: the library has {", ".join(EFFECTS)}')
    if not 0.0 <= args.margin <= 100.0:
        raise InputError(f'--margin is {args.margin:g} mm: give a number from 0 to 100')
    jobs = core_count() if args.jobs is None else args.jobs
    if jobs < 1:
        raise InputError(f'--jobs is {jobs}: give how many models may be refitted at once')
    fit = asked_fit(args, scene)
    without = tuple(args.without)
    return DiagnosisSettings(margin=1e-3 * args.margin, without=without, fit=fit, jobs=jobs)


def _suggest_solver(seconds: float) -> None:
    """Say what would make it faster, where that is worth an installation."""
    from diffcal_ros.fem.linear_solvers import fast_solver

    if seconds > _LONG and fast_solver() is None:
        say(
            'note: most of that went into factorising stiffness matrices; '
            "pip install 'diffcal_ros[fast]' (Intel's MKL) does it several times as fast"
        )
