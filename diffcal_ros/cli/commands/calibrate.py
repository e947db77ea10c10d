# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""`diffcal calibrate`: fit a scene's parameters to recordings and report what was found."""

import argparse
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
import os
from pathlib import Path
from typing import Any, TYPE_CHECKING

from diffcal_ros.cli.options.effective_option import add_effective_option, fit_asked_effective
from diffcal_ros.cli.options.field_options import (
    add_field_options,
    fit_asked_field,
    is_field_asked,
)
from diffcal_ros.cli.options.recording_options import (
    add_input_options,
    add_recordings,
    asked_fit,
    open_asked,
)
from diffcal_ros.cli.read_scene import read_scene

if TYPE_CHECKING:
    from diffcal_ros.calibration.calibrate import Calibration
    from diffcal_ros.calibration.field.fit import FieldFit
    from diffcal_ros.calibration.results.result import CalibrationResult, IterationRecord
    from diffcal_ros.calibration.settings import CalibrationSettings
    from diffcal_ros.cli.progress import Progress
    from diffcal_ros.scene.model import Scene

_RESULT, _REPORT, _FITTED_SCENE = 'result.json', 'report.html', 'fitted_scene.yaml'
_USUAL = {'gauss_newton': 30, 'adam_demon': 100}
_ALL_LAWS = 'all'


def add_parser(subparsers: Any) -> None:
    """Add the subcommand."""
    parser = subparsers.add_parser(
        'calibrate',
        help='fit parameters to recordings',
        description='Fit the parameters of SCENE to depth recordings of the body, at rest or let '
        'go, and write DIR/result.json, DIR/report.html and DIR/fitted_scene.yaml.',
        epilog='Exit codes: 0 converged; 2 bad input; 3 no usable fit; 4 the model disagrees with '
        'the data; 5 several answers explain them about as well; see also `diffcal --help`.',
    )
    add_recordings(parser)
    add_input_options(parser.add_argument_group('what is read'))
    _add_fit_options(parser.add_argument_group('how it is fitted'))
    add_field_options(parser.add_argument_group('a modulus that varies over the body'))
    add_effective_option(parser.add_argument_group('other simulators'))
    parser.set_defaults(run=run)


def _add_fit_options(group: Any) -> None:
    group.add_argument(
        '--fit',
        metavar='NAME',
        nargs='+',
        action='extend',
        help="parameters to fit, such as youngs_modulus or rigid_offset (default: the scene's)",
    )
    group.add_argument(
        '--law',
        metavar='LAW',
        help="energy law, one of those in config/example_scene.yaml (default: the scene's); all: "
        'fit under each and rank them by the gap on pixels that the fit has not seen',
    )
    group.add_argument(
        '--loss',
        choices=('robust', 'paper', 'l1'),
        default='robust',
        help="robust: the body's own pixels and outline (default); paper and l1: the whole image",
    )
    group.add_argument(
        '--optimizer',
        choices=('gauss_newton', 'adam_demon'),
        default='gauss_newton',
        help="gauss_newton (default); adam_demon: the paper's, for paper and l1",
    )
    group.add_argument('--max-iterations', metavar='N', type=int, help='default: 30, Adam 100')
    _add_care_options(group)
    _add_machine_options(group)


def _add_care_options(group: Any) -> None:
    group.add_argument(
        '--profile',
        metavar='NAME',
        nargs='+',
        action='extend',
        default=[],
        help="give fitted parameters an interval by their likelihood's profile, too: right where "
        'the model bends within the error; each takes about as long as the fit',
    )
    group.add_argument(
        '--no-search',
        action='store_true',
        help='fit from the start values only; without it the whole range of modulus and placement '
        'is searched for where to start, other answers that explain the data are reported, and a '
        'body of several regions that is met in part is looked at for a step of depth in between',
    )
    group.add_argument(
        '--no-mesh-error',
        action='store_true',
        help='leave out what a finer mesh and shorter time steps would change',
    )


