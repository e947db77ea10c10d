# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How a node is, at a steady pace on /diagnostics, also when nothing happens."""

from collections.abc import Callable, Mapping

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from diffcal_ros.live.health import Health, Level
from diffcal_ros.live.node_words import for_nodes
from diffcal_ros.ros.parameters import Setting
from diffcal_ros.ros.qos import VALUES
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node

# Named as ROS's diagnostic_updater names it.
PERIOD = Setting(
    'diagnostic_updater.period',
    1.0,
    'time from one message on /diagnostics to the next [s]',
    0.01,
    3600.0,
    is_read_only=True,
)


class DiagnosticsReporter:
    """Publishes a node's health and logs each sentence when it is new."""

    def __init__(
        self, node: Node, examine: Callable[[], Mapping[str, Health]], period: float
    ) -> None:
        """Start.

        Args:
            node: whose health it is.
            examine: returns the health of each part.
            period: from one message to the next [s], see `PERIOD`.
        """
        self._node = node
        self._examine = examine
        self._told: dict[str, str] = {}
        self._publisher = node.create_publisher(DiagnosticArray, '/diagnostics', VALUES)
        # Steady: simulated time may stand still, and that is when a diagnosis is wanted.
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = node.create_timer(period, self.report, clock=steady)

    def report(self) -> None:
        """Publish now."""
        parts = self._examine()
        message = DiagnosticArray()
        message.header.stamp = self._node.get_clock().now().to_msg()
        owner = self._node.get_fully_qualified_name().lstrip('/')
        for part, health in parts.items():
            message.status.append(status_message(f'{owner}: {part}', health))
            self._log(part, health)
        self._publisher.publish(message)

    def _log(self, part: str, health: Health) -> None:
        # Counts in a sentence change all the time: only another sentence is news.
        sentence = ''.join(letter for letter in health.message if not letter.isdigit())
        if self._told.get(part) == sentence:
            return
        self._told[part] = sentence
        logger = self._node.get_logger()
        text = f'{part}: {for_nodes(health.message)}'
        # rclpy remembers the level of each line of code that logs: one line a level.
        if health.level is Level.ERROR:
            logger.error(text)
        elif health.level is Level.WARN:
            logger.warning(text)
        else:
            logger.info(text)


def status_message(name: str, health: Health, hardware_id: str = '') -> DiagnosticStatus:
    """Turn a health into a message."""
    return DiagnosticStatus(
        level=bytes([health.level]),
        name=name,
        message=for_nodes(health.message),
        hardware_id=hardware_id,
        values=[KeyValue(key=key, value=value) for key, value in health.values.items()],
    )
