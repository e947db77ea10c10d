# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""`diffcal revert`: take the last effect that was accepted out of a model again."""

import argparse
from typing import Any

from diffcal_ros.cli.options.path_argument import path_argument


def add_parser(subparsers: Any) -> None:
    """Add the subcommand."""
    parser = subparsers.add_parser(
        'revert',
        help='take the last effect out of the model again',
        description='Take the effect that was accepted last out of the model of a scene.',
    )
    parser.add_argument(
        'target',
        metavar='SCENE_OR_DIR',
        type=path_argument,
        help='scene file, or folder of its diagnosis',
    )
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Take the effect out; return the exit code."""
    from diffcal_ros.diagnosis.verdict.acceptance import revert, scene_of

    scene = scene_of(args.target) if args.target.is_dir() else args.target
    path, effect = revert(scene)
    print(f'took {effect} out of {path}')
    return 0
