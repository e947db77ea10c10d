# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""`diffcal import`: a scene and a recording from the public data set."""

import argparse
from pathlib import Path
import sys
from typing import Any


def add_parser(subparsers: Any) -> None:
    """Add the subcommand."""
    parser = subparsers.add_parser(
        'import',
        help='make a scene and a recording from the public DiffCal data set',
        description='Write OUT/scene.yaml, the mesh beside it, and OUT/bag (rosbag2, mcap) with '
        'the depth and colour frames there are, from an experiment of the public data set.',
    )
    parser.add_argument(
        'dataset', metavar='DATASET', type=Path, help='folder with exp_data and CAD_models'
    )
    parser.add_argument('case', metavar='CASE', help='name of the experiment, such as h_e_c')
    parser.add_argument(
        '--out', metavar='DIR', type=Path, required=True, help='folder to write to'
    )
    parser.add_argument(
        '--overwrite', action='store_true', help='replace a scene and a bag that are there'
    )
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Import and say what was written; return the exit code."""
    from diffcal_ros.recording.dataset_import import import_case

    imported = import_case(args.dataset, args.case, args.out, overwrite=args.overwrite)
    print(f'scene  {imported.scene}')
    for bag in imported.bags.values():
        print(f'bag    {bag.path}: {bag.depth_count} depth, {bag.color_count} colour frames')
    for warning in imported.warnings:
        print(f'diffcal import: warning: {warning}', file=sys.stderr)
    return 0
