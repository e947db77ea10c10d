# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Replay of a recording at its own pace, in a thread of its own."""

from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path
import threading
import time
from typing import Protocol

from diffcal_ros.errors import InputError
from diffcal_ros.live.health import Health, Level
from diffcal_ros.live.replay.replay_messages import replay_messages, ReplayMessage, Role
from diffcal_ros.plain_text import plain
from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.recording.recording import Recording

_SECOND = 1_000_000_000  # [ns]
_TICK = 0.025  # How often the clock goes on between messages [s].
# Nodes that run already are found within one period of DDS's announcements, 3 s, of each other.
_SETTLED = 3.2  # No new listener for so long: all are there [s].
_TOO_LATE = 0.2  # Behind by more, the schedule starts anew rather than hurry after [s].


@dataclass(frozen=True)
class ReplaySettings:
    """How a recording is replayed.

    Attributes:
        path: of the recording.
        rate: times its own pace.
        is_looping: start again at the end, with stamps that go on.
        is_paused: stand still, except for single steps.
        depth_topic: where it has several; empty chooses.
        allow_truncated: use what is left of a damaged recording.
        patience: how long to wait at most for subscribers before the first message [s].
    """

    path: Path
    rate: float = 1.0
    is_looping: bool = False
    is_paused: bool = False
    depth_topic: str = ''
    allow_truncated: bool = False
    patience: float = 10.0


class Outlet(Protocol):
    """Where a replay goes; called from its thread."""

    def opened(self, recording: Recording) -> None:
        """Take note of the cameras and transforms of a recording that was opened."""

    def publish(self, message: ReplayMessage) -> None:
        """Send a message."""

    def tick(self, time_ns: int) -> None:
        """Send the time of the recording [ns]."""

    def listener_count(self) -> int:
        """Return how many listen; 0 while nobody listens to depth."""


class Player:
    """Replays one recording; the settings may change while it runs."""

    def __init__(self, settings: ReplaySettings, outlet: Outlet) -> None:
        """Start; the recording is opened in the thread.

        Args:
            settings: how to replay.
            outlet: where to.
        """
        self._settings = settings
        self._outlet = outlet
        self._changed = threading.Condition()
        self._is_closed = False
        self._steps = 0
        self._health = Health(Level.OK, f'opening {settings.path}')
        self._sent: Counter[Role] = Counter()
        self._rounds = 0
        self._left_out, self._last_left_out = 0, ''
        self._notes: tuple[str, ...] = ()
        self._thread = threading.Thread(target=self._work, name='player', daemon=True)
        self._thread.start()

    @property
    def has_ended(self) -> bool:
        """Tell whether it was replayed to its end, or could not be."""
        return not self._thread.is_alive()

    def change(self, *, rate: float, is_looping: bool, is_paused: bool) -> None:
        """Go on at another pace."""
        with self._changed:
            self._settings = replace(
                self._settings, rate=rate, is_looping=is_looping, is_paused=is_paused
            )
            self._changed.notify()

    def step(self) -> None:
        """Send everything up to the next depth image.

        Raises:
            InputError: when the replay is not paused, or has ended.
        """
        with self._changed:
            if not self._thread.is_alive():
                raise InputError('there is nothing to step through: the replay has ended')
            if not self._settings.is_paused:
                raise InputError("the replay runs: set the parameter 'paused' to step through it")
            self._steps += 1
            self._changed.notify()

    def close(self) -> None:
        """End the replay."""
        with self._changed:
            self._is_closed = True
            self._changed.notify()
        self._thread.join(2.0)

    def health(self) -> Health:
        """Return how the replay goes."""
        with self._changed:
            values = {f'{role.value} sent': str(self._sent[role]) for role in Role}
            values['rounds'] = str(self._rounds)
            values['left out'] = str(self._left_out)
            values['notes'] = '; '.join(self._notes) or 'none'
            if self._left_out and self._health.level is Level.OK:
                told = f'{self._left_out} messages were left out, the last: {self._last_left_out}'
                return Health(Level.WARN, f'{self._health.message}; {told}', values)
            return replace(self._health, values=values)

    def _work(self) -> None:
        settings = self._settings
        try:
            recording = open_recording(
                settings.path,
                depth_topic=settings.depth_topic or None,
                allow_truncated=settings.allow_truncated,
            )
            self._outlet.opened(recording)
            self._notes = (*recording.notes, *recording.left_out)
            self._wait_for_listeners()
            self._play(recording)
        except InputError as error:
            self._say(Level.ERROR, str(error))

    def _wait_for_listeners(self) -> None:
        """Wait until somebody listens, and until no more come: a bag is not played twice."""
        self._say(Level.OK, 'waiting for subscribers')
        end = time.monotonic() + self._settings.patience
        count, since = 0, time.monotonic()
        while time.monotonic() < end:
            found = self._outlet.listener_count()
            if found != count:
                count, since = found, time.monotonic()
            if count and time.monotonic() - since >= _SETTLED:
                return
            with self._changed:
                if self._is_closed:
                    return
                self._changed.wait(_TICK)

    def _play(self, recording: Recording) -> None:
        schedule = _Schedule()
        for message in replay_messages(recording, self._next_round, self._leave_out):
            if not self._wait_until_due(message, schedule):
                return
            self._outlet.tick(message.time_ns)
            self._outlet.publish(message)
            with self._changed:
                self._sent[message.role] += 1
                if message.role is Role.DEPTH and self._steps:
                    self._steps -= 1
        self._say(
            Level.OK, f'{recording.path} was replayed to its end; set loop to replay it again'
        )

    def _leave_out(self, reason: str) -> None:
        with self._changed:
            self._left_out += 1
            self._last_left_out = plain(reason, 200)

    def _next_round(self) -> bool:
        with self._changed:
            self._rounds += 1
            return self._settings.is_looping

    def _wait_until_due(self, message: ReplayMessage, schedule: '_Schedule') -> bool:
        """Wait for a message's time; return False when the replay is to end."""
        while True:
            with self._changed:
                if self._is_closed:
                    return False
                settings = self._settings
                if settings.is_paused:
                    self._health = Health(Level.WARN, 'paused: call ~/step, or unset paused')
                    schedule.stop()
                    if self._steps:
                        return True
                    self._changed.wait(_TICK)
                    continue
                self._health = Health(Level.OK, f'replaying {settings.path}')
                left = schedule.time_left(message.time_ns, settings.rate)
                if left <= 0.0:
                    return True
                self._changed.wait(min(left, _TICK))
            if left > _TICK:
                self._outlet.tick(schedule.time_ns())

    def _say(self, level: Level, message: str) -> None:
        with self._changed:
            self._health = Health(level, message)


class _Schedule:
    """Relates the time of the recording to the steady clock."""

    def __init__(self) -> None:
        self._rate = 0.0
        self._origin_ns = 0
        self._begun = 0.0

    def stop(self) -> None:
        """Start anew with the next message."""
        self._rate = 0.0

    def time_left(self, time_ns: int, rate: float) -> float:
        """Return how long it is until a time of the recording [s]."""
        now = time.monotonic()
        if rate != self._rate:
            self._origin_ns = time_ns if self._rate == 0.0 else self.time_ns()
            self._begun, self._rate = now, rate
        left = self._begun + (time_ns - self._origin_ns) / (_SECOND * rate) - now
        if left < -_TOO_LATE:
            self._origin_ns, self._begun = time_ns, now
            return 0.0
        return left

    def time_ns(self) -> int:
        """Return the time of the recording now [ns]."""
        elapsed = time.monotonic() - self._begun
        return self._origin_ns + int(elapsed * self._rate * _SECOND)
