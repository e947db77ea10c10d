# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fit a body live each time it is let go: 1024x768 depth at 30 Hz through DDS, two nodes.

Build first and source install/setup.bash, as `make demo` does. A recording of a beam that rests a
second on a ledge and swings for four is replayed in a loop with stamps that go on; another
integrator made it. Writes results/live_swings.json.

    python benchmarks/live_swings.py [--seconds 120] [--elements linear] [--nice 0]
"""

import argparse
from dataclasses import dataclass
from pathlib import Path
import sys
import tempfile
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.scene.load import load_scene
from diffcal_ros.synthetic.filming import Timing
from diffcal_ros.synthetic.lidar import LidarModel
from diffcal_ros.synthetic.recorder import record, RecorderSettings
from live_scene import MODULUS, write_scene
from live_watch import FIT, LiveWatch, SECOND, set_nice
from measuring import write
import numpy as np
import rclpy
from rclpy.node import Node

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / 'demo'))
from node_process import join_quiet_domain, NodeGroup  # noqa: E402

_RATE = 30
_REST, _SWING = 1.0, 4.0  # [s]
_FILMED = 1.0  # Rest before it included [s].
_DAMPING, _DENSITY, _WEIGHED = 150.0, 1080.0, 20.0
_TRUTH = {'youngs_modulus': MODULUS, 'damping': _DAMPING, 'density': _DENSITY}
_MOTION: dict[str, Any] = {
    'held': {'ledge': {'box': {'x': [float('-inf'), 1e-6]}}},
    'motion': {
        'released': ['ledge'],
        'at': {'start': _REST, 'min': 0.8, 'max': 1.2},
        'duration': _FILMED,
    },
    'region': {
        'damping': _DAMPING,
        # Motion shows only ratios to the density: the body was weighed.
        'density': {'start': _DENSITY, 'prior': {'mean': _DENSITY, 'std': _WEIGHED}},
    },
    'fit': [*_TRUTH, 'release_time'],
}


@dataclass(frozen=True)
class SwingFit:
    """What a node told after a swing.

    Attributes:
        wait: from the publication of the last frame that was compared [s].
        iterations: of the fit.
        values: and standard errors in SI units, by name.
        outcome: of the fit.
    """

    wait: float
    iterations: int
    values: dict[str, tuple[float, float]]
    outcome: str


class SwingWatch(LiveWatch):
    """Notes every fit of a swing."""

    def __init__(self, node: Node, nodes: Any) -> None:
        super().__init__(node, nodes)
        self.fits: list[SwingFit] = []
        node.create_subscription(DiagnosticArray, 'calibration/estimates', self._on_fit, 50)

    def _on_fit(self, message: DiagnosticArray, info: dict[str, int]) -> None:
        found = {s.name: {pair.key: pair.value for pair in s.values} for s in message.status}
        fit = found.pop('fit')
        stamp = message.header.stamp.sec * SECOND + message.header.stamp.nanosec
        if fit['outcome'] == 'running' or stamp not in self.sent_ns:
            return
        self.fits.append(
            SwingFit(
                wait=(info['source_timestamp'] - self.sent_ns[stamp]) / SECOND,
                iterations=int(fit['iteration']),
                values={
                    name: (float(found[name]['value']), float(found[name]['std_error']))
                    for name in _TRUTH
                },
                outcome=fit['outcome'],
            )
        )


def main() -> None:
    """Run each element asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--seconds', type=float, default=120.0)
    parser.add_argument('--elements', nargs='+', default=['linear'])
    parser.add_argument('--nice', type=int, default=0, help='of the nodes; below 0 needs root')
    arguments = parser.parse_args()
    join_quiet_domain()
    figures: dict[str, Any] = {'rate_hz': _RATE, 'image': '1024x768 16UC1', 'truth': _TRUTH}
    figures['nice'] = arguments.nice
    for name in arguments.elements:
        figures[name] = run(Element(name), arguments.seconds, arguments.nice)
        write('live_swings', figures)


def run(element: Element, seconds: float, nice: int) -> dict[str, Any]:
    """Replay one stream and say how it was fitted."""
    rclpy.init()
    node = rclpy.create_node('live_benchmark')
    with tempfile.TemporaryDirectory() as text:
        folder = Path(text)
        scene = load_scene(write_scene(folder / 'true', element, motion=_MOTION))
        settings = RecorderSettings(
            timing=Timing(round(_RATE * (_REST + _SWING)), _RATE),
            color_frames=0,
            element=element,
            integrator='semi_implicit' if element is Element.LINEAR else None,
            lidar=LidarModel(encoding='16UC1'),
        )
        recorded = record(scene, folder / 'recorded', settings)
        with NodeGroup(folder / 'log') as nodes:
            nodes.start('calibration', scene=recorded.scene, pose_source='stored')
            watch = SwingWatch(node, nodes)
            watch.until(lambda: 'waiting' in watch.message, 300.0)
            (bag,) = recorded.bags.values()
            nodes.start('depth_source', bag=bag, loop=True, wait_for_subscriber=60.0)
            for process in ('calibration', 'depth_source'):
                set_nice(nodes.process_id(process), nice)
            watch.listen(seconds)
            figures = {'tets': scene.mesh.tet_count, **_figures(watch, seconds)}
    rclpy.shutdown()
    return figures


def _figures(watch: SwingWatch, seconds: float) -> dict[str, Any]:
    told = watch.status[FIT]
    counted = ('swings seen', 'swings fitted', 'swings skipped', 'frames used', 'frames skipped')
    errors = {
        name: [round(fit.values[name][0] / truth - 1.0, 4) for fit in watch.fits]
        for name, truth in _TRUTH.items()
    }
    return {
        'seconds': seconds,
        **{name: int(told[name]) for name in counted},
        'outcomes': [fit.outcome for fit in watch.fits],
        'iterations': [fit.iterations for fit in watch.fits],
        'last_frame_to_parameters_s': [round(fit.wait, 2) for fit in watch.fits],
        'relative_error': errors,
        'relative_std_error': {
            name: round(float(np.mean([f.values[name][1] / truth for f in watch.fits])), 4)
            for name, truth in _TRUTH.items()
        },
    }


if __name__ == '__main__':
    main()
