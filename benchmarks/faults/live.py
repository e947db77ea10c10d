# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A day's worth of faults in ten minutes: three nodes, real DDS, and a camera that errs.

    python -m benchmarks.faults.live [--seconds 600] [--seed 3]

Every fault lasts for some seconds, and good frames follow until the fit goes on. Notes what
/diagnostics and the logs told of each, whether all nodes live and recover, and what memory they
use. Writes benchmarks/results/live_faults.json; exits with 1 where a node died, did not recover,
said nothing, or said the same thing over and over.
"""

import argparse
from collections import Counter
from collections.abc import Callable
import os
from pathlib import Path
import re
import sys
import tempfile
import time
from typing import Any

import numpy as np

from benchmarks.faults.kill_nodes import domain_settings, NODES, start_node
from benchmarks.faults.live_camera import (
    Camera,
    COLOR,
    cut_off,
    DEPTH,
    nothing,
    with_fields,
    with_header,
    with_pixels,
)
from benchmarks.faults.running import Running
from benchmarks.faults.small_scene import make_small_scene
from benchmarks.measuring import write

_LASTS = 6.0  # A fault [s].
_RECOVERS = 60.0  # On a busy machine, within [s].
# What /diagnostics remembers: after it, what is told is of the next fault [s].
_FORGOTTEN = 11.0
_FIRST_FIT = 180.0  # Kernels may have to be compiled [s].
_OFTEN = 3  # The same line so often within one fault is a flood.
_OK = b'\x00'
_TIME = re.compile(r'\[\d+\.\d+\]|[\d.]+')
_SECOND = 1_000_000_000  # [ns]


def _spoiling(stream: str, change: Any) -> Callable[[Camera], None]:
    return lambda camera: camera.spoil.update({stream: change})


def _spoiling_info(stream: str, change: Any) -> Callable[[Camera], None]:
    return lambda camera: camera.spoil_info.update({stream: change})


def _shifting(seconds: int) -> Callable[[Camera], None]:
    return lambda camera: setattr(camera, 'shift_ns', seconds * _SECOND)


# A fault, and whether it need not be told: the nodes just go on.
FAULTS: dict[str, tuple[Callable[[Camera], None], bool]] = {
    'publishers restart': (lambda camera: camera.restart(), True),
    'best effort': (lambda camera: camera.restart(is_best_effort=True), True),
    'clock back': (_shifting(-100), True),
    'clock ahead': (_shifting(100), True),
    'bursts': (lambda camera: setattr(camera, 'burst', 30), True),
    'colour as depth': (_spoiling(DEPTH, with_fields(encoding='rgb8')), False),
    'unknown encoding': (_spoiling(DEPTH, with_fields(encoding='garbage')), False),
    'half as wide': (_spoiling(DEPTH, with_fields(width=160)), False),
    'rows too short': (_spoiling(DEPTH, with_fields(step=3)), False),
    'cut off': (_spoiling(DEPTH, cut_off), False),
    'no frame': (_spoiling(DEPTH, with_header(frame_id='')), False),
    'no depth at all': (_spoiling(DEPTH, with_pixels(lambda d: d * np.nan)), False),
    'zeros': (_spoiling(DEPTH, with_pixels(lambda d: d * 0.0)), False),
    'millimetres as metres': (_spoiling(DEPTH, with_pixels(lambda d: d * 1000.0)), False),
    'an infinity': (_spoiling(DEPTH, with_pixels(lambda d: d + np.inf)), False),
    'camera dead': (_spoiling(DEPTH, nothing), False),
    'uncalibrated': (_spoiling_info(DEPTH, with_fields(k=np.zeros(9), p=np.zeros(12))), False),
    'camera_info of another size': (_spoiling_info(DEPTH, with_fields(width=99)), False),
    'camera_info of NaN': (_spoiling_info(DEPTH, with_fields(k=np.full(9, np.nan))), False),
    'colour gone': (_spoiling(COLOR, nothing), True),
    'colour cut off': (_spoiling(COLOR, cut_off), False),
}
GONE = 'transform gone'


class Watch:
    """What the nodes tell, and how much memory they have to themselves."""

    def __init__(self, node: Any, running: dict[str, Running]) -> None:
        from diagnostic_msgs.msg import DiagnosticArray

        self._node, self._running = node, running
        self.estimates = 0
        self.trouble: dict[str, str] = {}
        self.memory: list[tuple[float, dict[str, float]]] = []
        node.create_subscription(DiagnosticArray, '/diagnostics', self._on_diagnostics, 50)
        node.create_subscription(DiagnosticArray, '/calibration/estimates', self._on_estimates, 50)

    def spin(
        self, camera: Camera, seconds: float, until: Callable[[], bool] | None = None
    ) -> bool:
        """Let the camera film for a while, or until something is true; return whether it is."""
        import rclpy

        end = time.monotonic() + seconds
        while time.monotonic() < end:
            camera.film()
            rclpy.spin_once(self._node, timeout_sec=0.01)
            self._note_memory()
            if until is not None and until():
                return True
        return until is None

    def alive(self) -> bool:
        """Tell whether all nodes run."""
        return all(one.process.poll() is None for one in self._running.values())

    def lines(self) -> Counter[str]:
        """Count what the logs say above INFO, whatever the numbers in it."""
        found: Counter[str] = Counter()
        for name, one in self._running.items():
            for line in one.said.splitlines():
                if '[WARN]' in line or '[ERROR]' in line or 'Traceback' in line:
                    found[f'{name}: {_TIME.sub("#", line)}'] += 1
        return found

    def _note_memory(self) -> None:
        now = time.monotonic()
        if self.memory and now - self.memory[-1][0] < 1.0:
            return
        sizes = {name: _private(one.process.pid) for name, one in self._running.items()}
        self.memory.append((now, sizes))

    def _on_diagnostics(self, message: Any) -> None:
        for status in message.status:
            if status.level != _OK:
                self.trouble[status.name] = status.message

    def _on_estimates(self, message: Any) -> None:
        self.estimates += 1


def _private(process: int) -> float:
    """Return the memory that a process has to itself [MB].

    Shared memory of DDS counts where it is looked at, in each of its readers, and is of a fixed
    size: 64 MiB a process that sends, as config/fastdds_large_images.xml says.
    """
    try:
        lines = Path(f'/proc/{process}/status').read_text().splitlines()
    except OSError:
        return 0.0
    return sum(int(line.split()[1]) * 1.024e-3 for line in lines if line.startswith('RssAnon:'))


def try_fault(
    name: str, watch: Watch, camera: Camera, set_transform: Callable[[bool], None]
) -> dict[str, Any]:
    """Let the camera err for a while, then film well; return what was seen."""
    before = watch.lines()
    watch.trouble.clear()
    if name == GONE:
        set_transform(False)
    else:
        FAULTS[name][0](camera)
    watch.spin(camera, _LASTS)
    told = dict(watch.trouble)
    camera.behave()
    if name == GONE:
        set_transform(True)
    if name == 'best effort':
        camera.restart()
    watch.estimates = 0
    begun = time.monotonic()
    recovered = watch.spin(camera, _RECOVERS, lambda: watch.estimates > 2 or not watch.alive())
    recovered_s = round(time.monotonic() - begun, 1) if recovered else None
    watch.spin(camera, _FORGOTTEN)
    said = watch.lines() - before
    return {
        'fault': name,
        'alive': watch.alive(),
        'recovered_s': recovered_s,
        'told': told,
        'log_lines': sum(said.values()),
        'most_often': max(said.values(), default=0),
        'tracebacks': sum('Traceback' in line for line in said),
        'memory_mb': {name: round(size, 1) for name, size in watch.memory[-1][1].items()},
    }


def problems_of(found: dict[str, Any]) -> list[str]:
    """List what is wrong with what was seen of one fault."""
    name = found['fault']
    is_quiet = name in FAULTS and FAULTS[name][1]
    problems = []
    if not found['alive']:
        problems.append('a node died')
    if found['recovered_s'] is None:
        problems.append('the fit did not go on')
    if not found['told'] and not is_quiet:
        problems.append('not told')
    if found['most_often'] > _OFTEN:
        problems.append(f'the same line {found["most_often"]} times')
    if found['tracebacks']:
        problems.append('a traceback')
    return problems


def main() -> int:
    """Run the program; return its exit status."""
    import rclpy

    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--seconds', type=float, default=600.0)
    parser.add_argument('--seed', type=int, default=3)
    given = parser.parse_args()
    random = np.random.default_rng(given.seed)
    os.environ.update(domain_settings(random))
    rclpy.init()
    node = rclpy.create_node('erring_camera')
    with tempfile.TemporaryDirectory() as text:
        folder = Path(text)
        scene = make_small_scene(folder / 'scene')
        parameters: dict[str, dict[str, Any]] = {
            'calibration': {'scene': scene.scene, 'window.frames': 5, 'mesh_error': False},
            'marker_pose': {'scene': scene.scene},
            'depth_source': {},
        }
        running = {name: start_node(name, parameters[name], folder / name) for name in NODES}
        try:
            watch, camera = Watch(node, running), Camera(node, scene.bag)
            found = _try_all(watch, camera, random, given.seconds)
        finally:
            for one in running.values():
                one.end()
    node.destroy_node()
    rclpy.try_shutdown()
    faults = [[one['fault'], *problems] for one in found if (problems := problems_of(one))]
    figures = {'seed': given.seed, 'seconds': given.seconds, 'faults': faults}
    write('live_faults', {**figures, 'memory_mb': _growth(watch), 'tried': found})
    return 1 if faults else 0


def _try_all(
    watch: Watch, camera: Camera, random: np.random.Generator, seconds: float
) -> list[dict[str, Any]]:
    set_transform = _parameter_setter(watch, camera)
    watch.spin(camera, 5.0)
    set_transform(True)
    if not watch.spin(camera, _FIRST_FIT, lambda: watch.estimates > 2):
        raise SystemExit(f'no fit within {_FIRST_FIT:g} s: {watch.trouble}')
    end, found = time.monotonic() + seconds, []
    while time.monotonic() < end:
        # Each once before any of them again.
        for name in random.permutation([*FAULTS, GONE]):
            if time.monotonic() > end or not watch.alive():
                return found
            found.append(try_fault(str(name), watch, camera, set_transform))
            print(found[-1], flush=True)
    return found


def _parameter_setter(watch: Watch, camera: Camera) -> Callable[[bool], None]:
    """Return what gives or takes the transform between the cameras."""
    from diffcal_ros.rigid_transform import quaternion_xyzw
    from rcl_interfaces.srv import SetParametersAtomically
    from rclpy.parameter import Parameter

    client = watch._node.create_client(
        SetParametersAtomically, '/depth_source/set_parameters_atomically'
    )
    matrix = camera.depth_from_color
    known = [*matrix[:3, 3], *quaternion_xyzw(matrix[:3, :3])]

    def set_transform(is_known: bool) -> None:
        value = [float(number) for number in known] if is_known else [0.0] * 7
        parameter = Parameter('depth_from_color', value=value).to_parameter_msg()
        answer = client.call_async(SetParametersAtomically.Request(parameters=[parameter]))
        watch.spin(camera, 20.0, answer.done)

    return set_transform


def _growth(watch: Watch) -> dict[str, Any]:
    """Compare memory a fifth on with memory at the end."""
    count = len(watch.memory)
    early, late = watch.memory[count // 5 : 2 * count // 5], watch.memory[-count // 5 :]
    return {
        name: {
            'early': round(float(np.median([sizes[name] for _, sizes in early])), 1),
            'late': round(float(np.median([sizes[name] for _, sizes in late])), 1),
            'peak': round(max(sizes[name] for _, sizes in watch.memory), 1),
        }
        for name in NODES
    }


if __name__ == '__main__':
    sys.exit(main())
