# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Kill one of three nodes that work together, again and again; the others go on, it returns."""

from collections.abc import Iterator
import os
from pathlib import Path
import time
from typing import Any

import numpy as np

from benchmarks.faults.running import damaged_files, Running, start
from benchmarks.faults.small_scene import SmallScene

NODES = ('calibration', 'depth_source', 'marker_pose')
_RUN = 'import sys; from diffcal_ros.ros.{name}_node import main; sys.exit(main())'
# A node may have got anywhere by then [s].
_LONGEST = 8.0
# To fit once more when all is over, on a busy machine [s].
_PATIENCE = 180.0
_SAVES = 0.2  # Between two orders to save [s].


def domain_settings(random: np.random.Generator) -> dict[str, str]:
    """Return what keeps nodes among themselves, on this machine."""
    root = Path(__file__).resolve().parents[2]
    return {
        'ROS_DOMAIN_ID': str(int(random.integers(1, 102))),
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
        'FASTRTPS_DEFAULT_PROFILES_FILE': str(root / 'config' / 'fastdds_large_images.xml'),
    }


def start_node(name: str, parameters: dict[str, Any], log: Path) -> Running:
    """Start a node of this package."""
    words = ['--ros-args']
    for key, value in parameters.items():
        words += ['-p', f'{key}:={str(value).lower() if isinstance(value, bool) else value}']
    return start(words, log, program=_RUN.format(name=name))


def kill_nodes(
    scene: SmallScene, folder: Path, count: int, random: np.random.Generator
) -> Iterator[tuple[str, str]]:
    """Kill nodes at `count` random moments; yield what came of each: a kind and details."""
    folder.mkdir()
    os.environ.update(domain_settings(random))
    out = folder / 'out'
    given: dict[str, dict[str, Any]] = {
        'calibration': {'scene': scene.scene, 'out': out, 'window.frames': 3, 'mesh_error': False},
        'depth_source': {'bag': scene.bag, 'loop': True, 'subscribers': 2},
        'marker_pose': {'scene': scene.scene},
    }
    watcher = _Watcher()
    running = {name: start_node(name, given[name], folder / name) for name in NODES}
    try:
        for _ in range(count):
            name = str(random.choice(NODES))
            share = float(random.random())
            watcher.spin(share * _LONGEST)
            victim = running[name]
            at = f'{name} killed after {share * _LONGEST:.1f} s'
            victim.kill()
            victim.ends_within(10.0)
            dead = [other for other in NODES if other != name and _has_ended(running[other])]
            halves, left = damaged_files(out), victim.left_running()
            if dead:
                yield 'died with it', f'{at}: {", ".join(dead)}'
            elif halves:
                yield 'half a file', f'{at}: {", ".join(halves)}'
            elif left:
                yield 'left running', at
            else:
                yield 'killed', at
            victim.end()
            running[name] = start_node(name, given[name], folder / name)
        yield watcher.fits_again()
        yield from _end(running)
    finally:
        for one in running.values():
            one.end()
        watcher.close()


def _has_ended(running: Running) -> bool:
    return running.process.poll() is not None


def _end(running: dict[str, Running]) -> Iterator[tuple[str, str]]:
    """End all as Ctrl-C does."""
    import signal

    for one in running.values():
        one.kill(signal.SIGINT)
    for name, one in running.items():
        if not one.ends_within(30.0) or one.process.returncode != 0:
            yield 'rerun wrong', f'{name} ends with {one.process.poll()}: {one.said[-500:]}'
        elif 'Traceback' in one.said:
            yield 'traceback', f'{name}: {one.said[-500:]}'


class _Watcher:
    """A node that orders the calibration to save, and looks whether it fits."""

    def __init__(self) -> None:
        from diagnostic_msgs.msg import DiagnosticArray
        import rclpy
        from std_srvs.srv import Trigger

        rclpy.init()
        self._rclpy = rclpy
        self._request = Trigger.Request()
        self._node = rclpy.create_node('watcher')
        self._save = self._node.create_client(Trigger, '/calibration/save')
        self._saved, self._estimates = 0, 0
        self._node.create_subscription(
            DiagnosticArray, '/calibration/estimates', self._on_estimates, 10
        )

    def spin(self, seconds: float) -> None:
        """Let time pass, and order to save all the while."""
        end, next_save = time.monotonic() + seconds, 0.0
        while time.monotonic() < end:
            if time.monotonic() > next_save and self._save.service_is_ready():
                self._save.call_async(self._request).add_done_callback(self._on_answer)
                next_save = time.monotonic() + _SAVES
            self._rclpy.spin_once(self._node, timeout_sec=0.05)

    def fits_again(self) -> tuple[str, str]:
        """Wait until something is fitted and saved."""
        self._saved = self._estimates = 0
        end = time.monotonic() + _PATIENCE
        while time.monotonic() < end:
            self.spin(0.5)
            if self._saved and self._estimates:
                return 'rerun right', 'nodes'
        return 'rerun wrong', f'nodes: {self._estimates} estimates, {self._saved} saved'

    def close(self) -> None:
        self._node.destroy_node()
        self._rclpy.try_shutdown()

    def _on_answer(self, future: Any) -> None:
        answer = future.result()
        self._saved += bool(answer is not None and answer.success)

    def _on_estimates(self, message: Any) -> None:
        self._estimates += 1
