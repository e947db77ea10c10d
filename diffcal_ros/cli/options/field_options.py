# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""`diffcal calibrate --field`: a modulus that varies over the body."""

import argparse
from collections.abc import Callable
from typing import Any, TYPE_CHECKING

if TYPE_CHECKING:
    from diffcal_ros.calibration.calibrate import Calibration
    from diffcal_ros.calibration.field.fit import FieldFit
    from diffcal_ros.calibration.results.result import IterationRecord
    from diffcal_ros.calibration.settings import CalibrationSettings
    from diffcal_ros.cli.progress import Progress
    from diffcal_ros.offline.calibrate_recordings import OfflineInputs


def add_field_options(group: Any) -> None:
    """Add the options."""
    group.add_argument(
        '--field',
        action='store_true',
        help='fit a modulus that varies over the body: one a tetrahedron, as smooth as the data '
        'allow; DIR/field.vtu holds it, and DIR/fitted_scene.yaml names that. Where SCENE '
        'states a field already, the new one is what is added to it',
    )
    group.add_argument(
        '--field-spacing',
        metavar='M',
        type=float,
        help='make the field of a control grid of this spacing [m] instead',
    )
    group.add_argument(
        '--field-weight',
        metavar='SHARE',
        type=float,
        help="weight of the field's roughness, a share from 0 to 1 of what the best seen pattern "
        'weighs (default: where the residuals reach the noise, else the corner of the L-curve)',
    )


def is_field_asked(args: argparse.Namespace) -> bool:
    """Tell whether a field is to be fitted.

    Raises:
        InputError: when options do not go together.
    """
    from diffcal_ros.errors import InputError

    wants = [args.field_spacing is not None, args.field_weight is not None]
    if any(wants) and not args.field:
        raise InputError('--field-spacing and --field-weight say how to fit a field: add --field')
    if args.field and args.law == 'all':
        raise InputError(
            '--law all ranks laws under the same few parameters: fit the field under one law, '
            'and leave --field out of the ranking'
        )
    if args.field and args.loss != 'robust':
        raise InputError(f'--field needs the robust loss, not {args.loss!r}: leave --loss out')
    return bool(args.field)


def fit_asked_field(
    args: argparse.Namespace,
    inputs: 'OfflineInputs',
    settings: 'CalibrationSettings',
    progress: 'Progress',
    on_iteration: Callable[['IterationRecord'], bool],
) -> tuple['Calibration', 'FieldFit']:
    """Fit the field that was asked for."""
    from diffcal_ros.calibration.field.layout import FieldKind
    from diffcal_ros.offline.calibrate_field import run_field_calibration

    return run_field_calibration(
        inputs,
        settings,
        args.out,
        FieldKind(args.field_spacing),
        fraction=args.field_weight,
        on_iteration=on_iteration,
        report=progress.say,
    )
