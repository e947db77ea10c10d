# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Replay a recording through the three nodes, watch the fit and save its report: `make demo`.

    python demo/run_demo.py --bag bags/sample --scene bags/sample/scene.yaml --out out/demo

The nodes are real processes that talk DDS, on a domain of their own and on this machine only.
Exit codes: 0 converged, 1 a node failed or the time is up, 2 bad input, 3 not converged.
"""

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
import signal
import sys
import time
from typing import Any

from node_process import DemoError, join_quiet_domain, NodeGroup

EXIT_CONVERGED, EXIT_FAILED, EXIT_BAD_INPUT, EXIT_NOT_CONVERGED = range(4)
_EXIT_INTERRUPTED = 130


def main() -> int:
    """Run the demonstration; return the exit code."""
    args = _parse()
    for path in (args.bag, args.scene):
        if not path.exists():
            print(f'run_demo: {path} does not exist', file=sys.stderr)
            return EXIT_BAD_INPUT
    # `timeout` and service managers send SIGTERM: the nodes must end then as well. A shell starts
    # what runs in its background deaf to SIGINT.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.default_int_handler)
    try:
        join_quiet_domain()
        return _run(args)
    except DemoError as error:
        print(f'run_demo: {error}', file=sys.stderr)
        return EXIT_FAILED
    except KeyboardInterrupt:
        print('run_demo: interrupted', file=sys.stderr)
        return _EXIT_INTERRUPTED


def _parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--bag', type=Path, required=True, help='rosbag2 directory or .mcap')
    parser.add_argument('--scene', type=Path, required=True, help='scene file')
    parser.add_argument('--out', type=Path, required=True, help='folder of results')
    parser.add_argument('--timeout', type=float, default=300.0, help='[s] (default: %(default)g)')
    return parser.parse_args()


def _run(args: argparse.Namespace) -> int:
    from fit_watch import FitWatch, result_lines

    begun = time.monotonic()
    out = args.out.resolve()
    scene, bag = args.scene.resolve(), _recording(args.bag.resolve())
    print(f'starting calibration, marker_pose and depth_source, logs in {out / "log"}', flush=True)
    with NodeGroup(out / 'log') as nodes:
        # First, because it compiles kernels, the first time on a machine.
        nodes.start('calibration', scene=scene, out=out, refit='once')
        nodes.start('marker_pose', scene=scene)
        nodes.start('depth_source', bag=bag, subscribers=2, wait_for_subscriber=60.0)
        with _listener() as node:
            watch = FitWatch(node, nodes, begun + args.timeout)
            watch.until(lambda: bool(watch.outcome), 'the end of the fit')
            print('\n'.join(['', *result_lines(watch.estimates), '']), flush=True)
            print(f'report: {watch.save()}')
            print(f'{time.monotonic() - begun:.0f} s from start to report', flush=True)
    return EXIT_CONVERGED if watch.outcome == 'converged' else EXIT_NOT_CONVERGED


def _recording(path: Path) -> Path:
    """Return the recording itself; a sample's folder holds it in `bag`."""
    inner = path / 'bag'
    return inner if inner.is_dir() and not (path / 'metadata.yaml').exists() else path


@contextmanager
def _listener() -> Iterator[Any]:
    import rclpy
    from rclpy.signals import SignalHandlerOptions

    # Signals are ours: Ctrl-C raises KeyboardInterrupt here, and the nodes are ended on the way.
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    try:
        yield rclpy.create_node('demo')
    finally:
        rclpy.try_shutdown()


if __name__ == '__main__':
    sys.exit(main())
