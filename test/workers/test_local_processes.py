# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Processes of joblib: what falls is done again, what always falls is told."""

import os
import signal
import subprocess
import sys

from diffcal_ros.workers.local_processes import LocalProcesses
import pytest
from support.processes import children_of, wait_until_gone
from support.small_tasks import always_fall, fail_at_three, fall_once, number


def test_tasks_are_done_elsewhere() -> None:
    ended = list(LocalProcesses(2, 1).run(number, range(6)))
    assert sorted(one.result[0] for one in ended) == list(range(6))
    assert {one.result[1] for one in ended}.isdisjoint({os.getpid()})
    assert not any(one.fault for one in ended)


def test_a_single_process_is_another_one_too() -> None:
    (ended,) = LocalProcesses(1, 1).run(number, [7])
    assert ended.result[1] != os.getpid()


def test_a_task_that_fails_does_not_end_the_others() -> None:
    ended = {one.task: one for one in LocalProcesses(2, 1).run(fail_at_three, range(5))}
    assert ended.pop(3).fault == 'ValueError: three is too many'
    assert {task: one.result for task, one in ended.items()} == {n: n for n in (0, 1, 2, 4)}


def test_what_a_process_was_at_when_it_died_is_done_again(tmp_path) -> None:
    tasks = [(n, str(tmp_path / 'fallen')) for n in range(5)]
    ended = list(LocalProcesses(2, 1).run(fall_once, tasks))
    assert sorted(one.result for one in ended) == list(range(5))
    assert (tmp_path / 'fallen').exists()


def test_a_task_that_always_fells_its_process_is_told() -> None:
    ended = {one.task: one for one in LocalProcesses(2, 1).run(always_fall, range(5))}
    assert ended.pop(2).fault == 'its process died 3 times (is there memory enough?)'
    assert {task: one.result for task, one in ended.items()} == {n: n for n in (0, 1, 3, 4)}


_FIRST = """
import sys, time
from diffcal_ros.workers.local_processes import LocalProcesses
print('begun', flush=True)
for ended in LocalProcesses(2, 1).run(time.sleep, [0.0, 60.0, 60.0]):
    print('one', flush=True)
"""


@pytest.mark.skipif(sys.platform != 'linux', reason='looks into /proc')
@pytest.mark.parametrize('ending', [signal.SIGKILL, signal.SIGTERM])
def test_no_process_outlives_the_first(ending) -> None:
    environment = {**os.environ, 'PYTHONPATH': os.getcwd()}
    with subprocess.Popen(
        [sys.executable, '-c', _FIRST], stdout=subprocess.PIPE, text=True, env=environment
    ) as first:
        assert [first.stdout.readline() for _ in range(2)] == ['begun\n', 'one\n']
        started = children_of(first.pid)
        assert len(started) >= 2
        first.send_signal(ending)
    wait_until_gone(started)
