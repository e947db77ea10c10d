# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""`diffcal accept`: add what a diagnosis found to the model of its scene."""

import argparse
from typing import Any

from diffcal_ros.cli.options.path_argument import path_argument


def add_parser(subparsers: Any) -> None:
    """Add the subcommand."""
    parser = subparsers.add_parser(
        'accept',
        help='add the effect that was found to the model',
        description='Add the effect of the diagnosis in DIR to the model file beside its scene; '
        'the next `diffcal calibrate` uses it. The scene itself stays as it is.',
    )
    parser.add_argument(
        'folder', metavar='DIR', type=path_argument, help='of `diffcal diagnose --out DIR`'
    )
    parser.add_argument(
        '--effect',
        metavar='EFFECT',
        nargs='+',
        default=[],
        help='which, where the diagnosis leaves it open (default: what it named)',
    )
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Add the effect; return the exit code."""
    from diffcal_ros.diagnosis.verdict.acceptance import accept

    path, added = accept(args.folder, args.effect)
    print(f'added {", ".join(added)} to {path}')
    return 0
