# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The set of motions `swings_five`: its cases and its labels."""

from collections import Counter

import numpy as np
import pytest
from support.blind_swings import (
    check_contents,
    check_crossed,
    check_drawn,
    check_salted,
    check_wants_motions,
)

from benchmarks.blind.amplitudes import LIBRARY, MOTION, OUTSIDE_CLASS
from benchmarks.blind.generator import draw_case, draw_timing
from benchmarks.blind.labels import label_of
from benchmarks.blind.swing_set import list_swing_set_cases, SWING_SETS

CASES = list_swing_set_cases('swings_five', 'salt')


def test_each_of_its_forms_is_of_an_effect_of_its_own() -> None:
    check_contents('swings_five', CASES, {'clean': 16, 'form': 16, 'outside': 4})
    assert len(CASES) == 36
    truths = Counter(form.truth for form in SWING_SETS['swings_five'].forms)
    assert set(MOTION) <= set(truths) <= {*MOTION, *LIBRARY}
    assert len(truths) == 8
    assert len({OUTSIDE_CLASS[name] for name in SWING_SETS['swings_five'].outside}) == 2


def test_laws_sensors_and_shapes_are_crossed() -> None:
    check_crossed(CASES)
    assert sum(case.is_held for case in CASES if case.kind == 'clean') == 5


def test_every_case_can_be_drawn_and_its_label_tells_what_it_is() -> None:
    check_drawn(CASES)


def test_creep_is_held_and_all_other_effects_swing() -> None:
    for case in CASES:
        creeps = any(name.startswith('creep/') for name, _ in case.effects)
        assert case.kind == 'clean' or case.is_held == creeps


def test_the_salt_decides_the_order_and_the_draws() -> None:
    check_salted('swings_five', 'rubbed')


def test_labels_tell_all_faults_and_how_stiff_a_body_is_along_its_length() -> None:
    for case in CASES:
        setup, effects, faults = draw_case(case)
        label = label_of(case, setup, effects, faults, np.zeros(3), draw_timing(case, effects))
        assert 'youngs_modulus_along' in label['parameters']
        changes = [each for effect in effects for each in effect.changes.items()]
        assert all(label['faults'][name] == value for name, value in changes)
        assert label['outside_class'] == OUTSIDE_CLASS.get(case.effects and case.effects[0][0])


def test_the_program_wants_motions_of_this_set(capsys: pytest.CaptureFixture[str]) -> None:
    check_wants_motions('swings_five', capsys)
