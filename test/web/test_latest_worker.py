# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Of each kind of task the latest is done, in a thread of its own."""

import threading

from diffcal_ros.web.latest_worker import LatestWorker
import pytest

LONG = 30.0  # Nothing takes that long [s].


@pytest.fixture
def errors():
    return []


@pytest.fixture
def worker(errors):
    own = LatestWorker(errors.append)
    yield own
    own.end()


def test_a_newer_task_replaces_one_that_waits(worker):
    begun, go, done = threading.Event(), threading.Event(), []

    def first():
        begun.set()
        go.wait(LONG)
        done.append(worker.is_outdated('try'))

    worker.ask('try', first)
    assert begun.wait(LONG)
    worker.ask('try', lambda: done.append('old'))
    worker.ask('save', lambda: done.append('saved'))
    worker.ask('try', lambda: done.append('new'))
    go.set()
    assert worker.wait(LONG)
    assert done == [True, 'new', 'saved']


def test_a_task_that_fails_is_told_and_the_next_one_is_done(worker, errors):
    done = []

    def fail():
        raise ValueError('no')

    worker.ask('try', fail)
    worker.ask('save', lambda: done.append('saved'))
    assert worker.wait(LONG)
    assert [str(error) for error in errors] == ['no']
    assert done == ['saved']


def test_nothing_is_begun_after_the_end(errors):
    worker, begun, go, done = LatestWorker(errors.append), threading.Event(), threading.Event(), []

    def first():
        begun.set()
        go.wait(LONG)
        done.append(worker.is_outdated('try'))

    worker.ask('try', first)
    assert begun.wait(LONG)
    worker.ask('save', lambda: done.append('saved'))
    worker.end()
    go.set()
    assert worker.wait(LONG)
    assert done == [True]