def _add_machine_options(group: Any) -> None:
    group.add_argument(
        '--solver',
        choices=(
            'auto',
            'pardiso',
            'cholmod',
            'multifrontal',
            'multifrontal_torch',
            'qdldl',
            'superlu',
        ),
        default='auto',
        help='sparse solver (default: the fastest that is installed)',
    )
    group.add_argument(
        '--device', metavar='DEVICE', default='cpu', help='cpu (default), or a GPU such as cuda:0'
    )


def run(args: argparse.Namespace) -> int:
    """Fit, write the results and print them; return the exit code."""
    from diffcal_ros.calibration.results.result import save_result
    from diffcal_ros.cli.progress import Progress
    from diffcal_ros.errors import InputError
    from diffcal_ros.scene.law_choice import with_law

    scene = read_scene(args.scene)
    if args.law is not None and args.law != _ALL_LAWS:
        scene = with_law(scene, args.law)
    settings = _settings(args, scene)
    progress = Progress(most_iterations=settings.max_iterations or _USUAL[settings.optimizer])
    args.what_is_left = partial(_what_is_left, args.out, progress)
    with progress:
        if args.law == _ALL_LAWS:
            return _rank(args, scene, settings, progress)
        calibration, result, field = _fit(args, scene, settings, progress)
        faults: list[str] = []
        if args.simulators and result.outcome.is_fitted:
            fitted = args.out / _FITTED_SCENE
            try:
                result = fit_asked_effective(args, fitted, calibration, result, field, progress)
                save_result(result, args.out / _RESULT)
            except InputError as error:  # The calibration itself is worth its report.
                faults.append(f'--for: {error}')
        progress.say('writing scene and report')
    return _write_and_report(args.out, calibration, result, field, faults)


def _settings(args: argparse.Namespace, scene: 'Scene') -> 'CalibrationSettings':
    """Check what was asked for before anything slow begins."""
    from diffcal_ros.calibration.settings import CalibrationSettings
    from diffcal_ros.errors import InputError
    from diffcal_ros.warp_runtime.device_array import require_device

    is_alone = not is_field_asked(args) and args.law != _ALL_LAWS
    if args.profile and not is_alone:
        raise InputError(
            '--profile looks at one number of one fit: leave out --field and --law all, or it'
        )
    if args.simulators and (args.law == _ALL_LAWS or args.loss != 'robust'):
        raise InputError(
            '--for fits another simulator after one fit with the robust loss: leave out --law all '
            'and --loss, or it'
        )
    settings = CalibrationSettings(
        fit=asked_fit(args, scene),
        loss=args.loss,
        optimizer=args.optimizer,
        max_iterations=args.max_iterations,
        solver=args.solver,
        device=args.device,
        with_mesh_error=not args.no_mesh_error,
        profile=tuple(args.profile),
        search=not args.no_search,
    )
    require_device(args.device)
    _check_targets(args.out)
    return settings


def _check_targets(out: Path) -> None:
    from diffcal_ros.errors import InputError

    for name in (_RESULT, _REPORT, _FITTED_SCENE):
        if os.path.isdir(out / name):
            raise InputError(
                f'{out / name} is a folder, and a file is to be written there: remove it, or give '
                'another folder with --out'
            )


def _fit(
    args: argparse.Namespace,
    scene: 'Scene',
    settings: 'CalibrationSettings',
    progress: 'Progress',
) -> tuple['Calibration', 'CalibrationResult', 'FieldFit | None']:
    from diffcal_ros.errors import InputError
    from diffcal_ros.offline.calibrate_recordings import run_calibration

    progress.say('reading the recordings')
    inputs = open_asked(args, scene)
    for note in (*scene.notes, *inputs.notes):
        progress.say(f'note: {note}')
    progress.say('preparing the model (the first run on a machine compiles kernels for a minute)')

    def on_iteration(record: 'IterationRecord') -> bool:
        if record.number == 0:
            _remove_old_results(args.out, scene)
        return progress.step(record)

    try:
        if is_field_asked(args):
            calibration, field = fit_asked_field(args, inputs, settings, progress, on_iteration)
            return calibration, field.result, field
        fitted = run_calibration(
            inputs, settings, args.out, on_iteration=on_iteration, report=progress.say
        )
        return *fitted, None
    except ImportError as error:
        # Solvers and torch are optional; the message says what to install.
        raise InputError(str(error)) from error


