# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What every command that reads recordings takes: which, how, and what is fitted."""

import argparse
import os
from typing import Any, TYPE_CHECKING

from diffcal_ros.cli.options.path_argument import path_argument

if TYPE_CHECKING:
    from collections.abc import Sequence

    from diffcal_ros.offline.calibrate_recordings import OfflineInputs
    from diffcal_ros.recording.recording import Recording
    from diffcal_ros.scene.model import Scene


def add_recordings(parser: Any) -> None:
    """Add the recordings, the scene and the folder of results."""
    parser.add_argument(
        'bags',
        metavar='BAG',
        nargs='*',
        type=path_argument,
        help='rosbag2 directory or .mcap file; one for each observation of the scene, in its '
        'order, or in any if the scene names them (default: the bags that the scene names)',
    )
    parser.add_argument(
        '--scene', metavar='SCENE', type=path_argument, required=True, help='scene file'
    )
    parser.add_argument(
        '--out', metavar='DIR', type=path_argument, required=True, help='folder of results'
    )


def add_input_options(group: Any) -> None:
    """Add how recordings are read."""
    group.add_argument(
        '--pose',
        choices=('estimated', 'stored', 'tf', 'topic', 'fixture'),
        help="the camera's pose: estimated from the marker, as the scene stores it, from /tf and "
        '/tf_static, from a PoseStamped or PoseWithCovarianceStamped topic, or from where the '
        "depth images show the scene's `fixture` (default: what `pose: {source: ..}` of the scene "
        'says, or else estimated)',
    )
    group.add_argument('--depth-topic', metavar='TOPIC', help='where a recording has several')
    group.add_argument(
        '--allow-truncated',
        action='store_true',
        help='read what is left of a damaged or cut-off recording; what is lost is counted',
    )


def open_asked(args: argparse.Namespace, scene: 'Scene') -> 'OfflineInputs':
    """Open the recordings that were asked for.

    Raises:
        InputError: when one of them, or its pose, cannot be used.
    """
    from diffcal_ros.offline.calibrate_recordings import open_inputs

    inputs = open_inputs(
        scene,
        args.bags,
        pose_source=args.pose,
        depth_topic=args.depth_topic,
        allow_truncated=args.allow_truncated,
    )
    if args.bags:
        _require_different(inputs.recordings)
    return inputs


def _require_different(recordings: 'Sequence[Recording]') -> None:
    """Refuse the same files under whatever names.

    A scene may well name one bag for several observations, such as swings at several times.
    """
    from diffcal_ros.errors import RecordingError

    known: dict[str, Recording] = {}
    for recording in recordings:
        other = known.setdefault(recording.sha256, recording)
        if other is not recording:
            raise RecordingError(
                f'{other.path} and {recording.path} hold the same, and every frame would count '
                'twice: give it once'
            )


def asked_fit(args: argparse.Namespace, scene: 'Scene') -> tuple[str, ...] | None:
    """Return the names after --fit, checked; None where it was not given.

    Raises:
        InputError: when they cannot be fitted.
    """
    from diffcal_ros.errors import InputError
    from diffcal_ros.scene.fit_names import fit_problems

    if args.fit is None:
        return None
    fit = tuple(name for item in args.fit for name in item.split(',') if name)
    regions = [region.name for region in scene.regions]
    cables = [cable.name for cable in scene.cables]
    problems = fit_problems(fit, regions, scene.observations, cables)
    # `Path.exists` raises for names that are too long.
    swallowed = [name for name in fit if os.path.exists(name)]
    if problems and swallowed:
        raise InputError(
            f'--fit has {swallowed[0]!r}, a path: name the recordings before the options'
        )
    if problems:
        raise InputError('; '.join(f'--fit {problem}' for problem in problems))
    return fit
