# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Replay 1024x768 depth at 30 Hz from the depth source to the calibration node: share and delay.

Build first and source install/setup.bash, as `make demo` does: the nodes are the installed
executables, with the shipped Fast DDS profile. Writes results/replay.json.

    python benchmarks/replay.py [SECONDS]
"""

import os
from pathlib import Path
import sys
import tempfile
import time

from diagnostic_msgs.msg import DiagnosticArray
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.recording.bag_writer import BagWriter
from diffcal_ros.recording.topics.names import DEPTH_FRAME
from measuring import write
import numpy as np
from rcl_interfaces.msg import Parameter
from rcl_interfaces.srv import SetParameters
import rclpy
from rclpy.node import Node
from rclpy.parameter import Parameter as Value

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / 'demo'))
from node_process import join_quiet_domain, NodeGroup  # noqa: E402

_CAMERA = PinholeCamera(1024, 768, 731.0, 730.0, 511.0, 384.0)
_RATE, _BAG_SECONDS = 30, 10
_START_NS = 1_700_000_000_000_000_000
_SOURCE, _SINK = 'depth_source: replay', 'calibration: input'


def main() -> None:
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 60.0
    join_quiet_domain()
    figures = {}
    for encoding in ('16UC1', '32FC1'):
        with tempfile.TemporaryDirectory() as folder:
            bag = _write_bag(Path(folder) / 'bag', encoding)
            figures[encoding] = _replay(bag, Path(folder), seconds)
    write('replay', {'rate_hz': _RATE, 'image': '1024x768', 'seconds': seconds, **figures})


def _write_bag(path: Path, encoding: str) -> Path:
    """Write ten seconds of a wavy wall with noise in quarter millimetres."""
    random = np.random.default_rng(1)
    rows, columns = np.mgrid[: _CAMERA.height, : _CAMERA.width]
    wall = 0.5 + 0.05 * np.sin(rows / 40.0) * np.cos(columns / 60.0)
    with BagWriter(path) as bag:
        for index in range(_RATE * _BAG_SECONDS):
            stamp = _START_NS + index * 1_000_000_000 // _RATE
            noisy = wall + 0.0005 * random.standard_normal(wall.shape, dtype=np.float32)
            depth = (np.round(noisy / 0.00025) * 0.00025).astype(np.float32)
            bag.write_depth_camera(_CAMERA, stamp_ns=stamp, frame_id=DEPTH_FRAME)
            bag.write_depth(DepthFrame(depth, stamp, DEPTH_FRAME), encoding=encoding)
    return path


def _replay(bag: Path, folder: Path, seconds: float) -> dict[str, float]:
    """Replay in a loop, then stop and compare what was sent with what came."""
    rclpy.init()
    node = rclpy.create_node('replay_benchmark')
    status: dict[str, dict[str, str]] = {}

    def note(message: DiagnosticArray) -> None:
        for part in message.status:
            status[part.name] = {pair.key: pair.value for pair in part.values}

    node.create_subscription(DiagnosticArray, '/diagnostics', note, 10)
    pause = node.create_client(SetParameters, 'depth_source/set_parameters')
    with NodeGroup(folder / 'log') as nodes:
        nodes.start('calibration', scene=ROOT / 'bags/sample/scene.yaml')
        _spin(node, 15.0)  # Its kernels are compiled, or they would take part.
        nodes.start('depth_source', bag=bag, loop=True, wait_for_subscriber=60.0)
        while int(status.get(_SOURCE, {}).get('depth/image_rect_raw sent', 0)) == 0:
            _spin(node, 0.2)
        _spin(node, seconds)
        paused = Parameter(name='paused', value=Value('paused', value=True).get_parameter_value())
        pause.call_async(SetParameters.Request(parameters=[paused]))
        _spin(node, 3.0)
        nodes.check()
    rclpy.shutdown()
    source, sink = status[_SOURCE], status[_SINK]
    sent = int(source['depth/image_rect_raw sent'])
    return {
        'sent': sent,
        'received': int(sink['messages received']),
        'received_share': int(sink['messages received']) / sent,
        'lost': int(sink['messages lost']),
        'sent_rate_hz': sent / seconds,
        'delay_median_ms': float(sink['delay median [ms]']),
        'delay_99_ms': float(sink['delay 99 % [ms]']),
        # Above the number of cores the delays tell of other programs as well.
        'load_average': os.getloadavg()[0],
    }


def _spin(node: Node, seconds: float) -> None:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        rclpy.spin_once(node, timeout_sec=0.1)


if __name__ == '__main__':
    main()
