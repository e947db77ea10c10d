# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Replay into a list: order, steps, loops, waiting, and ends."""

from itertools import pairwise
import threading

from diffcal_ros.errors import InputError
from diffcal_ros.live.health import Level
from diffcal_ros.live.replay.player import Player, ReplaySettings
from diffcal_ros.live.replay.replay_messages import Role
import pytest

_LIMIT = 60.0  # However slow a machine is [s].


class Recorder:
    """An outlet that keeps what comes and lets a test wait for it."""

    def __init__(self, listeners: int = 1) -> None:
        self.listeners = listeners
        self.messages, self.ticks, self.recordings = [], [], []
        self._came = threading.Condition()

    def opened(self, recording) -> None:
        self.recordings.append(recording)

    def publish(self, message) -> None:
        with self._came:
            self.messages.append(message)
            self._came.notify()

    def tick(self, time_ns) -> None:
        self.ticks.append(time_ns)

    def listener_count(self) -> int:
        return self.listeners

    def depth_count(self) -> int:
        return sum(message.role is Role.DEPTH for message in self.messages)

    def wait_for(self, is_true) -> None:
        with self._came:
            assert self._came.wait_for(is_true, _LIMIT)


@pytest.fixture
def bag(recorded_beam):
    (path,) = recorded_beam.bags.values()
    return path


@pytest.fixture
def play(bag):
    players = []

    def start(recorder, **settings):
        given = {'path': bag, 'rate': 20.0, 'patience': 0.0, **settings}
        players.append(Player(ReplaySettings(**given), recorder))
        return players[-1]

    yield start
    for player in players:
        player.close()


def _wait_for_level(player, level, words) -> None:
    ended = threading.Event()
    for _ in range(int(_LIMIT / 0.02)):
        health = player.health()
        if health.level is level and words in health.message:
            return
        ended.wait(0.02)
    pytest.fail(f'{words!r} did not come, but {player.health().message!r}')


def test_everything_comes_in_order_and_then_it_ends(play):
    recorder = Recorder()
    player = play(recorder)
    _wait_for_level(player, Level.OK, 'was replayed to its end')
    times = [message.time_ns for message in recorder.messages]
    assert times == sorted(times)
    counts = {role: sum(message.role is role for message in recorder.messages) for role in Role}
    assert counts == {
        Role.DEPTH: 4,
        Role.DEPTH_INFO: 4,
        Role.COLOR: 2,
        Role.COLOR_INFO: 2,
        Role.FRAMES: 0,
    }
    assert set(times) <= set(recorder.ticks)
    assert recorder.recordings[0].depth_count == 4
    with pytest.raises(InputError, match='has ended'):
        player.step()


def test_a_step_sends_up_to_the_next_depth_image(play):
    recorder = Recorder()
    player = play(recorder, is_paused=True)
    _wait_for_level(player, Level.WARN, 'paused')
    assert not recorder.messages
    for count in (1, 2):
        player.step()
        recorder.wait_for(lambda count=count: recorder.depth_count() == count)
        assert recorder.messages[-1].role is Role.DEPTH
    player.change(rate=20.0, is_looping=False, is_paused=False)
    _wait_for_level(player, Level.OK, 'was replayed to its end')
    assert recorder.depth_count() == 4


def test_a_running_replay_cannot_be_stepped_through(play):
    player = play(Recorder(), is_looping=True, rate=1.0)
    with pytest.raises(InputError, match="set the parameter 'paused'"):
        player.step()


def test_a_loop_goes_on_with_later_stamps(play):
    recorder = Recorder()
    play(recorder, is_looping=True)
    recorder.wait_for(lambda: recorder.depth_count() >= 9)
    times = [m.time_ns for m in list(recorder.messages) if m.role is Role.DEPTH]
    assert all(later > earlier for earlier, later in pairwise(times))


@pytest.mark.slow
def test_it_waits_for_a_listener(play):
    recorder = Recorder(listeners=0)
    player = play(recorder, patience=600.0)
    _wait_for_level(player, Level.OK, 'waiting for subscribers')
    assert not recorder.messages
    recorder.listeners = 1
    recorder.wait_for(lambda: recorder.messages)


def test_what_cannot_be_opened_is_told(play, tmp_path):
    player = play(Recorder(), path=tmp_path / 'none')
    _wait_for_level(player, Level.ERROR, 'there is no recording')
