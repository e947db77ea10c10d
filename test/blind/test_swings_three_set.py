# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The set of motions `swings_three`: its cases, and those of the sets before as they were."""

from collections import Counter
import hashlib

import pytest
from support.blind_swings import (
    check_contents,
    check_crossed,
    check_drawn,
    check_salted,
    check_wants_motions,
)

from benchmarks.blind.amplitudes import LIBRARY, MOTION
from benchmarks.blind.swing_set import list_swing_set_cases, SWING_SETS

CASES = list_swing_set_cases('swings_three', 'salt')


def test_half_of_its_forms_show_over_time_alone_and_half_at_rest_as_well() -> None:
    check_contents('swings_three', CASES, {'clean': 16, 'form': 16, 'outside': 4})
    truths = Counter(form.truth for form in SWING_SETS['swings_three'].forms)
    assert sum(truths[name] for name in MOTION) == 4
    assert sum(truths[name] for name in LIBRARY) == 4
    assert set(MOTION) <= set(truths)
    assert len(truths) == 7


def test_laws_sensors_and_shapes_are_crossed() -> None:
    check_crossed(CASES)
    assert sum(case.is_held for case in CASES if case.kind == 'clean') == 5


def test_every_case_can_be_drawn_and_its_label_tells_what_it_is() -> None:
    check_drawn(CASES)


def test_what_goes_on_for_seconds_is_held_and_all_other_effects_swing() -> None:
    slow = ('creep/', 'added_mass/', 'camera_offset/')
    for case in CASES:
        is_slow = any(name.startswith(slow) for name, _ in case.effects)
        assert case.kind == 'clean' or case.is_held == is_slow


def test_the_salt_decides_the_order_and_the_draws() -> None:
    check_salted('swings_three', 'rippled')


@pytest.mark.parametrize(
    ('set_name', 'expected'),
    [
        ('swings', 'e808c1afc3f1f307f9963a1c25ea3ec9413276cd6cbec7fc55d13847fa4f5ae7'),
        ('swings_two', '852c1e0ebd2e8d4e6a654e81d0630afc446779138b6f3eb49d5474fdadd82e5a'),
    ],
)
def test_cases_of_sets_before_are_what_they_were(set_name: str, expected: str) -> None:
    listed = list_swing_set_cases(set_name, 'salt')
    lines = [f'{case.key} {case.law} {case.sensor} {case.is_held}' for case in listed]
    assert hashlib.sha256('\n'.join(lines).encode()).hexdigest() == expected


def test_the_program_wants_motions_of_this_set(capsys: pytest.CaptureFixture[str]) -> None:
    check_wants_motions('swings_three', capsys)
