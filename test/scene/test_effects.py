# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The library of effects as data: what would tell them apart."""

from diffcal_ros.effects.registry import EFFECTS, what_settles
import pytest

_ROLLED = 'rig rolled by 90 degrees'


@pytest.mark.parametrize('names', [('clamp_offset', 'camera_offset'), ('gravity_tilt',)])
def test_a_recording_that_settles_is_said_once(names) -> None:
    assert what_settles(names).count(_ROLLED) == 1
    assert what_settles(reversed(names)).count(_ROLLED) == 1


def test_what_settles_one_of_several_is_not_lost() -> None:
    words = what_settles(('clamp_offset', 'camera_offset', 'gravity_tilt'))
    assert 'fixture' in words
    assert 'spirit level' in words


@pytest.mark.parametrize('effect', EFFECTS.values(), ids=EFFECTS)
def test_every_effect_has_twins_in_the_library_and_a_way_out(effect) -> None:
    assert effect.twins
    assert set(effect.twins) < set(EFFECTS) - {effect.identifier}
    assert all(way and not way.endswith('.') for way in effect.settles)
