# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""`diffcal suggest`: which recording would tell most next."""

import argparse
from typing import Any

from diffcal_ros.cli.options.path_argument import path_argument
from diffcal_ros.cli.options.recording_options import asked_fit
from diffcal_ros.cli.say import say


def add_parser(subparsers: Any) -> None:
    """Add the subcommand."""
    parser = subparsers.add_parser(
        'suggest',
        help='say which pose or view would tell most next',
        description='Take the observations of SCENE, such as a fitted_scene.yaml, as recorded, '
        'and rank other directions of gravity and other views by how much they would shrink the '
        "errors of what is fitted. It rests on the model's own derivatives; no recording is read.",
    )
    parser.add_argument('scene', metavar='SCENE', type=path_argument, help='scene file (YAML)')
    parser.add_argument(
        '--fit',
        metavar='NAME',
        nargs='+',
        action='extend',
        help="parameters that are to be known (default: the scene's)",
    )
    parser.add_argument(
        '--json', metavar='FILE', type=path_argument, help='write the ranking to a file, too'
    )
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Print the ranking; return the exit code."""
    from diffcal_ros.atomic_file import write_text_atomically
    from diffcal_ros.planning.suggest import suggest
    from diffcal_ros.report.tables.suggestion_text import suggestion_json, suggestion_text
    from diffcal_ros.scene.load import load_scene

    scene = load_scene(args.scene)
    say('simulating what other poses and views would show')
    suggestion = suggest(scene, fit=asked_fit(args, scene))
    if args.json is not None:
        write_text_atomically(args.json, suggestion_json(suggestion))
    print(suggestion_text(suggestion))
    return 0
