# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""`diffcal init`: propose a scene from a mesh and recordings."""

import argparse
from collections.abc import Sequence
import sys
from typing import Any, TYPE_CHECKING

from diffcal_ros.cli.options.page_options import add_page_options, asked_page, say_where
from diffcal_ros.cli.options.path_argument import path_argument
from diffcal_ros.cli.say import say

if TYPE_CHECKING:
    from diffcal_ros.marker import Marker
    from diffcal_ros.proposal.propose import Proposal

_SCENE, _PAGE = 'scene.yaml', 'proposal.html'
_UNITS = ('m', 'cm', 'mm')


def add_parser(subparsers: Any) -> None:
    """Add the subcommand."""
    parser = subparsers.add_parser(
        'init',
        help='propose a scene from a mesh and recordings',
        description='Find the body in the depth images, held at one end and bent by its weight, '
        'and write DIR/scene.yaml and DIR/proposal.html, which shows it. What is not sure is '
        'said, and stands in the scene as "# check:". `diffcal calibrate --scene DIR/scene.yaml` '
        'goes on from it; with --web body and clamp are moved by hand first.',
    )
    parser.add_argument(
        'body',
        metavar='BODY',
        type=path_argument,
        help='.tet .msh .vtk .vtu, or a watertight .stl .obj .ply',
    )
    parser.add_argument(
        'takes',
        metavar='TAKE',
        nargs='+',
        type=path_argument,
        help='rosbag2 directory or .mcap file; several of the same posture',
    )
    parser.add_argument(
        '--out', metavar='DIR', type=path_argument, required=True, help='folder to write to'
    )
    _add_world_options(parser)
    _add_known_options(parser)
    parser.add_argument('--overwrite', action='store_true', help='replace a scene that is there')
    page = parser.add_argument_group('the page')
    page.add_argument(
        '--web',
        action='store_true',
        help='go on in the browser: move body and clamp, try a modulus, fit, and save the scene '
        'again',
    )
    add_page_options(page)
    parser.set_defaults(run=run)


def _add_world_options(parser: argparse.ArgumentParser) -> None:
    world = parser.add_mutually_exclusive_group()
    world.add_argument(
        '--marker',
        metavar='DICT:ID:SIDE',
        type=_marker,
        help='printed marker on the rig, such as DICT_6X6_250:0:0.025, its side in metres',
    )
    world.add_argument(
        '--fixture',
        metavar='SURFACE',
        type=path_argument,
        help='closed surface of the rigid clamp, .stl .obj .ply, in the coordinates and unit of '
        'the mesh: found in the depth images, it gives pose and place with no marker; the world '
        'is then their frame',
    )
    world.add_argument(
        '--pose-frame',
        metavar='FRAME',
        default='',
        help="TF's name of the rig's frame, from where transforms lead to the depth images "
        "(default, without --marker: the depth camera's own frame)",
    )


def _add_known_options(parser: argparse.ArgumentParser) -> None:
    known = parser.add_argument_group('what files do not tell')
    known.add_argument(
        '--unit', choices=_UNITS, help='of mesh and fixture (default: by the size of the mesh)'
    )
    known.add_argument('--density', metavar='KG_M3', type=float, help='default 1080, silicone')
    known.add_argument('--poissons-ratio', metavar='NU', type=float, help='default 0.49, rubber')
    known.add_argument(
        '--gravity',
        metavar='X,Y,Z',
        type=_numbers(3),
        help="in m/s^2 in the world's frame (default: from an IMU, else -y of the marker, -z of "
        'FRAME, or down in the image)',
    )
    known.add_argument(
        '--at', metavar='COLUMN,ROW', type=_numbers(2), help='a depth pixel on the soft body'
    )
    known.add_argument('--depth-topic', metavar='TOPIC', help='where a recording has several')
    known.add_argument(
        '--sensor', metavar='MODEL', default='', help='depth camera, such as realsense_d405'
    )


