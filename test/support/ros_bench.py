# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A node under test beside a probe that talks DDS to it, and nodes as processes of their own."""

from collections.abc import Callable, Sequence
import gc
from pathlib import Path
import signal
import subprocess
import sys
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rcl_interfaces.srv import SetParametersAtomically
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile

_LIMIT = 60.0  # However slow a machine is: a test that waits so long has failed [s].
# A node tells so often how it is [s]: often, for tests wait for it.
_PERIOD = {'diagnostic_updater.period': 0.1}
# A camera films so often [s].
_FRAME = 0.02
_RUN = 'import sys; from diffcal_ros.ros.{name}_node import main; sys.exit(main())'


def ros_arguments(parameters: dict[str, Any]) -> list[str]:
    """Return parameters as on a command line."""
    pairs = [('-p', f'{key}:={_yaml(value)}') for key, value in parameters.items()]
    return ['--ros-args', *(word for pair in pairs for word in pair)]


def _yaml(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


class RosBench:
    """Spins a probe and the nodes under test; what they raise comes out in the test."""

    def __init__(self, parameters: dict[str, Any], arguments: Sequence[str] = ()) -> None:
        rclpy.init(args=[*ros_arguments({**_PERIOD, **parameters}), *arguments])
        self.executor = SingleThreadedExecutor()
        self.probe = rclpy.create_node('probe')
        self.executor.add_node(self.probe)
        self.nodes: list[Any] = []
        self.health: dict[str, DiagnosticStatus] = {}
        self.probe.create_subscription(DiagnosticArray, '/diagnostics', self._on_diagnostics, 10)

    def add(self, make: Callable[[], Any]) -> Any:
        """Make a node and spin it too."""
        node = make()
        self.nodes.append(node)
        self.executor.add_node(node)
        return node

    def close(self) -> None:
        for node in self.nodes:
            node.close()
        self.executor.shutdown()
        # A node that is only forgotten goes on telling its latched messages until it is collected,
        # to whatever test takes its domain next.
        for node in (*self.nodes, self.probe):
            node.destroy_node()
        self.nodes.clear()
        rclpy.try_shutdown()
        gc.collect()

    def until(self, is_true: Callable[[], Any], what: str, limit: float = _LIMIT) -> Any:
        """Spin until something is true, and return it."""
        end = time.monotonic() + limit
        while not (found := is_true()):
            assert time.monotonic() < end, f'{what} did not come; diagnostics: {self.told()}'
            self.executor.spin_once(timeout_sec=0.02)
        return found

    def film(
        self,
        take: Callable[[], None],
        is_true: Callable[[], Any],
        what: str,
        limit: float = _LIMIT,
    ) -> Any:
        """Take an image after the other until something is true, and return it."""
        next_time = time.monotonic()

        def look() -> Any:
            nonlocal next_time
            if time.monotonic() >= next_time:
                next_time = time.monotonic() + _FRAME
                take()
            return is_true()

        return self.until(look, what, limit)

    def collect(self, kind: Any, topic: str, qos: int | QoSProfile = 10) -> list[Any]:
        """Return a list that fills with what comes on a topic."""
        messages: list[Any] = []
        self.probe.create_subscription(kind, topic, messages.append, qos)
        return messages

    def publisher(self, kind: Any, topic: str) -> Any:
        """Return a publisher that somebody listens to."""
        publisher = self.probe.create_publisher(kind, topic, 10)
        self.until(publisher.get_subscription_count, f'a subscriber to {topic}')
        return publisher

    def call(self, kind: Any, name: str, request: Any = None) -> Any:
        """Call a service."""
        client = self.probe.create_client(kind, name)
        self.until(client.service_is_ready, name)
        answer = client.call_async(request or kind.Request())
        self.until(answer.done, f'an answer of {name}')
        return answer.result()

    def set_parameter(self, node: str, name: str, value: Any) -> Any:
        """Set a parameter as `ros2 param set` does; return the answer."""
        parameter = Parameter(name, value=value).to_parameter_msg()
        request = SetParametersAtomically.Request(parameters=[parameter])
        return self.call(
            SetParametersAtomically, f'{node}/set_parameters_atomically', request
        ).result

    def status(self, part: str, level: bytes, words: str) -> DiagnosticStatus:
        """Wait until a part's diagnosis has a level and says some words."""

        def find() -> DiagnosticStatus | None:
            status = self.health.get(part)
            is_it = status is not None and status.level == level and words in status.message
            return status if is_it else None

        return self.until(find, f'{part} with {words!r}')

    def value(self, part: str, key: str) -> str:
        """Return a figure of the last diagnosis; empty when there is none."""
        status = self.health.get(part)
        pairs = {} if status is None else {pair.key: pair.value for pair in status.values}
        return pairs.get(key, '')

    def told(self) -> dict[str, str]:
        return {name: status.message for name, status in self.health.items()}

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        self.health.update({status.name: status for status in message.status})


class NodeProcess:
    """One node in a process of its own, from whatever tree Python finds the package in."""

    def __init__(self, name: str, parameters: dict[str, Any], log: Path) -> None:
        self.log = log
        with log.open('wb') as output:
            self.child = subprocess.Popen(
                [sys.executable, '-c', _RUN.format(name=name), *ros_arguments(parameters)],
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
            )

    @property
    def output(self) -> str:
        return self.log.read_text(errors='replace')

    def interrupt(self) -> int:
        """End it as Ctrl-C does; return its exit code."""
        self.child.send_signal(signal.SIGINT)
        return self.child.wait(_LIMIT)

    def close(self) -> None:
        if self.child.poll() is None:
            self.child.kill()
            self.child.wait()
