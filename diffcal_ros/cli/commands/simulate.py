# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""`diffcal simulate`: a synthetic recording of a scene, with known parameters."""

import argparse
from dataclasses import replace
from typing import Any

from diffcal_ros.cli.heartbeat import Heartbeat
from diffcal_ros.cli.options.number_argument import coordinate
from diffcal_ros.cli.options.path_argument import path_argument
from diffcal_ros.cli.read_scene import read_scene
from diffcal_ros.cli.say import say


def add_parser(subparsers: Any) -> None:
    """Add the subcommand."""
    parser = subparsers.add_parser(
        'simulate',
        help='record a simulated body with a synthetic camera',
        description='Bend the body of SCENE by its start values, film it with a synthetic depth '
        'and colour camera, and write OUT/bag, OUT/scene.yaml (started away from the truth), the '
        'mesh, and OUT/truth.json, which no other command reads.',
    )
    parser.add_argument(
        'scene',
        metavar='SCENE',
        type=path_argument,
        help='scene file; its start values are the truth',
    )
    parser.add_argument(
        '--out', metavar='DIR', type=path_argument, required=True, help='folder to write to'
    )
    parser.add_argument(
        '--overwrite', action='store_true', help='replace a recording that is there'
    )
    _add_body_options(parser.add_argument_group('the true body'))
    _add_motion_options(parser.add_argument_group('a body that moves'))
    _add_camera_options(parser.add_argument_group('the cameras'))
    parser.set_defaults(run=run)


def _add_body_options(group: Any) -> None:
    group.add_argument(
        '--element',
        choices=('linear', 'quadratic'),
        default='quadratic',
        help='that the true body is made of (default: quadratic, whatever the scene says)',
    )
    group.add_argument(
        '--refine', action='store_true', help='simulate it at half the mesh size of the scene'
    )
    group.add_argument(
        '--start-factor',
        metavar='X',
        type=float,
        default=1.4,
        help='by which moduli, densities and damping of OUT/scene.yaml are off (default: 1.4)',
    )


def _add_motion_options(group: Any) -> None:
    group.add_argument(
        '--integrator',
        choices=('implicit', 'semi_implicit'),
        help="that moves the true body (default: the scene's)",
    )
    group.add_argument(
        '--time-step', metavar='S', type=float, help="of that [s] (default: the scene's)"
    )
    group.add_argument(
        '--exposure',
        metavar='S',
        type=float,
        default=0.0,
        help='over which the lines of a depth image are taken one after the other, around the '
        'stamp [s] (default: 0)',
    )
    group.add_argument(
        '--stamp-jitter',
        metavar='S',
        type=float,
        default=0.0,
        help='standard deviation of the error of a time stamp [s] (default: 0)',
    )
    group.add_argument(
        '--drop',
        metavar='SHARE',
        type=float,
        default=0.0,
        help='share of the depth images that get lost (default: 0)',
    )


def _add_camera_options(group: Any) -> None:
    group.add_argument(
        '--frames', metavar='N', type=int, default=15, help='depth images (default: 15)'
    )
    group.add_argument(
        '--color-frames', metavar='N', type=int, help='colour images (default: a third of those)'
    )
    group.add_argument(
        '--rate',
        metavar='HZ',
        type=float,
        default=30.0,
        help='depth images a second (default: 30)',
    )
    group.add_argument(
        '--seed', metavar='N', type=int, default=0, help='of the noise (default: 0)'
    )
    group.add_argument(
        '--camera-position',
        metavar=('X', 'Y', 'Z'),
        nargs=3,
        type=coordinate,
        help='of the depth camera in the world [m]; it looks at the body and the marker '
        '(default: the pose that the scene stores, else one that sees both)',
    )
    group.add_argument(
        '--encoding',
        choices=('32FC1', '16UC1'),
        help='32FC1: metres; 16UC1: cut to whole millimetres, as the RealSense driver does '
        "(default: as the scene's sensor says)",
    )
    group.add_argument(
        '--noise', metavar='M', type=float, help="of one pixel [m] (default: the scene's sensor)"
    )
    group.add_argument(
        '--bias', metavar='M', type=float, default=0.0, help='smooth error, RMS [m] (default: 0)'
    )
    group.add_argument(
        '--max-range',
        metavar='M',
        type=float,
        default=9.0,
        help='no depth beyond this [m] (default: 9)',
    )


def run(args: argparse.Namespace) -> int:
    """Record and say what was written; return the exit code."""
    from diffcal_ros.fem.elements.element import Element
    from diffcal_ros.synthetic.filming import Timing
    from diffcal_ros.synthetic.lidar import lidar_of
    from diffcal_ros.synthetic.recorder import record, RecorderSettings

    scene = read_scene(args.scene)
    lidar = lidar_of(scene.sensor, encoding=args.encoding, noise=args.noise)
    settings = RecorderSettings(
        timing=Timing(
            frames=args.frames,
            rate=args.rate,
            exposure=args.exposure,
            stamp_jitter=args.stamp_jitter,
            drop_share=args.drop,
        ),
        color_frames=-(-args.frames // 3) if args.color_frames is None else args.color_frames,
        seed=args.seed,
        element=Element(args.element),
        integrator=args.integrator,
        time_step=args.time_step,
        is_refined=args.refine,
        start_factor=args.start_factor,
        camera_position=tuple(args.camera_position) if args.camera_position else None,
        lidar=replace(lidar, bias=args.bias, farthest=args.max_range),
    )
    with Heartbeat('preparing the recording') as heartbeat:
        made = record(scene, args.out, settings, overwrite=args.overwrite, report=heartbeat.report)
    print(f'scene  {made.scene}')
    for bag in made.bags.values():
        print(f'bag    {bag}: {args.frames} depth, {settings.color_frames} colour frames')
    print(f'truth  {made.truth}')
    for note in made.notes:
        say(f'diffcal simulate: note: {note}')
    return 0
