# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Judge how well a live body was followed."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
import os
from typing import Any

from live_watch import FIT, LiveWatch, Resources, SECOND, Told
import numpy as np

_FIRST_STAMP_NS = 1_700_000_000_000_000_000
_WITHIN = 0.05  # Of the true modulus.
_LASTS = 10  # So many frames within that are not passing by chance.
_MEMORY_POINTS = 60


@dataclass(frozen=True)
class TrueState:
    """What the body is for a stretch of the recording.

    Attributes:
        name: for the figures.
        modulus: that is to be found [Pa]; None where the model cannot show the body.
    """

    name: str
    modulus: float | None


def stream_figures(watch: LiveWatch, begun: dict[str, int], seconds: float) -> dict[str, Any]:
    """Return shares, latencies and memory.

    Args:
        watch: that has listened for a while.
        begun: its counts at the beginning.
        seconds: for which it has listened since.
    """
    counts = {name: value - begun[name] for name, value in watch.counts().items()}
    moduli = np.array([told.modulus for told in watch.told])
    return {
        'seconds': seconds,
        **counts,
        'used_share': counts['frames used'] / max(1, counts['messages received']),
        'frame_to_parameters': latency_figures(watch, watch.told),
        'update_time_last_s': float(watch.status[FIT]['update time [s]']),
        'modulus_mean_pa': float(moduli.mean()),
        'modulus_std_pa': float(moduli.std()),
        'modulus_std_error_pa': float(np.mean([told.std_error for told in watch.told])),
        **_resource_figures(watch.resources),
        # Above the number of cores the latencies tell of other programs as well.
        'load_average': os.getloadavg(),
    }


def latency_figures(watch: LiveWatch, told: Sequence[Told]) -> dict[str, Any]:
    """Return how long it took from a frame's publication to that of its parameters."""
    waits = [
        (one.published_ns - watch.sent_ns[one.stamp_ns]) / 1e6
        for one in told
        if one.stamp_ns in watch.sent_ns
    ]
    if not waits:
        return {'frames': 0}
    p50, p99 = np.percentile(waits, [50.0, 99.0])
    return {
        'frames': len(waits),
        'p50_ms': round(float(p50), 2),
        'p99_ms': round(float(p99), 2),
        'largest_ms': round(max(waits), 2),
    }


def step_figures(
    watch: LiveWatch, states: Sequence[TrueState], frames: int, rate: float
) -> dict[str, Any]:
    """Return how soon each change of the body was followed and told [s].

    From the publication of the first frame that shows it to that of the parameters.

    Args:
        watch: that has listened for a while.
        states: that take turns.
        frames: for which each lasts.
        rate: of the frames [Hz]; stamps go on by one period from frame to frame.
    """
    told, period = watch.told, round(SECOND / rate)
    stamps = np.array([one.stamp_ns for one in told])
    numbers = np.round((stamps - _FIRST_STAMP_NS) / period).astype(int)
    shown = (numbers // frames) % len(states)
    begins = np.flatnonzero(np.diff(shown)) + 1
    found: dict[str, dict[str, list[float | None]]] = {
        state.name: {'followed_s': [], 'told_s': []} for state in states
    }
    for begin, end in pairwise(begins):
        state, stretch = states[shown[begin]], told[begin:end]
        first = _FIRST_STAMP_NS + int(numbers[begin]) // frames * frames * period
        if first not in watch.sent_ns:
            continue
        figures, sent_ns = found[state.name], watch.sent_ns[first]
        news = _first_told(stretch, told[begin - 1].change_count)
        figures['told_s'].append(_seconds(news, sent_ns))
        if state.modulus is not None:
            near = _first_near(stretch, state.modulus)
            figures['followed_s'].append(_seconds(near, sent_ns))
    return found


def _first_told(stretch: Sequence[Told], count: int) -> Told | None:
    return next((one for one in stretch if one.change_count > count), None)


def _first_near(stretch: Sequence[Told], truth: float) -> Told | None:
    is_near = np.array([abs(one.modulus / truth - 1.0) < _WITHIN for one in stretch])
    for place in np.flatnonzero(is_near):
        if is_near[place:][:_LASTS].all():
            return stretch[place]
    return None


def _seconds(one: Told | None, sent_ns: int) -> float | None:
    return None if one is None else round((one.published_ns - sent_ns) / SECOND, 3)


def _resource_figures(resources: Sequence[Resources]) -> dict[str, Any]:
    first, last = resources[0], resources[-1]
    memory = np.array([[one.time, one.memory] for one in resources])
    thinned = memory[:: max(1, len(memory) // _MEMORY_POINTS)]
    return {
        'processor_share_of_one_core': round(
            (last.processor - first.processor) / (last.time - first.time), 3
        ),
        'memory_seconds': [round(t) for t in thinned[:, 0].tolist()],
        'memory_mb': [round(m, 1) for m in thinned[:, 1].tolist()],
        'memory_growth_mb': round(float(memory[-10:, 1].mean() - memory[:10, 1].mean()), 2),
    }
