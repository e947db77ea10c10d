# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The set with bodies of several laws, pairs of forms, and further causes outside the library."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from support.blind_labels import check_label, labelled
import yaml

from benchmarks.blind.amplitudes import OUTSIDE, OUTSIDE_CLASS
from benchmarks.blind.cases import Case, list_form_cases
from benchmarks.blind.faults import Faults
from benchmarks.blind.forms import BY_KEY, FORMS, PAIRS
from benchmarks.blind.labels import told
from benchmarks.blind.outside_forms import FURTHER_OUTSIDE
from benchmarks.blind.rubber import LAWS
from benchmarks.blind.scene_file import extra_text
from benchmarks.blind.sensor import DRAWN
from benchmarks.blind.setups import draw_setup


@pytest.fixture(scope='module')
def cases() -> list[Case]:
    return list_form_cases('sixth', 'salt')


@pytest.mark.parametrize(('one', 'other'), [('law', 'sensor'), ('law', 'family')])
def test_clean_worlds_go_through_laws_sensors_and_shapes_together(
    cases: list[Case], one: str, other: str
) -> None:
    clean = [case for case in cases if case.kind == 'clean']
    whole = Counter((case.law, case.sensor, case.family) for case in clean)
    assert len(whole) == len(LAWS) * len(DRAWN) * 4
    assert set(whole.values()) == {5}
    seen = {(getattr(case, one), getattr(case, other)) for case in clean[:60]}
    assert len(seen) == len(LAWS) * len({getattr(case, other) for case in clean})


def test_faulty_worlds_are_of_all_laws_sensors_and_shapes(cases: list[Case]) -> None:
    faulty = [case for case in cases if case.kind != 'clean']
    for name, most in (('law', 14), ('sensor', 20), ('family', 18)):
        counts = Counter(getattr(case, name) for case in faulty)
        assert len(counts) == len({getattr(case, name) for case in cases})
        assert max(counts.values()) <= most
    by_form: dict[str, list[Case]] = {}
    for case in faulty:
        by_form.setdefault(case.effects[0][0], []).append(case)
    twice = [pair for pair in by_form.values() if {c.kind for c in pair} == {'outside'}]
    assert len(twice) == 6
    assert all(one.sensor != other.sensor and one.law != other.law for one, other in twice)


def test_pairs_are_of_different_effects_and_all_forms_are_known() -> None:
    assert all(BY_KEY[one].truth != BY_KEY[other].truth for one, other in PAIRS)
    assert len({frozenset(pair) for pair in PAIRS}) == 12
    assert len(FORMS['sixth']) == 12


def test_outside_causes_are_new_and_have_a_class() -> None:
    assert not set(FURTHER_OUTSIDE) & set(OUTSIDE)
    classes = {name: OUTSIDE_CLASS[name] for name in FURTHER_OUTSIDE}
    assert set(classes.values()) == {'load', 'shape', 'material', 'sensor'}


def test_labels_tell_law_fixture_both_effects_and_class(cases: list[Case]) -> None:
    shifted = 0
    for case, setup, _, label in labelled(cases):
        check_label(case, label)
        length = np.linalg.norm(label['fixture_shift_mm'])
        assert length == 0.0 or 0.8 < length < 1.2
        shifted += length > 0.0
        box = yaml.safe_load(extra_text(setup, None))['fixture']['box']
        apart = [box[axis][0] - low for axis, low in zip('xyz', setup.fixture[0], strict=True)]
        assert np.allclose(1e3 * np.array(apart), label['fixture_shift_mm'], atol=1e-5)
    assert 0.4 < shifted / len(cases) < 0.6


@pytest.mark.parametrize('set_name', ['development', 'sealed', 'anew', 'fifth'])
def test_labels_of_earlier_sets_know_nothing_of_later_faults(set_name: str) -> None:
    names = set(told(Faults(), set_name, is_moving=False))
    assert not names & {'magnet', 'wiggle', 'camera_drifts', 'clamp_scatter', 'drag_form'}
    assert ('aspect' in names) == (set_name in ('anew', 'fifth'))
    assert {'drag_form', 'aspect'} <= set(told(Faults(), set_name, is_moving=True))
    assert told(Faults(wiggle=2.0), 'sixth', is_moving=False)['wiggle'] == 2.0


@pytest.mark.parametrize('name', sorted(FURTHER_OUTSIDE))
def test_a_cause_is_larger_in_a_larger_size(name: str) -> None:
    setup = draw_setup('beam', is_sealed=False, poses=4, random=np.random.default_rng(4))
    sizes = []
    for size in range(3):
        random = np.random.default_rng(8)
        sizes.append(abs(FURTHER_OUTSIDE[name](size, setup, random).changes[name]))
    assert sizes[0] < sizes[1] < sizes[2]
    stiffer = replace(setup, youngs_modulus=2.0 * setup.youngs_modulus)
    again = FURTHER_OUTSIDE[name](1, stiffer, np.random.default_rng(8)).changes[name]
    expected = 2.0 if name in ('magnet', 'tether') else 1.0
    assert abs(again) == pytest.approx(expected * sizes[1], rel=1e-3)