def run(args: argparse.Namespace) -> int:
    """Propose, write and say what is not sure; return the exit code."""
    from diffcal_ros.errors import InputError

    scene = args.out / _SCENE
    if not args.overwrite and scene.exists():
        raise InputError(
            f'{scene} is there already: give another folder with --out, or --overwrite'
        )
    if not args.web:
        _propose(args)
        return 0
    with asked_page(args) as server:  # What it lacks is told before anything slow.
        from diffcal_ros.web.proposed_setup import open_setup_page
        from diffcal_ros.web.server import wait_for_interrupt

        proposal = _propose(args)
        page = open_setup_page(server, proposal.inputs, proposal.draft, scene)
        say_where(server)
        wait_for_interrupt()
        page.close()
    return 0


def _propose(args: argparse.Namespace) -> 'Proposal':
    """Propose a scene, write it, and print what it is."""
    from diffcal_ros.proposal.propose import propose, Question
    from diffcal_ros.proposal.save_draft import save_draft
    from diffcal_ros.report.pages.proposal_page import write_proposal_page

    known = Question(
        unit=args.unit,
        density=args.density,
        poissons_ratio=args.poissons_ratio,
        gravity=args.gravity,
        marker=args.marker,
        pose_frame=args.pose_frame,
        depth_topic=args.depth_topic,
        sensor=args.sensor,
        pixel=args.at,
        fixture=args.fixture,
    )
    proposal = propose(args.body, args.takes, known, ask_unit=_ask_unit, tell=say)
    for note in proposal.notes:
        say(f'note: {note}')
    save_draft(proposal.draft, args.out / _SCENE)
    write_proposal_page(args.out / _PAGE, proposal)
    for doubt in proposal.doubts:
        say(f'check: {doubt}')
    _print(args, proposal)
    return proposal


def _print(args: argparse.Namespace, proposal: 'Proposal') -> None:
    from diffcal_ros.report.tables.scene_table import format_rows

    gap = proposal.found.fit.result.gap_end
    rows = [
        ('body', f'{proposal.draft.unit}, {proposal.inputs.scene.mesh.tet_count} tetrahedra'),
        ('gap', f'median {1e3 * gap.median:.3g} mm, {100 * gap.coverage_in_sight:.1f}% covered'),
        ('start', f"Young's modulus {1e-3 * proposal.draft.youngs_modulus:.3g} kPa"),
        ('scene', str(args.out / _SCENE)),
        ('picture', str(args.out / _PAGE)),
    ]
    print(format_rows(rows), flush=True)


def _ask_unit(question: str, units: Sequence[str]) -> str | None:
    """Ask on a terminal; None where there is none."""
    if not (sys.stdin.isatty() and sys.stderr.isatty()):
        return None
    choices = units or _UNITS
    while True:
        say(f'{question}. Which unit is it, {", ".join(choices)}?')
        answer = sys.stdin.readline()
        if not answer:
            return None
        if answer.strip() in _UNITS:
            return answer.strip()


def _marker(text: str) -> 'Marker':
    from diffcal_ros.marker import Marker
    from diffcal_ros.scene.sections.marker_dictionaries import MARKER_COUNTS

    parts = text.split(':')
    if len(parts) != 3:
        raise argparse.ArgumentTypeError(
            f'{text!r} is not DICT:ID:SIDE, such as DICT_6X6_250:0:0.025'
        )
    name, number, side = parts
    if name not in MARKER_COUNTS:
        raise argparse.ArgumentTypeError(f'{name!r} is none of {", ".join(MARKER_COUNTS)}')
    try:
        marker = Marker(name, int(number), float(side))
    except ValueError:
        raise argparse.ArgumentTypeError(
            f'{text!r}: ID is a whole number and SIDE the edge of the black square in metres'
        ) from None
    if not 0 <= marker.id < MARKER_COUNTS[name]:
        raise argparse.ArgumentTypeError(f'{name} has markers 0 to {MARKER_COUNTS[name] - 1}')
    if not 0.002 <= marker.side <= 2.0:
        raise argparse.ArgumentTypeError(
            f'a marker with a side of {marker.side:g} m cannot be: give the edge of the black '
            'square in metres, 0.002 to 2'
        )
    return marker


def _numbers(count: int) -> Any:
    def read(text: str) -> tuple[float, ...]:
        try:
            values = tuple(float(part) for part in text.split(','))
        except ValueError:
            values = ()
        if len(values) != count:
            raise argparse.ArgumentTypeError(
                f'{text!r} is not {count} numbers with commas between'
            )
        return values

    return read
