# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""`diffcal check`: read a scene, say what is in it or what is wrong, and draw it."""

import argparse
from pathlib import Path
from typing import Any

from diffcal_ros.cli.options.path_argument import path_argument
from diffcal_ros.cli.read_scene import read_scene


def add_parser(subparsers: Any) -> None:
    """Add the subcommand."""
    parser = subparsers.add_parser(
        'check',
        help='check a scene file and draw it',
        description='Check a scene file, print what is in it, and draw it to a PNG. '
        'All mistakes are listed at once, and the exit code is then 2.',
    )
    parser.add_argument('scene', metavar='SCENE', type=path_argument, help='scene file (YAML)')
    drawing = parser.add_mutually_exclusive_group()
    drawing.add_argument(
        '--draw',
        metavar='PNG',
        type=path_argument,
        help='where the drawing goes (default: <SCENE>_check.png in the current folder)',
    )
    drawing.add_argument('--no-draw', action='store_true', help='print only')
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Print the table and write the drawing; return the exit code."""
    from diffcal_ros.report.tables.scene_table import format_rows, scene_rows

    scene = read_scene(args.scene)
    rows = scene_rows(scene)
    if not args.no_draw:
        from diffcal_ros.report.scene_picture.scene_drawing import draw_scene

        drawing = args.draw or Path(f'{args.scene.stem}_check.png')
        draw_scene(scene, drawing)
        rows.append(('drawing', str(drawing)))
    print(format_rows(rows))
    return 0
