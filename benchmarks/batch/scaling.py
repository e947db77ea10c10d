# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What Dask's scheduler costs, and how far it carries: real schedulers, tasks that sleep."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
import heapq
import time
from typing import Any

from diffcal_ros.workers.dask_cluster import DaskCluster

# Tasks are this much shorter than measured, so that one worker's run does not take a night.
_SCALE = 0.25
_WORKERS = (1, 2, 4, 8, 16, 32, 64)
# Nobody waits longer than so for the slowest of the smaller clusters [s].
_LONGEST = 150.0
# Of one task of the overhead [s]: about what a small fit takes.
_TASK = 1.0


def overhead(count: int) -> dict[str, Any]:
    """Return what three workers need beyond the tasks themselves, in time and processor."""
    with _cluster(3) as (address, processor):
        _run(address, [0.0] * 3)
        used, begun = processor(), time.perf_counter()
        _run(address, [_TASK] * count)
        seconds = time.perf_counter() - begun
        used = processor() - used
    ideal = _TASK * count / 3.0
    return {
        'workers': 3,
        'tasks': count,
        'task_s': _TASK,
        'ideal_s': ideal,
        'seconds': seconds,
        'overhead': seconds / ideal - 1.0,
        'processor_s_a_task': used / count,
        'processor_share': used / (_TASK * count),
    }


def scaling(task_seconds: Sequence[float]) -> dict[str, Any]:
    """Return how long batches of measured tasks take on more and more workers.

    Args:
        task_seconds: measured [s].
    """
    tasks = [_SCALE * seconds for seconds in task_seconds] * 2
    curve = []
    for workers in _WORKERS:
        ideal = list_schedule(tasks, workers)
        if ideal > _LONGEST:
            continue
        with _cluster(workers) as (address, processor):
            _run(address, [0.0] * workers)
            used, begun = processor(), time.perf_counter()
            _run(address, tasks)
            seconds = time.perf_counter() - begun
            used = processor() - used
        curve.append(
            {
                'workers': workers,
                'seconds': seconds,
                'ideal_s': ideal,
                'speedup': sum(tasks) / seconds,
                'efficiency': sum(tasks) / seconds / workers,
                'beyond_ideal': seconds / ideal - 1.0,
                'processor_s_a_task': used / len(tasks),
            }
        )
        print(curve[-1], flush=True)
    return {
        'tasks': len(tasks),
        'scale': _SCALE,
        'mean_task_s': sum(tasks) / len(tasks),
        'curve': curve,
    }


def list_schedule(tasks: Sequence[float], workers: int) -> float:
    """Return how long tasks take where a worker takes the next one at once (Graham 1969) [s]."""
    ends = [0.0] * workers
    for seconds in tasks:
        heapq.heapreplace(ends, ends[0] + seconds)
    return max(ends)


def _run(address: str, tasks: Sequence[float]) -> None:
    for ended in DaskCluster(address).run(time.sleep, tasks):
        if ended.fault:
            raise SystemExit(f'a sleeping task failed: {ended.fault}')


@contextmanager
def _cluster(workers: int) -> Iterator[tuple[str, Any]]:
    """Start a scheduler and workers in this process: they only wait."""
    from distributed import LocalCluster

    with LocalCluster(
        n_workers=workers,
        threads_per_worker=1,
        processes=False,
        dashboard_address=None,
        protocol='tcp',
        host='127.0.0.1',
        silence_logs=40,
        # All are this process: each would take its memory for its own, and pause.
        memory_limit=None,
    ) as cluster:
        yield cluster.scheduler_address, time.process_time