def _rank(
    args: argparse.Namespace,
    scene: 'Scene',
    settings: 'CalibrationSettings',
    progress: 'Progress',
) -> int:
    """Fit under every law, write the results and print the ranking."""
    from diffcal_ros.calibration.results.outcome import EXIT_NOT_FITTED
    from diffcal_ros.offline.rank_laws import RANKING_FILE, run_law_ranking
    from diffcal_ros.report.tables.law_table import law_lines

    inputs = open_asked(args, scene)
    for note in (*scene.notes, *inputs.notes):
        progress.say(f'note: {note}')
    ranking = run_law_ranking(inputs, settings, args.out, report=progress.say)
    print('\n'.join(law_lines(ranking)))
    print(f'\nranking   {args.out / RANKING_FILE}')
    first = ranking[0].result
    return EXIT_NOT_FITTED if first is None else first.outcome.exit_code


def _remove_old_results(out: Path, scene: 'Scene') -> None:
    """Leave nothing beside the new result.json that belongs to an earlier run, unless it is read.

    A fit that is interrupted must not cost the scene that it started from.
    """
    from diffcal_ros.scene.sections.modulus_field import FIELD_FILE

    used = [scene.path, scene.file_of('mesh'), scene.file_of('modulus_field')]
    kept = {path.resolve() for path in used if path is not None}
    for name in (_REPORT, _FITTED_SCENE, FIELD_FILE):
        if (out / name).resolve() not in kept:
            # What cannot be removed is told when it is written.
            with suppress(OSError):
                (out / name).unlink(missing_ok=True)


def _write_and_report(
    out: Path,
    calibration: 'Calibration',
    result: 'CalibrationResult',
    field: 'FieldFit | None',
    told: Sequence[str],
) -> int:
    """Write everything and print the result; what cannot be written costs nothing else.

    Raises:
        InputError: with what was told before, or when a file could not be written, once the
            others are.
    """
    from diffcal_ros.errors import InputError
    from diffcal_ros.fem.activity import during
    from diffcal_ros.report.pages.field_section import field_text
    from diffcal_ros.report.tables.effective_table import effective_lines
    from diffcal_ros.report.tables.result_table import result_text
    from diffcal_ros.report.tables.scene_table import format_rows

    rows, faults = [('result', str(out / _RESULT))], list(told)
    count = 3 * calibration.scene.mesh.tet_count
    try:
        for name, path, write in _files(out, calibration, result, field):
            try:
                with during(f'writing {path}', count):
                    write()
                rows.append((name, str(path)))
            except InputError as error:
                faults.append(str(error))
    finally:
        print(result_text(calibration.scene.name, result))
        if field is not None:
            print(field_text(field))
        print('\n'.join([*effective_lines(result), format_rows(rows)]))
    if faults:
        raise InputError('; '.join(faults))
    return result.outcome.exit_code


def _files(
    out: Path, calibration: 'Calibration', result: 'CalibrationResult', field: 'FieldFit | None'
) -> Iterator[tuple[str, Path, Callable[[], None]]]:
    """List what is written beside result.json, and how; what others go on from comes first."""
    from diffcal_ros.report.field_file import write_field
    from diffcal_ros.report.pages.fit_page import write_report
    from diffcal_ros.scene.save import save_fitted_scene
    from diffcal_ros.scene.sections.modulus_field import FIELD_FILE

    scene = calibration.scene
    if field is not None:
        scene = replace(scene, relative_modulus=field.relative_modulus)
    if result.outcome.is_fitted:
        path = out / _FITTED_SCENE
        yield 'scene', path, partial(save_fitted_scene, scene, path, result.values())
    if field is not None:
        # In place of the one beside the scene, with its error and the body's shape.
        path = out / FIELD_FILE
        yield 'field', path, partial(write_field, path, calibration, field)
    path = out / _REPORT
    yield 'report', path, partial(write_report, path, calibration, result, field)


def _what_is_left(out: Path, progress: 'Progress') -> str:
    if progress.last is None:
        return 'interrupted before the first state was reached; nothing was written'
    number = progress.last.number
    return f'interrupted; {out / _RESULT} holds the state after iteration {number}'
