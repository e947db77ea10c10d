# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Timing and reporting for every measured process; needs NumPy and nothing of ours.

Each package is measured in a process of its own: peers run with the Python of their environment,
which cannot import diffcal_ros.
"""

from collections.abc import Callable
import json
import resource
import statistics
import sys
import time
from typing import Any

import numpy as np

Case = dict[str, Any]
# A study takes the case and returns figures, and arrays for the main process to judge.
Study = Callable[[Case], tuple[dict[str, Any], dict[str, Any]]]


def timed(work: Callable[[], Any], *, repeats: int = 7, budget: float = 40.0) -> dict[str, Any]:
    """Return median processor and wall seconds of a call; the first call is told apart.

    Args:
        work: what to time.
        repeats: most calls after the first.
        budget: no new call begins after so many seconds of them [s], save the first two.
    """
    first = _once(work)
    calls: list[tuple[float, float]] = []
    begun = time.perf_counter()
    while len(calls) < repeats and (len(calls) < 2 or time.perf_counter() - begun < budget):
        calls.append(_once(work))
    cpu, wall = (statistics.median(column) for column in zip(*calls, strict=True))
    return {
        'cpu_s': cpu,
        'wall_s': wall,
        'repeats': len(calls),
        'first_call_cpu_s': first[0],
        # What the first call does and later ones need not: compiling above all.
        'compile_cpu_s': max(first[0] - cpu, 0.0),
    }


def _once(work: Callable[[], Any]) -> tuple[float, float]:
    cpu, wall = time.process_time(), time.perf_counter()
    work()
    return time.process_time() - cpu, time.perf_counter() - wall


def peak_memory_mb() -> float:
    """Return the most memory that this process has held so far [MB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e6


def run_studies(versions: dict[str, str], studies: dict[str, Study]) -> None:
    """Run a package's studies on the case of the command line; print one line of JSON.

    The command line names the case's .npz file and the .npz file for arrays. A study that fails
    says why and leaves the others alone.

    Args:
        versions: of the packages measured.
        studies: by name.
    """
    with np.load(sys.argv[1]) as stored:
        case = {name: _plain(stored[name]) for name in stored.files}
    figures: dict[str, Any] = {'versions': versions, 'imported_mb': peak_memory_mb()}
    arrays: dict[str, Any] = {}
    for name, study in studies.items():
        try:
            found, own = study(case)
        except Exception as fault:  # Whatever another package raises is an answer as well.
            reason = ' '.join(f'{type(fault).__name__}: {fault}'.split())
            figures[name] = {'failed': last_line(reason)}
            continue
        # Studies follow each other in one process: of a later one this is an upper bound.
        figures[name] = {**found, 'peak_memory_mb': peak_memory_mb()}
        arrays.update({f'{name}.{key}': value for key, value in own.items()})
    np.savez(sys.argv[2], **arrays)
    print(json.dumps(figures))


def last_line(text: str) -> str:
    """Return the last line with anything in it, at most 300 characters."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return lines[-1][:300] if lines else 'no message'


def _plain(value: Any) -> Any:
    return value.item() if value.ndim == 0 else value
