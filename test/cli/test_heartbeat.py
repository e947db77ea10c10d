# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Long phases give a sign of life, under their own names, until they end."""

from threading import enumerate as threads
from threading import Event

from diffcal_ros.cli.heartbeat import Heartbeat
import pytest

PATIENCE = 30.0  # Of a test that would otherwise hang [s].


class Listener:
    """Collects lines, and tells when one with some words has come."""

    def __init__(self):
        self.lines = []
        self.words = ''
        self.has_come = Event()

    def say(self, text):
        self.lines.append(text)
        if self.words and self.words in text:
            self.has_come.set()

    def waits_for(self, words):
        self.words = words
        self.has_come.clear()
        return self.has_come.wait(PATIENCE)


def is_beating():
    return any(thread.name == 'diffcal-heartbeat' for thread in threads())


def test_a_silent_phase_is_told_again_and_again():
    listener = Listener()
    with Heartbeat('reading', silence=0.01, say=listener.say) as heartbeat:
        assert is_beating()
        assert listener.waits_for('reading: 0 s so far')
        heartbeat.report('simulating swing')
        assert listener.waits_for('simulating swing: 0 s so far')
    told = len(listener.lines)
    assert not is_beating()
    assert listener.lines.count('simulating swing') == 1
    assert len(listener.lines) == told


def test_a_short_phase_says_nothing_more():
    listener = Listener()
    with Heartbeat('reading', silence=PATIENCE, say=listener.say) as heartbeat:
        heartbeat.report('simulating')
    assert listener.lines == ['simulating']


def test_an_error_ends_it():
    listener = Listener()
    heartbeat = Heartbeat('reading', silence=PATIENCE, say=listener.say)
    with pytest.raises(ValueError, match='no mesh'), heartbeat:
        raise ValueError('no mesh')
    assert not is_beating()
