# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The set of motions `swings`: its cases, labels, worlds and stamps."""

from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rosbags.highlevel import AnyReader
from support.blind_labels import check_label

from benchmarks.blind.amplitudes import MOTION, OUTSIDE_CLASS
from benchmarks.blind.bag import write_bag
from benchmarks.blind.faults import Faults
from benchmarks.blind.forms import BY_KEY
from benchmarks.blind.generator import draw_case, draw_timing, main
from benchmarks.blind.labels import label_of
from benchmarks.blind.motion_forms import MOTION_FORMS
from benchmarks.blind.outcomes import CLASS
from benchmarks.blind.rubber import LAWS
from benchmarks.blind.scene_file import scene_text
from benchmarks.blind.sensor import DRAWN
from benchmarks.blind.setups import Setup
from benchmarks.blind.stamping import moments, stamps
from benchmarks.blind.swing_set import (
    list_swing_set_cases,
    SWING_SET_EFFECTS,
    SWING_SET_FAMILIES,
    SWING_SET_FORMS,
    SWING_SET_OUTSIDE,
)
from benchmarks.blind.timing import draw_swing, jittery

CASES = list_swing_set_cases('salt')


def test_the_set_has_clean_motions_forms_and_causes_outside_the_library() -> None:
    assert Counter(case.kind for case in CASES) == {'clean': 24, 'form': 20, 'outside': 4}
    assert len({case.id for case in CASES}) == len(CASES)
    assert all(case.is_moving and case.poses == 1 for case in CASES)
    sizes = Counter(case.effects[0] for case in CASES if case.effects)
    assert set(sizes) == {(name, size) for name in SWING_SET_EFFECTS for size in (1, 2)}
    assert set(sizes.values()) == {1}
    truths = Counter(form.truth for form in SWING_SET_FORMS)
    assert sum(truths[name] for name in MOTION) == 8
    assert min(truths[name] for name in MOTION) >= 2
    assert len(truths) == 5


def test_its_forms_are_no_other_sets_and_all_have_a_class() -> None:
    others = {*BY_KEY, *(form.key for form in MOTION_FORMS)}
    assert others.isdisjoint(form.key for form in SWING_SET_FORMS)
    assert {form.truth for form in SWING_SET_FORMS} <= set(CLASS)
    assert set(SWING_SET_OUTSIDE) <= set(OUTSIDE_CLASS)


def test_laws_sensors_and_shapes_are_crossed() -> None:
    clean = [case for case in CASES if case.kind == 'clean']
    for key, names in (('law', LAWS), ('sensor', DRAWN), ('family', SWING_SET_FAMILIES)):
        for cases in (CASES, clean):
            counts = Counter(getattr(case, key) for case in cases)
            assert set(counts) == set(names)
            assert max(counts.values()) < 2.2 * min(counts.values())
    assert len({(case.law, case.family) for case in clean}) > 20
    assert len({(case.law, case.sensor) for case in clean}) == 15
    assert len({(case.sensor, case.is_held) for case in clean}) == 6
    assert sum(case.is_held for case in clean) == 8


def test_the_salt_decides_the_order_and_the_draws() -> None:
    again, other = list_swing_set_cases('salt'), list_swing_set_cases('pepper')
    assert again == CASES
    assert [case.effects for case in CASES] != [case.effects for case in other]
    one, two = (
        next(case for case in cases if case.effects == (('shaken', 2),))
        for cases in (CASES, other)
    )
    assert draw_case(one)[2].shaken != draw_case(two)[2].shaken


def test_every_case_can_be_drawn_and_its_label_tells_what_it_is() -> None:
    for case in CASES:
        setup, effects, faults = draw_case(case)
        timing = draw_timing(case, effects)
        label = label_of(case, setup, effects, faults, np.zeros(3), timing)
        check_label(case, label)
        assert timing.is_slow == case.is_held
        assert ('damping' in label['parameters']) != timing.is_slow
        assert label['parameters'].get('damping', timing.damping) == timing.damping
        assert (faults == Faults()) == (case.kind == 'clean')
        assert label['sensor'] == case.sensor
        assert (
            0.0
            < np.abs(setup.observations[0].stated - setup.observations[0].world_from_object)[
                :3, 3
            ].max()
            < 0.002
        )
        text = scene_text(setup, timing)
        assert 'ledge' in text
        assert ('quasi_static' in text) == timing.is_slow
        assert len(stamps(timing, faults)) == len(moments(timing, faults))


def test_what_creeps_is_held_and_all_other_effects_swing() -> None:
    for case in CASES:
        creeps = str(case.effects).startswith("(('creep/")
        assert case.kind == 'clean' or case.is_held == creeps


def test_stamps_of_a_clean_motion_are_off_by_some_tenths_of_a_millisecond() -> None:
    plain = draw_swing(np.random.default_rng(1))
    off = []
    for seed in range(20):
        timing = jittery(plain, np.random.default_rng(seed))
        assert replace(timing, jitter=()) == plain
        when = 1e-9 * np.array(stamps(timing, Faults()))
        assert when[0] == 0.0
        assert (np.diff(when) > 0.0).all()
        # The frames themselves are even.
        np.testing.assert_allclose(np.diff(moments(timing, Faults())), 1.0 / 30.0)
        off.append(when - np.array(moments(timing, Faults())) - timing.release)
    assert np.abs(off).max() < 5.1e-4
    assert 1.5e-4 < np.std(off) < 2.5e-4


def test_stamps_of_older_sets_are_even_to_the_nanosecond() -> None:
    timing = draw_swing(np.random.default_rng(1))
    assert stamps(timing, Faults(stamps_late=5.0)) == [k * 33_333_333 for k in range(17)]


def test_a_bag_has_the_stamps_that_it_is_given(setup: Setup, tmp_path: Path) -> None:
    frames = [np.full((setup.camera.height, setup.camera.width), 0.3, np.float32)] * 3
    write_bag(tmp_path / 'bag', setup.camera, frames, [0, 33_400_000, 99_999_998])
    with AnyReader([tmp_path / 'bag']) as reader:
        assert reader.duration == 99_999_998 + 1
        found = [
            reader.deserialize(data, link.msgtype).header.stamp
            for link, _, data in reader.messages()
            if link.msgtype.endswith('Image')
        ]
    when = np.array([stamp.sec * 10**9 + stamp.nanosec for stamp in found])
    assert np.array_equal(when - when[0], [0, 33_400_000, 99_999_998])


def test_the_program_wants_motions_of_this_set(capsys: pytest.CaptureFixture[str]) -> None:
    for options in (['--forms'], ['--motion']):
        with pytest.raises(SystemExit):
            main(['--set', 'swings', '--out', 'nowhere', *options])
        assert 'swings' in capsys.readouterr().err
