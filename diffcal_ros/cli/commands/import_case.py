# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""`diffcal import`: a scene and a recording from the public data set."""

import argparse
from typing import Any

from diffcal_ros.cli.options.path_argument import path_argument
from diffcal_ros.cli.say import say


def add_parser(subparsers: Any) -> None:
    """Add the subcommand."""
    parser = subparsers.add_parser(
        'import',
        help='make a scene and a recording from the public DiffCal data set',
        description='Write OUT/scene.yaml, the mesh beside it, and OUT/bag (rosbag2, mcap) with '
        'the depth and colour frames there are, from an experiment of the public data set.',
    )
    parser.add_argument(
        'dataset',
        metavar='DATASET',
        type=path_argument,
        help='folder with exp_data and CAD_models',
    )
    parser.add_argument('case', metavar='CASE', help='name of the experiment, such as h_e_c')
    parser.add_argument(
        '--out', metavar='DIR', type=path_argument, required=True, help='folder to write to'
    )
    parser.add_argument(
        '--overwrite', action='store_true', help='replace a scene and a bag that are there'
    )
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Import and say what was written; return the exit code."""
    from diffcal_ros.recording.dataset.import_case import import_case

    say(f'importing {args.case}')
    imported = import_case(args.dataset, args.case, args.out, overwrite=args.overwrite)
    print(f'scene  {imported.scene}')
    for bag in imported.bags.values():
        print(f'bag    {bag.path}: {bag.depth_count} depth, {bag.color_count} colour frames')
    for warning in imported.warnings:
        say(f'diffcal import: warning: {warning}')
    return 0
