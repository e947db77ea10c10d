# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Listen to a calibration node that follows a body, and judge how well it does."""

from collections.abc import Callable, Sequence
from itertools import pairwise
import os
from pathlib import Path
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
import rclpy
from rclpy.node import Node

_FIT, _INPUT = 'calibration: fit', 'calibration: input'
_SECOND = 1_000_000_000  # [ns]
_WITHIN = 0.05  # Of the true modulus.
_LASTS = 10  # So many frames within that are not passing by chance.


class LiveWatch:
    """Notes what a node tells while it tracks."""

    def __init__(self, node: Node, nodes: Any) -> None:
        self.message = ''
        # Stamp, modulus and number of changes told, one a message.
        self.tracked: list[tuple[int, float, int]] = []
        self.memory: list[tuple[float, float]] = []
        self._status: dict[str, dict[str, str]] = {}
        self._begun: dict[str, int] = {}
        self._node, self._nodes = node, nodes
        self._process = 0
        self._since = time.monotonic()
        node.create_subscription(DiagnosticArray, '/diagnostics', self._on_diagnostics, 10)
        node.create_subscription(DiagnosticArray, 'calibration/estimates', self._on_estimates, 50)

    def until(self, is_true: Callable[[], bool], limit: float) -> None:
        """Listen until something is true."""
        end = time.monotonic() + limit
        while not is_true():
            rclpy.spin_once(self._node, timeout_sec=0.1)
            self._nodes.check()
            if time.monotonic() > end:
                raise SystemExit(f'the time is up; the node says: {self.message}')

    def begin(self, process: int) -> None:
        """Count from here.

        Args:
            process: of the node, whose memory is watched.
        """
        end = time.monotonic() + 2.0
        self.until(lambda: time.monotonic() > end, 10.0)
        self._process, self._since = process, time.monotonic()
        self._begun = self._counts()
        self.tracked.clear()

    def figures(self, seconds: float) -> dict[str, Any]:
        """Return shares, latencies and memory since the beginning."""
        end = time.monotonic() + 1.5
        self.until(lambda: time.monotonic() > end, 10.0)
        counts = {name: value - self._begun[name] for name, value in self._counts().items()}
        fit, source = self._status[_FIT], self._status[_INPUT]
        moduli = np.array([modulus for _, modulus, _ in self.tracked])
        memory = np.array(self.memory)
        return {
            'seconds': seconds,
            **counts,
            'used_share': counts['frames used'] / max(1, counts['messages received']),
            'latency_p50_ms': float(fit['latency median [ms]']),
            'latency_p99_ms': float(fit['latency 99 % [ms]']),
            'delay_p50_ms': float(source['delay median [ms]']),
            'delay_p99_ms': float(source['delay 99 % [ms]']),
            'estimates_received': len(moduli),
            'modulus_mean_pa': float(moduli.mean()),
            'modulus_std_pa': float(moduli.std()),
            'memory_mb': [[round(t, 1), round(m, 1)] for t, m in _thinned(memory)],
            'memory_growth_mb': float(memory[-10:, 1].mean() - memory[:10, 1].mean()),
            # Above the number of cores the latencies tell of other programs as well.
            'load_average': os.getloadavg(),
        }

    def steps(self, truths: Sequence[float], frames: int, rate: float) -> dict[str, Any]:
        """Return how soon each step of the modulus was followed and told [s]."""
        period = round(_SECOND / rate)
        stamps = np.array([stamp for stamp, _, _ in self.tracked])
        moduli = np.array([modulus for _, modulus, _ in self.tracked])
        changes = np.array([count for _, _, count in self.tracked])
        # The states take turns, and stamps go on by one period from frame to frame.
        numbers = np.round((stamps - _FIRST_STAMP_NS) / period).astype(int)
        states = (numbers // frames) % len(truths)
        begins = np.flatnonzero(np.diff(states)) + 1
        followed, told = [], []
        for begin, end in pairwise(begins):
            truth = truths[states[begin]]
            is_near = np.abs(moduli[begin:end] / truth - 1.0) < _WITHIN
            lasting = [
                place for place in np.flatnonzero(is_near) if is_near[place:][:_LASTS].all()
            ]
            since = (stamps[begin:end] - stamps[begin]) / _SECOND
            followed.append(float(since[lasting[0]]) if lasting else None)
            news = np.flatnonzero(changes[begin:end] > changes[begin - 1])
            told.append(float(since[news[0]]) if len(news) else None)
        return {'count': len(followed), 'followed_s': followed, 'told_s': told}

    def _counts(self) -> dict[str, int]:
        fit, source = self._status[_FIT], self._status[_INPUT]
        names = ('frames used', 'frames skipped', 'frames refused for their stamp', 'changes')
        counts = {name: int(fit[name]) for name in (*names, 'searches')}
        return {**counts, 'messages received': int(source['messages received'])}

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for part in message.status:
            self._status[part.name] = {pair.key: pair.value for pair in part.values}
            if part.name == _FIT:
                self.message = part.message
        if self._process:
            self.memory.append((time.monotonic() - self._since, _resident_mb(self._process)))

    def _on_estimates(self, message: DiagnosticArray) -> None:
        found = {s.name: s for s in message.status}
        fit = {pair.key: pair.value for pair in found['fit'].values}
        if fit['outcome'] != 'tracking':
            return
        modulus = {pair.key: pair.value for pair in found['youngs_modulus'].values}
        stamp = message.header.stamp.sec * _SECOND + message.header.stamp.nanosec
        self.tracked.append((stamp, float(modulus['value']), int(fit['changes'])))


_FIRST_STAMP_NS = 1_700_000_000_000_000_000


def _resident_mb(process: int) -> float:
    pages = int(Path(f'/proc/{process}/statm').read_text().split()[1])
    return pages * os.sysconf('SC_PAGE_SIZE') / 2**20


def _thinned(rows: np.ndarray) -> np.ndarray:
    return rows[:: max(1, len(rows) // 60)]
