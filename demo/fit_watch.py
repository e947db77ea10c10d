# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Follow a fit on the topics of the calibration node, as any other ROS program could."""

from collections.abc import Callable
import time

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from diffcal_ros.report.naming import short_values, shown, title
from node_process import DemoError, NodeGroup
import rclpy
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_srvs.srv import Trigger

_FIT = 'calibration: fit'
_UNWRITTEN = ('none', 'being written')
_WRITTEN = 'written to '
_TURN = 0.1  # [s]
_LATCHED = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)

Values = dict[str, str]


class FitWatch:
    """Prints what the calibration node tells about its fit."""

    def __init__(self, node: Node, nodes: NodeGroup, deadline: float) -> None:
        """Subscribe.

        Args:
            node: to listen with.
            nodes: must not end while we wait.
            deadline: on the monotonic clock [s].
        """
        self.estimates: dict[str, Values] = {}
        self.health: Values = {}
        self._node = node
        self._nodes = nodes
        self._deadline = deadline
        self._told: dict[str, str] = {}
        node.create_subscription(
            DiagnosticArray, 'calibration/estimates', self._on_estimates, _LATCHED
        )
        node.create_subscription(DiagnosticArray, '/diagnostics', self._on_diagnostics, 10)
        self._save = node.create_client(Trigger, 'calibration/save')

    @property
    def outcome(self) -> str:
        """How the fit ended; empty while it has not."""
        outcome = self.estimates.get('fit', {}).get('outcome', 'running')
        return '' if outcome == 'running' else outcome

    def until(self, is_true: Callable[[], bool], what: str) -> None:
        """Listen until something is true.

        Raises:
            DemoError: when a node ended, or the time is up.
        """
        while not is_true():
            rclpy.spin_once(self._node, timeout_sec=_TURN)
            self._nodes.check()
            if time.monotonic() > self._deadline:
                raise DemoError(f'the time is up while waiting for {what}')

    def save(self) -> str:
        """Have the result written; return the path of the report.

        Raises:
            DemoError: when it cannot be written.
        """
        self.until(self._save.service_is_ready, 'the service calibration/save')
        answer = self._save.call_async(Trigger.Request())
        self.until(answer.done, 'an answer of calibration/save')
        if not answer.result().success:
            raise DemoError(f'calibration/save: {answer.result().message}')
        self.until(lambda: self.health.get('report', 'none') not in _UNWRITTEN, 'the report')
        if not self.health['report'].startswith(_WRITTEN):
            raise DemoError(f'report: {self.health["report"]}')
        return self.health['report'].removeprefix(_WRITTEN)

    def _on_estimates(self, message: DiagnosticArray) -> None:
        self.estimates = {status.name: _values(status) for status in message.status}
        fit = self.estimates['fit']
        if self.outcome:
            return
        fitted = {
            name: float(values['value'])
            for name, values in self.estimates.items()
            if values.get('fixed') == 'false' and values.get('nuisance') == 'false'
        }
        print(
            f'iteration {fit["iteration"]}: loss {float(fit["loss"]):.5g}, '
            f'gap {float(fit["gap_median_mm"]):.2f} mm on {float(fit["coverage"]):.0%}, '
            f'{short_values(fitted)}',
            flush=True,
        )

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            is_fit = status.name == _FIT
            if is_fit:
                self.health = _values(status)
            if status.level == DiagnosticStatus.ERROR or (is_fit and not self.estimates):
                self._show(status)

    def _show(self, status: DiagnosticStatus) -> None:
        """Print a sentence when it is new; counts in it are no news."""
        sentence = ''.join(letter for letter in status.message if not letter.isdigit())
        if self._told.get(status.name) != sentence:
            self._told[status.name] = sentence
            print(f'{status.name}: {status.message}', flush=True)


def result_lines(estimates: dict[str, Values]) -> list[str]:
    """Write the last estimates for people."""
    fit = estimates['fit']
    lines = [f'{fit["outcome"].replace("_", " ")}: {fit["remedy"]}']
    for name, values in estimates.items():
        if values.get('fixed') != 'false' or values['nuisance'] != 'false':
            continue
        unit, start = values['unit'], shown(float(values['start']), 0.0, values['unit'])
        fitted = shown(float(values['value']), float(values['std_error']), unit)
        lines.append(f'  {title(name):<32} {fitted.text():<24} started at {start.text()}')
    lines.append(
        f'  gap: median {float(fit["gap_median_mm"]):.3g} mm, RMS '
        f'{float(fit["gap_rms_mm"]):.3g} mm on {float(fit["coverage"]):.1%} of the body in view'
    )
    lines += [f'  warning: {warning}' for warning in fit['warnings'].split('; ') if warning]
    return lines


def _values(status: DiagnosticStatus) -> Values:
    return {pair.key: pair.value for pair in status.values}
