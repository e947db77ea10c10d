# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A real scheduler and three workers, one of which dies."""

from diffcal_ros.errors import InputError
from diffcal_ros.workers.dask_cluster import DaskCluster
import pytest
from support.dask_processes import dask_processes
from support.small_tasks import fail_at_three, fall_once, number

pytest.importorskip('distributed', reason='Dask is not installed')


@pytest.fixture(scope='module')
def three_workers(tmp_path_factory):
    """A scheduler and three workers."""
    with dask_processes(tmp_path_factory.mktemp('dask'), 3) as running:
        yield running


def test_all_workers_work(three_workers) -> None:
    ended = list(DaskCluster(three_workers.address).run(number, range(30)))
    assert sorted(one.result[0] for one in ended) == list(range(30))
    assert {one.result[1] for one in ended} == {worker.pid for worker in three_workers.workers}


def test_a_task_that_fails_does_not_end_the_others(three_workers) -> None:
    ended = {
        one.task: one for one in DaskCluster(three_workers.address).run(fail_at_three, range(5))
    }
    assert ended.pop(3).fault == 'ValueError: three is too many'
    assert {task: one.result for task, one in ended.items()} == {n: n for n in (0, 1, 2, 4)}


@pytest.mark.slow
def test_what_a_worker_was_at_when_it_died_is_done_by_another(tmp_path) -> None:
    with dask_processes(tmp_path, 3) as running:
        tasks = [(n, str(tmp_path / 'fallen')) for n in range(9)]
        ended = list(DaskCluster(running.address).run(fall_once, tasks))
        assert sorted(one.result for one in ended) == list(range(9))
        assert sum(worker.poll() is not None for worker in running.workers) == 1


def test_nobody_there_is_told() -> None:
    with pytest.raises(InputError, match=r'no Dask scheduler answers at .nowhere.'):
        list(DaskCluster('nowhere', patience=0.5).run(number, [1]))
    with pytest.raises(InputError, match='no Dask scheduler answers'):
        list(DaskCluster('tcp://127.0.0.1:9', patience=0.5).run(number, [1]))
