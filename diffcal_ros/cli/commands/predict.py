# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""`diffcal predict`: run a calibrated model forward and show what it does."""

import argparse
from typing import Any, TYPE_CHECKING

from diffcal_ros.cli.options.number_argument import coordinate
from diffcal_ros.cli.options.path_argument import path_argument
from diffcal_ros.cli.say import say

if TYPE_CHECKING:
    from diffcal_ros.prediction.predicted_body import PredictedBody


def add_parser(subparsers: Any) -> None:
    """Add the subcommand."""
    parser = subparsers.add_parser(
        'predict',
        help='run a calibrated model forward: depth, meshes and a film',
        description='Simulate the body of SCENE by its start values and effects, such as those '
        'of a fitted_scene.yaml, and write what a depth camera would see, the deformed mesh of '
        'every frame and a film; a folder for each observation where the scene has several.',
    )
    parser.add_argument('scene', metavar='SCENE', type=path_argument, help='scene file (YAML)')
    parser.add_argument(
        '--out', metavar='DIR', type=path_argument, required=True, help='folder to write to'
    )
    parser.add_argument(
        '--overwrite', action='store_true', help='write into a folder that is not empty'
    )
    _add_film_options(parser.add_argument_group('what is looked at'))
    _add_file_options(parser.add_argument_group('what is written'))
    parser.set_defaults(run=run)


def _add_film_options(group: Any) -> None:
    group.add_argument(
        '--rate', metavar='HZ', type=float, default=30.0, help='frames a second (default: 30)'
    )
    group.add_argument(
        '--duration',
        metavar='S',
        type=float,
        help="of a motion (default: the scene's, else until a second after the release)",
    )
    group.add_argument(
        '--camera-position',
        metavar=('X', 'Y', 'Z'),
        nargs=3,
        type=coordinate,
        help='of the depth camera in the world [m]; it looks at the body (default: the pose '
        'that the scene stores, else one that sees the whole motion)',
    )


def _add_file_options(group: Any) -> None:
    group.add_argument(
        '--mesh',
        choices=('vtu', 'obj', 'none'),
        default='vtu',
        help='vtu: volumes and displacements, with body.pvd for ParaView (default); obj: surfaces',
    )
    group.add_argument(
        '--bag', action='store_true', help='write the depth as a rosbag2 recording, too'
    )
    group.add_argument(
        '--film',
        choices=('gif', 'mp4'),
        default='gif',
        help='gif: repeats, and opens everywhere (default); mp4: VP9, finer and smaller for long '
        'films',
    )
    group.add_argument(
        '--slow-motion',
        metavar='X',
        type=float,
        default=4.0,
        help='how many times slower than in truth the film plays (default: 4)',
    )


def run(args: argparse.Namespace) -> int:
    """Simulate, write and say what was written; return the exit code."""
    from diffcal_ros.prediction.film_times import FilmTimes
    from diffcal_ros.prediction.predicted_body import predict_bodies
    from diffcal_ros.prediction.predicted_view import look_at
    from diffcal_ros.prediction.write import check_outputs, PredictionOutputs, write_prediction
    from diffcal_ros.report.tables.scene_table import format_rows
    from diffcal_ros.scene.load import load_scene

    film = FilmTimes(rate=args.rate, duration=args.duration)
    outputs = PredictionOutputs(args.mesh, args.bag, args.slow_motion, args.overwrite, args.film)
    check_outputs(args.out, outputs)
    scene = load_scene(args.scene)
    say(f'simulating, {scene.mesh.tet_count} tetrahedra')
    bodies = predict_bodies(scene, film)
    position = tuple(args.camera_position) if args.camera_position else None
    views = look_at(scene, bodies, position)
    rows = [(body.setup.name, _words(body)) for body in bodies]
    say('writing depth, meshes and film')
    written = write_prediction(views, args.out, outputs)
    for warning in (text for body in bodies for text in body.warnings):
        say(f'diffcal predict: warning: {warning}')
    if scene.depth_camera is None:
        say("diffcal predict: note: the scene gives no camera: intrinsics like an Intel L515's")
    print(format_rows([*rows, *((word, str(path)) for word, path in written)]))
    return 0


def _words(body: 'PredictedBody') -> str:
    count, moved = len(body.times), 1e3 * body.largest_displacement
    return f'{count} frame{"s" if count > 1 else ""}, moved by up to {moved:.3g} mm'
