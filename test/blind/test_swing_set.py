# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The set of motions `swings`: its cases, labels, worlds and stamps."""

from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rosbags.highlevel import AnyReader
from support.blind_swings import (
    check_contents,
    check_crossed,
    check_drawn,
    check_salted,
    check_wants_motions,
)

from benchmarks.blind.amplitudes import MOTION
from benchmarks.blind.bag import write_bag
from benchmarks.blind.faults import Faults
from benchmarks.blind.setups import Setup
from benchmarks.blind.stamping import moments, stamps
from benchmarks.blind.swing_set import list_swing_set_cases, SWING_SETS
from benchmarks.blind.timing import draw_swing, jittery

CASES = list_swing_set_cases('swings', 'salt')


def test_the_set_has_clean_motions_forms_and_causes_outside_the_library() -> None:
    check_contents('swings', CASES, {'clean': 24, 'form': 20, 'outside': 4})
    truths = Counter(form.truth for form in SWING_SETS['swings'].forms)
    assert sum(truths[name] for name in MOTION) == 8
    assert min(truths[name] for name in MOTION) >= 2
    assert len(truths) == 5


def test_laws_sensors_and_shapes_are_crossed() -> None:
    check_crossed(CASES)
    clean = [case for case in CASES if case.kind == 'clean']
    assert len({(case.law, case.family) for case in clean}) > 20
    assert sum(case.is_held for case in clean) == 8


def test_the_salt_decides_the_order_and_the_draws() -> None:
    check_salted('swings', 'shaken')


def test_every_case_can_be_drawn_and_its_label_tells_what_it_is() -> None:
    check_drawn(CASES)


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
    check_wants_motions('swings', capsys)
