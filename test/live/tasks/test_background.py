# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The background thread: results come back, failures too, and nothing of what was stopped."""

import threading

from diffcal_ros.live.tasks.background import Background, TaskFailed
import pytest

_LIMIT = 60.0  # However slow a machine is [s].


@pytest.fixture
def woken():
    return threading.Event()


@pytest.fixture
def background(woken):
    running = Background(woken.set)
    yield running
    assert running.close()


def test_what_is_posted_comes_back_in_order(background):
    done = threading.Event()
    background.submit(lambda post, stop: [post(1), post(2)])
    background.submit(lambda post, stop: [post(3), done.set()])
    assert done.wait(_LIMIT)
    assert background.events() == [1, 2, 3]
    assert background.events() == []


def test_a_failure_comes_back_and_the_thread_lives_on(background):
    done = threading.Event()
    background.submit(lambda post, stop: 1 / 0)
    background.submit(lambda post, stop: done.set())
    assert done.wait(_LIMIT)
    (failed,) = background.events()
    assert isinstance(failed, TaskFailed)
    assert isinstance(failed.error, ZeroDivisionError)


def test_of_a_task_that_was_stopped_nothing_comes_back(background, woken):
    seen = threading.Event()

    def task(post, stop):
        post('before')
        seen.set()
        stop.wait(_LIMIT)
        post('after')

    ticket = background.submit(task)
    assert seen.wait(_LIMIT)
    assert woken.is_set()
    ticket.set()
    done = threading.Event()
    background.submit(lambda post, stop: [post('next'), done.set()])
    assert done.wait(_LIMIT)
    assert background.events() == ['next']


def test_closing_stops_what_runs_and_drops_what_waits(woken):
    background = Background(woken.set)
    begun, ran = threading.Event(), threading.Event()
    background.submit(lambda post, stop: [begun.set(), stop.wait(_LIMIT)])
    background.submit(lambda post, stop: ran.set())
    assert begun.wait(_LIMIT)
    assert background.close(_LIMIT)
    assert not ran.is_set()


def test_closing_does_not_wait_for_what_cannot_be_stopped(woken):
    background = Background(woken.set)
    free, begun = threading.Event(), threading.Event()
    background.submit(lambda post, stop: [begun.set(), free.wait(_LIMIT)])
    assert begun.wait(_LIMIT)
    assert not background.close(patience=0.05)
    free.set()
    assert background.close(_LIMIT)
