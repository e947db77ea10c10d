# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Listen to a calibration node that follows a body, as any other ROS program could."""

from collections.abc import Callable
from dataclasses import dataclass
import os
from pathlib import Path
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
import rclpy
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import CameraInfo, Image
from visualization_msgs.msg import Marker

FIT, INPUT = 'calibration: fit', 'calibration: input'
SECOND = 1_000_000_000  # [ns]
_PICTURES = (
    (Image, 'calibration/rendered/image'),
    (Image, 'calibration/residual'),
    (Marker, 'calibration/mesh'),
)
_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


@dataclass(frozen=True)
class Told:
    """What a node told after a frame.

    Attributes:
        stamp_ns: of the frame [ns].
        published_ns: when it was told, system time [ns].
        modulus: [Pa].
        std_error: [Pa].
        change_count: changes of the body so far.
        is_looked_at: somebody looked at pictures.
    """

    stamp_ns: int
    published_ns: int
    modulus: float
    std_error: float
    change_count: int
    is_looked_at: bool


@dataclass(frozen=True)
class Resources:
    """What a process used so far.

    Attributes:
        time: since the beginning [s].
        memory: resident [MB].
        processor: time of all its threads [s].
    """

    time: float
    memory: float
    processor: float


class LiveWatch:
    """Notes what a node tells while it tracks.

    Attributes:
        message: the node's own words on how it is.
        told: after each frame.
        sent_ns: when each frame was published, by its stamp [ns].
        resources: of its process, once a second.
        picture_count: pictures received.
    """

    def __init__(self, node: Node, nodes: Any) -> None:
        self.message = ''
        self.told: list[Told] = []
        self.sent_ns: dict[int, int] = {}
        self.resources: list[Resources] = []
        self.picture_count = 0
        self.status: dict[str, dict[str, str]] = {}
        self._node, self._nodes = node, nodes
        self._process = 0
        self._since = time.monotonic()
        self._pictures: list[Any] = []
        node.create_subscription(DiagnosticArray, '/diagnostics', self._on_diagnostics, 10)
        node.create_subscription(DiagnosticArray, 'calibration/estimates', self._on_estimates, 50)
        # Published with each depth image, and not a hundred times as large.
        node.create_subscription(CameraInfo, 'depth/camera_info', self._on_camera_info, 50)

    def until(self, is_true: Callable[[], bool], limit: float) -> None:
        """Listen until something is true."""
        end = time.monotonic() + limit
        while not is_true():
            rclpy.spin_once(self._node, timeout_sec=0.1)
            self._nodes.check()
            if time.monotonic() > end:
                raise SystemExit(f'the time is up; the node says: {self.message}')

    def listen(self, seconds: float) -> None:
        """Listen for a while."""
        end = time.monotonic() + seconds
        self.until(lambda: time.monotonic() > end, seconds + 10.0)

    def begin(self, process: int) -> None:
        """Note from here on.

        Args:
            process: of the node, whose resources are watched.
        """
        self.listen(2.0)
        self._process, self._since = process, time.monotonic()
        self.told.clear()
        self.sent_ns.clear()

    def look(self, does_look: bool) -> None:
        """Begin or end to look at all pictures."""
        if does_look and not self._pictures:
            # Raw: what it costs to read them is not the node's.
            self._pictures = [
                self._node.create_subscription(kind, topic, self._on_picture, _LATCHED, raw=True)
                for kind, topic in _PICTURES
            ]
        elif not does_look:
            for subscription in self._pictures:
                self._node.destroy_subscription(subscription)
            self._pictures = []

    def counts(self) -> dict[str, int]:
        """Return what the node has counted so far."""
        fit, source = self.status[FIT], self.status[INPUT]
        names = ('frames used', 'frames skipped', 'frames refused for their stamp', 'changes')
        counted = {name: int(fit[name]) for name in (*names, 'searches')}
        received = ('messages received', 'messages lost')
        return {**counted, **{name: int(source[name]) for name in received}}

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for part in message.status:
            self.status[part.name] = {pair.key: pair.value for pair in part.values}
            if part.name == FIT:
                self.message = part.message
                if self._process:
                    self.resources.append(_resources(self._process, self._since))

    def _on_estimates(self, message: DiagnosticArray, info: dict[str, int]) -> None:
        found = {s.name: s for s in message.status}
        fit = {pair.key: pair.value for pair in found['fit'].values}
        if fit['outcome'] != 'tracking':
            return
        modulus = {pair.key: pair.value for pair in found['youngs_modulus'].values}
        self.told.append(
            Told(
                stamp_ns=_stamp_ns(message),
                published_ns=info['source_timestamp'],
                modulus=float(modulus['value']),
                std_error=float(modulus['std_error']),
                change_count=int(fit['changes']),
                is_looked_at=bool(self._pictures),
            )
        )

    def _on_camera_info(self, message: CameraInfo, info: dict[str, int]) -> None:
        self.sent_ns[_stamp_ns(message)] = info['source_timestamp']

    def _on_picture(self, message: bytes) -> None:
        self.picture_count += 1


def set_nice(process: int, nice: int) -> None:
    """Give a node that leads a session of its own more or less than its share of the cores."""
    if nice:
        # The scheduler of a desktop shares between sessions first, then within them.
        Path(f'/proc/{process}/autogroup').write_text(str(nice))


def _stamp_ns(message: Any) -> int:
    stamp = message.header.stamp
    return int(stamp.sec) * SECOND + int(stamp.nanosec)


def _resources(process: int, since: float) -> Resources:
    folder = Path(f'/proc/{process}')
    pages = int((folder / 'statm').read_text().split()[1])
    times = (folder / 'stat').read_text().rpartition(')')[2].split()
    ticks = int(times[11]) + int(times[12])  # In user mode and in the kernel.
    return Resources(
        time=time.monotonic() - since,
        memory=pages * os.sysconf('SC_PAGE_SIZE') / 2**20,
        processor=ticks / os.sysconf('SC_CLK_TCK'),
    )
