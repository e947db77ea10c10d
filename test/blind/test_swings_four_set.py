# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The set of motions `swings_four`: its cases, its labels, and the sets before as they were."""

from collections import Counter
import hashlib
import json

import numpy as np
import pytest
from support.blind_swings import (
    check_contents,
    check_crossed,
    check_drawn,
    check_salted,
    check_wants_motions,
)

from benchmarks.blind.amplitudes import LIBRARY, MOTION
from benchmarks.blind.cases import Case
from benchmarks.blind.generator import draw_case, draw_timing
from benchmarks.blind.labels import label_of
from benchmarks.blind.swing_set import list_swing_set_cases, SWING_SETS

CASES = list_swing_set_cases('swings_four', 'salt')
OTHERS = ('swings', 'swings_two', 'swings_three')


def _label(case: Case) -> dict:
    setup, effects, faults = draw_case(case)
    return label_of(case, setup, effects, faults, np.zeros(3), draw_timing(case, effects))


def test_each_of_its_forms_is_of_an_effect_of_its_own() -> None:
    check_contents('swings_four', CASES, {'clean': 16, 'form': 16, 'outside': 4})
    truths = Counter(form.truth for form in SWING_SETS['swings_four'].forms)
    assert set(MOTION) <= set(truths)
    assert set(truths) <= {*MOTION, *LIBRARY}
    assert len(truths) == 8


def test_laws_sensors_and_shapes_are_crossed() -> None:
    check_crossed(CASES)
    assert sum(case.is_held for case in CASES if case.kind == 'clean') == 5


def test_every_case_can_be_drawn_and_its_label_tells_what_it_is() -> None:
    check_drawn(CASES)


def test_what_goes_on_for_seconds_is_held_and_all_other_effects_swing() -> None:
    for case in CASES:
        is_slow = any(name.startswith(('creep/', 'rest_curvature/')) for name, _ in case.effects)
        assert case.kind == 'clean' or case.is_held == is_slow


def test_the_salt_decides_the_order_and_the_draws() -> None:
    check_salted('swings_four', 'remanent')


def test_its_labels_alone_tell_how_stiff_a_body_is_along_its_length() -> None:
    shares = {}
    for case in CASES:
        parameters = _label(case)['parameters']
        along = parameters['youngs_modulus_along'] / parameters['youngs_modulus'] - 1.0
        shares.setdefault(case.law, []).append(along)
    fibres = shares.pop('fibres')
    assert 0.0 < min(fibres) < 0.02
    assert 0.03 < max(fibres) < 0.2
    assert max(abs(each) for some in shares.values() for each in some) < 1e-7
    for name in OTHERS:
        some = list_swing_set_cases(name, 'salt')
        assert not any('along' in str(_label(case)['parameters']) for case in some)


# Of the cases of a set and of all that its labels tell, salted alike.
BEFORE = {
    'swings': (
        'e808c1afc3f1f307f9963a1c25ea3ec9413276cd6cbec7fc55d13847fa4f5ae7',
        '9b16bffcccaa9faa5fd4e929e065924a0bbb6293b8867ab75a18e7d8db5785c6',
    ),
    'swings_two': (
        '852c1e0ebd2e8d4e6a654e81d0630afc446779138b6f3eb49d5474fdadd82e5a',
        'a3ff554e8afc0eeac371a9b5a1c0a364bd9acbe1ae6faab968029c7be770fc5f',
    ),
    'swings_three': (
        '7fe93ba4d7634c3e731191290d4556ae85d657abd7c198a10196f56b503561e5',
        'ed83c7dfbaf0761669aa08f10b4da23928f9435264edd4c478e1ffa90de656f1',
    ),
}


@pytest.mark.parametrize('set_name', OTHERS)
def test_cases_and_labels_of_sets_before_are_what_they_were(set_name: str) -> None:
    listed = list_swing_set_cases(set_name, 'salt')
    lines = [f'{case.key} {case.law} {case.sensor} {case.is_held}' for case in listed]
    told = [json.dumps(_label(case), indent=2, sort_keys=True) for case in listed]
    found = tuple(hashlib.sha256('\n'.join(each).encode()).hexdigest() for each in (lines, told))
    assert found == BEFORE[set_name]


def test_the_program_wants_motions_of_this_set(capsys: pytest.CaptureFixture[str]) -> None:
    check_wants_motions('swings_four', capsys)
