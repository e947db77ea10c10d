# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""`diffcal export`: a fitted body as an asset of another simulator."""

import argparse
from typing import Any

from diffcal_ros.cli.options.path_argument import path_argument
from diffcal_ros.cli.say import say

# Named here, for `--help` must be quick; a test compares them with the targets that are there.
TARGETS = ('abaqus', 'mjcf', 'newton', 'sofa', 'usd', 'vtk')


def add_parser(subparsers: Any) -> None:
    """Add the subcommand."""
    parser = subparsers.add_parser(
        'export',
        help='write a fitted body as an asset of another simulator',
        description='Write the body of FIT in the form of another simulator: mesh, held vertices, '
        "material, density and damping in that one's own convention; beside it a script that "
        'loads and plays it, and export.json, which lists what the asset holds.',
    )
    parser.add_argument(
        'fit',
        metavar='FIT',
        type=path_argument,
        help='folder of `diffcal calibrate --out`, or a scene file, whose start values are taken',
    )
    parser.add_argument(
        '--to',
        choices=TARGETS,
        required=True,
        help='usd: for Isaac and Newton; mjcf: MuJoCo; newton; sofa; abaqus: CalculiX, too; '
        'vtk: ParaView, or as a neutral form',
    )
    parser.add_argument(
        '--out', metavar='DIR', type=path_argument, required=True, help='folder to write to'
    )
    parser.add_argument(
        '--observation',
        metavar='NAME',
        help='of the scene, whose clamp and gravity the asset has (default: the first)',
    )
    parser.add_argument(
        '--modulus',
        choices=('effective', 'material'),
        default='effective',
        help='effective: what `diffcal calibrate --for` found for the target, where FIT has it '
        "(default); material: the material's own in any case",
    )
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Export and say what was written; return the exit code."""
    from diffcal_ros.export.write import export_fit
    from diffcal_ros.report.tables.scene_table import format_rows

    export = export_fit(
        args.fit,
        args.to,
        args.out,
        observation=args.observation,
        takes_effective=args.modulus == 'effective',
    )
    body = export.body
    for note in body.notes:
        say(f'diffcal export: note: {note}')
    rows = [
        ('body', f'{body.mesh.tet_count} tetrahedra, {len(body.held)} vertices held'),
        ('mass', f'{1e3 * body.mass:.4g} g, {1e6 * body.volume:.4g} cm^3'),
        ('moduli', export.moduli),
        *(('file', str(path)) for path in export.files),
    ]
    print(format_rows(rows))
    return 0
