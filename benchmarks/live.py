# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Follow a body live: 1024x768 depth at 30 Hz through DDS, two nodes, parameters out.

Build first and source install/setup.bash, as `make demo` does. A recording of ten seconds is
replayed in a loop with stamps that go on. Once the body stays the same, once its modulus steps
by 30 % in mid-recording and back at each end. Writes results/live.json.

    python benchmarks/live.py [--seconds 300] [--step-seconds 60] [--element linear]
"""

import argparse
from pathlib import Path
import sys
import tempfile
import time
from typing import Any

from diffcal_ros.fem.element import Element
from diffcal_ros.scene.load import load_scene
from diffcal_ros.synthetic.changing_body import record_changes
from diffcal_ros.synthetic.filming import Timing
from diffcal_ros.synthetic.lidar import LidarModel
from diffcal_ros.synthetic.recorder import RecorderSettings
from live_scene import MODULUS, write_scene
from live_watch import LiveWatch
from measuring import write
import rclpy

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / 'demo'))
from node_process import join_quiet_domain, NodeGroup  # noqa: E402

_RATE, _BAG_SECONDS = 30, 10
_STEP = 1.3


def main() -> None:
    """Run both streams with each element asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--seconds', type=float, default=300.0)
    parser.add_argument('--step-seconds', type=float, default=60.0)
    parser.add_argument('--elements', nargs='+', default=['linear', 'quadratic'])
    parser.add_argument('--name', default='live')
    arguments = parser.parse_args()
    join_quiet_domain()
    figures: dict[str, Any] = {'rate_hz': _RATE, 'image': '1024x768 16UC1'}
    for name in arguments.elements:
        element = Element(name)
        figures[name] = {
            'steady': run(element, (1.0,), arguments.seconds),
            'step': run(element, (1.0, _STEP), arguments.step_seconds),
        }
    write(arguments.name, figures)


def run(element: Element, factors: tuple[float, ...], seconds: float) -> dict[str, Any]:
    """Replay one stream and say how it was followed."""
    rclpy.init()
    node = rclpy.create_node('live_benchmark')
    with tempfile.TemporaryDirectory() as text:
        folder = Path(text)
        scene = load_scene(write_scene(folder / 'true', element))
        settings = RecorderSettings(
            timing=Timing(_RATE * _BAG_SECONDS // len(factors), _RATE),
            color_frames=0,
            element=element,
            lidar=LidarModel(encoding='16UC1'),
        )
        fitted = record_changes(scene, folder / 'recorded', factors, settings)
        with NodeGroup(folder / 'log') as nodes:
            nodes.start('calibration', scene=fitted, pose_source='stored')
            watch = LiveWatch(node, nodes)
            watch.until(lambda: 'waiting' in watch.message, 120.0)
            nodes.start(
                'depth_source', bag=fitted.parent / 'bag', loop=True, wait_for_subscriber=60.0
            )
            watch.until(lambda: bool(watch.tracked), 120.0)
            watch.begin(nodes.process_id('calibration'))
            end = time.monotonic() + seconds
            watch.until(lambda: time.monotonic() > end, seconds + 10.0)
            figures = {'tets': scene.mesh.tet_count, **watch.figures(seconds)}
            if len(factors) > 1:
                truths = [MODULUS * factor for factor in factors]
                figures['steps'] = watch.steps(truths, settings.timing.frames, _RATE)
    rclpy.shutdown()
    return figures


if __name__ == '__main__':
    main()
