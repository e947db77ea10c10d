# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The sets with bodies of several laws, pairs of forms, and causes outside the library."""

from collections import Counter
from dataclasses import dataclass

import numpy as np
import pytest
from support.blind_digest import drawn_digest, Told
from support.blind_labels import check_label, labelled

from benchmarks.blind.amplitudes import Drawer, LIBRARY, OUTSIDE, OUTSIDE_CLASS
from benchmarks.blind.cases import Case, LAWS_SETS, list_form_cases
from benchmarks.blind.eighteenth_forms import EIGHTEENTH_FORMS, EIGHTEENTH_PAIRS
from benchmarks.blind.eighteenth_outside import EIGHTEENTH_OUTSIDE
from benchmarks.blind.eighth_forms import EIGHTH_FORMS, EIGHTH_PAIRS
from benchmarks.blind.eighth_outside import EIGHTH_OUTSIDE
from benchmarks.blind.eleventh_forms import ELEVENTH_FORMS, ELEVENTH_PAIRS
from benchmarks.blind.eleventh_outside import ELEVENTH_OUTSIDE
from benchmarks.blind.fifteenth_forms import FIFTEENTH_FORMS, FIFTEENTH_PAIRS
from benchmarks.blind.fifteenth_outside import FIFTEENTH_OUTSIDE
from benchmarks.blind.form import Form
from benchmarks.blind.forms import BY_KEY, FORMS
from benchmarks.blind.fourteenth_forms import FOURTEENTH_FORMS, FOURTEENTH_PAIRS
from benchmarks.blind.fourteenth_outside import FOURTEENTH_OUTSIDE
from benchmarks.blind.nineteenth_forms import NINETEENTH_FORMS, NINETEENTH_PAIRS
from benchmarks.blind.nineteenth_outside import NINETEENTH_OUTSIDE
from benchmarks.blind.ninth_forms import NINTH_FORMS, NINTH_PAIRS
from benchmarks.blind.ninth_outside import NINTH_OUTSIDE
from benchmarks.blind.rubber import LAWS
from benchmarks.blind.sensor import DRAWN
from benchmarks.blind.seventeenth_forms import SEVENTEENTH_FORMS, SEVENTEENTH_PAIRS
from benchmarks.blind.seventeenth_outside import SEVENTEENTH_OUTSIDE
from benchmarks.blind.seventh_forms import SEVENTH_FORMS, SEVENTH_PAIRS
from benchmarks.blind.seventh_outside import SEVENTH_OUTSIDE
from benchmarks.blind.sixteenth_forms import SIXTEENTH_FORMS, SIXTEENTH_PAIRS
from benchmarks.blind.sixteenth_outside import SIXTEENTH_OUTSIDE
from benchmarks.blind.tenth_forms import TENTH_FORMS, TENTH_PAIRS
from benchmarks.blind.tenth_outside import TENTH_OUTSIDE
from benchmarks.blind.thirteenth_forms import THIRTEENTH_FORMS, THIRTEENTH_PAIRS
from benchmarks.blind.thirteenth_outside import THIRTEENTH_OUTSIDE
from benchmarks.blind.thirtieth_forms import THIRTIETH_FORMS, THIRTIETH_PAIRS
from benchmarks.blind.thirtieth_outside import THIRTIETH_OUTSIDE
from benchmarks.blind.thirtyfirst_forms import THIRTYFIRST_FORMS, THIRTYFIRST_PAIRS
from benchmarks.blind.thirtyfirst_outside import THIRTYFIRST_OUTSIDE
from benchmarks.blind.thirtysecond_forms import THIRTYSECOND_FORMS, THIRTYSECOND_PAIRS
from benchmarks.blind.thirtysecond_outside import THIRTYSECOND_OUTSIDE
from benchmarks.blind.thirtythird_forms import THIRTYTHIRD_FORMS, THIRTYTHIRD_PAIRS
from benchmarks.blind.thirtythird_outside import THIRTYTHIRD_OUTSIDE
from benchmarks.blind.twelfth_forms import TWELFTH_FORMS, TWELFTH_PAIRS
from benchmarks.blind.twelfth_outside import TWELFTH_OUTSIDE
from benchmarks.blind.twentieth_forms import TWENTIETH_FORMS, TWENTIETH_PAIRS
from benchmarks.blind.twentieth_outside import TWENTIETH_OUTSIDE
from benchmarks.blind.twentyeighth_forms import TWENTYEIGHTH_FORMS, TWENTYEIGHTH_PAIRS
from benchmarks.blind.twentyeighth_outside import TWENTYEIGHTH_OUTSIDE
from benchmarks.blind.twentyfifth_forms import TWENTYFIFTH_FORMS, TWENTYFIFTH_PAIRS
from benchmarks.blind.twentyfifth_outside import TWENTYFIFTH_OUTSIDE
from benchmarks.blind.twentyfirst_forms import TWENTYFIRST_FORMS, TWENTYFIRST_PAIRS
from benchmarks.blind.twentyfirst_outside import TWENTYFIRST_OUTSIDE
from benchmarks.blind.twentyfourth_forms import TWENTYFOURTH_FORMS, TWENTYFOURTH_PAIRS
from benchmarks.blind.twentyfourth_outside import TWENTYFOURTH_OUTSIDE
from benchmarks.blind.twentyninth_forms import TWENTYNINTH_FORMS, TWENTYNINTH_PAIRS
from benchmarks.blind.twentyninth_outside import TWENTYNINTH_OUTSIDE
from benchmarks.blind.twentysecond_forms import TWENTYSECOND_FORMS, TWENTYSECOND_PAIRS
from benchmarks.blind.twentysecond_outside import TWENTYSECOND_OUTSIDE
from benchmarks.blind.twentyseventh_forms import TWENTYSEVENTH_FORMS, TWENTYSEVENTH_PAIRS
from benchmarks.blind.twentyseventh_outside import TWENTYSEVENTH_OUTSIDE
from benchmarks.blind.twentysixth_forms import TWENTYSIXTH_FORMS, TWENTYSIXTH_PAIRS
from benchmarks.blind.twentysixth_outside import TWENTYSIXTH_OUTSIDE
from benchmarks.blind.twentythird_forms import TWENTYTHIRD_FORMS, TWENTYTHIRD_PAIRS
from benchmarks.blind.twentythird_outside import TWENTYTHIRD_OUTSIDE

COUNTS = {
    'sixth': {'clean': 300, 'form': 24, 'pair': 12, 'outside': 12},
    'seventh': {'clean': 60, 'form': 20, 'pair': 8, 'outside': 8},
    'eighth': {'clean': 60, 'form': 20, 'pair': 8, 'outside': 8},
    'ninth': {'clean': 60, 'form': 20, 'pair': 8, 'outside': 8},
    'tenth': {'clean': 24, 'form': 16, 'pair': 4, 'outside': 4},
    'eleventh': {'clean': 60, 'form': 16, 'pair': 4, 'outside': 4},
    'twelfth': {'clean': 60, 'form': 16, 'pair': 4, 'outside': 4},
    'thirteenth': {'clean': 60, 'form': 16, 'pair': 4, 'outside': 4},
    'fourteenth': {'clean': 300, 'form': 16, 'pair': 4, 'outside': 4},
    'fifteenth': {'clean': 40, 'form': 20, 'pair': 4, 'outside': 4},
    'sixteenth': {'clean': 40, 'form': 20, 'pair': 4, 'outside': 4},
    'seventeenth': {'clean': 40, 'form': 20, 'pair': 4, 'outside': 4},
    'eighteenth': {'clean': 40, 'form': 20, 'pair': 4, 'outside': 4},
    'nineteenth': {'clean': 40, 'form': 20, 'pair': 4, 'outside': 4},
    'twentieth': {'clean': 40, 'form': 20, 'pair': 4, 'outside': 4},
    'twentyfirst': {'clean': 40, 'form': 20, 'pair': 4, 'outside': 4},
    'twentysecond': {'clean': 40, 'form': 20, 'pair': 4, 'outside': 4},
    'twentythird': {'clean': 40, 'form': 20, 'pair': 4, 'outside': 4},
    'twentyfourth': {'clean': 40, 'form': 20, 'pair': 4, 'outside': 4},
    'twentyfifth': {'clean': 40, 'form': 20, 'pair': 4, 'outside': 4},
    'twentysixth': {'clean': 40, 'form': 20, 'pair': 4, 'outside': 4},
    'twentyseventh': {'clean': 40, 'form': 20, 'pair': 4, 'outside': 4},
    'twentyeighth': {'clean': 40, 'form': 20, 'pair': 4, 'outside': 4},
    'twentyninth': {'clean': 40, 'form': 20, 'pair': 4, 'outside': 4},
    'thirtieth': {'clean': 40, 'form': 20, 'pair': 4, 'outside': 4},
    'thirtyfirst': {'clean': 24, 'form': 16, 'pair': 14, 'outside': 4},
    'thirtysecond': {'clean': 30, 'form': 20, 'pair': 8, 'outside': 4},
    'thirtythird': {'clean': 16, 'form': 16, 'pair': 5, 'outside': 3},
}


@dataclass(frozen=True)
class Own:
    """What a set alone has, and how many of its forms are in none of its pairs."""

    forms: tuple[Form, ...]
    pairs: tuple[tuple[str, str], ...]
    outside: dict[str, Drawer]
    classes: frozenset[str] = frozenset({'load', 'shape', 'material', 'sensor'})
    unpaired: int = 0


OWN = {
    'seventh': Own(SEVENTH_FORMS, SEVENTH_PAIRS, SEVENTH_OUTSIDE),
    'eighth': Own(EIGHTH_FORMS, EIGHTH_PAIRS, EIGHTH_OUTSIDE),
    'ninth': Own(NINTH_FORMS, NINTH_PAIRS, NINTH_OUTSIDE),
    'tenth': Own(TENTH_FORMS, TENTH_PAIRS, TENTH_OUTSIDE, frozenset({'load', 'sensor'}), 2),
    'eleventh': Own(
        ELEVENTH_FORMS, ELEVENTH_PAIRS, ELEVENTH_OUTSIDE, frozenset({'shape', 'sensor'}), 3
    ),
    'twelfth': Own(TWELFTH_FORMS, TWELFTH_PAIRS, TWELFTH_OUTSIDE, frozenset({'load', 'shape'}), 3),
    'thirteenth': Own(
        THIRTEENTH_FORMS,
        THIRTEENTH_PAIRS,
        THIRTEENTH_OUTSIDE,
        frozenset({'material', 'sensor'}),
        3,
    ),
    'fourteenth': Own(
        FOURTEENTH_FORMS,
        FOURTEENTH_PAIRS,
        FOURTEENTH_OUTSIDE,
        frozenset({'material', 'sensor'}),
        3,
    ),
    'fifteenth': Own(
        FIFTEENTH_FORMS, FIFTEENTH_PAIRS, FIFTEENTH_OUTSIDE, frozenset({'load', 'shape'}), 3
    ),
    'sixteenth': Own(
        SIXTEENTH_FORMS, SIXTEENTH_PAIRS, SIXTEENTH_OUTSIDE, frozenset({'load', 'sensor'}), 3
    ),
    'seventeenth': Own(
        SEVENTEENTH_FORMS,
        SEVENTEENTH_PAIRS,
        SEVENTEENTH_OUTSIDE,
        frozenset({'shape', 'sensor'}),
        3,
    ),
    'eighteenth': Own(
        EIGHTEENTH_FORMS, EIGHTEENTH_PAIRS, EIGHTEENTH_OUTSIDE, frozenset({'shape', 'sensor'}), 3
    ),
    'nineteenth': Own(
        NINETEENTH_FORMS,
        NINETEENTH_PAIRS,
        NINETEENTH_OUTSIDE,
        frozenset({'material', 'sensor'}),
        3,
    ),
    'twentieth': Own(
        TWENTIETH_FORMS, TWENTIETH_PAIRS, TWENTIETH_OUTSIDE, frozenset({'load', 'sensor'}), 3
    ),
    'twentyfirst': Own(
        TWENTYFIRST_FORMS,
        TWENTYFIRST_PAIRS,
        TWENTYFIRST_OUTSIDE,
        frozenset({'shape', 'sensor'}),
        3,
    ),
    'twentysecond': Own(
        TWENTYSECOND_FORMS,
        TWENTYSECOND_PAIRS,
        TWENTYSECOND_OUTSIDE,
        frozenset({'load', 'sensor'}),
        3,
    ),
    'twentythird': Own(
        TWENTYTHIRD_FORMS,
        TWENTYTHIRD_PAIRS,
        TWENTYTHIRD_OUTSIDE,
        frozenset({'shape', 'sensor'}),
        3,
    ),
    'twentyfourth': Own(
        TWENTYFOURTH_FORMS,
        TWENTYFOURTH_PAIRS,
        TWENTYFOURTH_OUTSIDE,
        frozenset({'shape', 'sensor'}),
        3,
    ),
    'twentyfifth': Own(
        TWENTYFIFTH_FORMS,
        TWENTYFIFTH_PAIRS,
        TWENTYFIFTH_OUTSIDE,
        frozenset({'shape', 'sensor'}),
        3,
    ),
    'twentysixth': Own(
        TWENTYSIXTH_FORMS,
        TWENTYSIXTH_PAIRS,
        TWENTYSIXTH_OUTSIDE,
        frozenset({'shape', 'sensor'}),
        3,
    ),
    'twentyseventh': Own(
        TWENTYSEVENTH_FORMS,
        TWENTYSEVENTH_PAIRS,
        TWENTYSEVENTH_OUTSIDE,
        frozenset({'shape', 'sensor'}),
        3,
    ),
    'twentyeighth': Own(
        TWENTYEIGHTH_FORMS,
        TWENTYEIGHTH_PAIRS,
        TWENTYEIGHTH_OUTSIDE,
        frozenset({'shape', 'sensor'}),
        3,
    ),
    'twentyninth': Own(
        TWENTYNINTH_FORMS,
        TWENTYNINTH_PAIRS,
        TWENTYNINTH_OUTSIDE,
        frozenset({'shape', 'sensor'}),
        3,
    ),
    'thirtieth': Own(
        THIRTIETH_FORMS,
        THIRTIETH_PAIRS,
        THIRTIETH_OUTSIDE,
        frozenset({'shape', 'sensor'}),
        3,
    ),
    'thirtyfirst': Own(
        THIRTYFIRST_FORMS,
        THIRTYFIRST_PAIRS,
        THIRTYFIRST_OUTSIDE,
        frozenset({'shape', 'sensor'}),
    ),
    'thirtysecond': Own(
        THIRTYSECOND_FORMS,
        THIRTYSECOND_PAIRS,
        THIRTYSECOND_OUTSIDE,
        frozenset({'shape', 'sensor'}),
    ),
    'thirtythird': Own(
        THIRTYTHIRD_FORMS,
        THIRTYTHIRD_PAIRS,
        THIRTYTHIRD_OUTSIDE,
        frozenset({'shape', 'sensor'}),
        2,
    ),
}


@pytest.fixture(scope='module', params=sorted(OWN))
def set_name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(scope='module')
def cases(set_name: str) -> list[Case]:
    return list_form_cases(set_name, 'salt')


@pytest.mark.parametrize('name', sorted(COUNTS))
def test_a_set_has_its_cases_and_their_names_tell_nothing(name: str) -> None:
    cases = list_form_cases(name, 'salt')
    assert Counter(case.kind for case in cases) == COUNTS[name]
    named = [case for case in cases if case.kind != 'clean']
    assert [case.id for case in named] == [f'form_{number:03d}' for number in range(len(named))]
    other = [case for case in list_form_cases(name, 'other') if case.kind != 'clean']
    assert [case.effects for case in named] != [case.effects for case in other]
    kinds = [case.kind for case in named]
    assert kinds != sorted(kinds), 'kinds are mixed'
    assert {case.effects for case in named} == {case.effects for case in other}


def test_every_set_of_several_laws_is_checked_here() -> None:
    assert set(COUNTS) == set(LAWS_SETS)
    assert set(OWN) == set(LAWS_SETS) - {'sixth'}


def test_worlds_are_of_all_laws_sensors_and_shapes(set_name: str, cases: list[Case]) -> None:
    clean = [case for case in cases if case.kind == 'clean']
    whole = Counter((case.law, case.sensor, case.family) for case in clean)
    kinds, count = len(LAWS) * len(DRAWN) * 4, COUNTS[set_name]['clean']
    assert len(whole) == min(kinds, count)
    assert set(whole.values()) == {max(count // kinds, 1)}
    assert {law for law, _, _ in whole} == set(LAWS)
    assert {sensor for _, sensor, _ in whole} == set(DRAWN)
    assert len({family for _, _, family in whole}) == 4
    faulty = [case for case in cases if case.kind != 'clean']
    for name, most in (('law', 11), ('sensor', 16), ('family', 14)):
        counts = Counter(getattr(case, name) for case in faulty)
        assert len(counts) == len({getattr(case, name) for case in clean})
        assert max(counts.values()) <= most


def test_no_form_pair_or_cause_is_of_another_set(set_name: str) -> None:
    own = OWN[set_name]
    others = [contents for name, contents in LAWS_SETS.items() if name != set_name]
    elsewhere = {form.key for name in FORMS if name != set_name for form in FORMS[name]}
    assert FORMS[set_name] == own.forms
    assert not {form.key for form in own.forms} & elsewhere
    pairs = {frozenset(pair) for contents in others for pair in contents.pairs}
    assert not {frozenset(pair) for pair in own.pairs} & pairs
    causes = {name for contents in others for name in contents.outside}
    assert not set(own.outside) & {*OUTSIDE, *LIBRARY, *causes}
    classes = {OUTSIDE_CLASS[name] for name in own.outside}
    assert classes == own.classes


def test_pairs_are_of_different_effects_and_mix_new_and_earlier_forms(set_name: str) -> None:
    pairs, new = OWN[set_name].pairs, {form.key for form in OWN[set_name].forms}
    assert all(BY_KEY[one].truth != BY_KEY[other].truth for one, other in pairs)
    assert all(new & set(pair) for pair in pairs)
    assert len(new - {key for pair in pairs for key in pair}) == OWN[set_name].unpaired
    assert any(set(pair) - new for pair in pairs)


@pytest.mark.parametrize(
    ('own', 'count', 'least'), [(THIRTYFIRST_PAIRS, 14, 5), (THIRTYSECOND_PAIRS, 8, 4)]
)
def test_pairs_of_the_last_sets_are_of_all_effects_and_each_of_others(
    own: tuple[tuple[str, str], ...], count: int, least: int
) -> None:
    effects = [[BY_KEY[key].truth for key in pair] for pair in own]
    assert {truth for pair in effects for truth in pair} == set(LIBRARY)
    assert len({frozenset(pair) for pair in effects}) == len(effects) == count
    sensor = {'camera_offset', 'depth_affine', 'depth_bias_by_region'}
    counts = Counter(len(sensor & set(pair)) for pair in effects)
    assert min(counts[0], counts[1]) >= least
    assert counts[2] <= 2


def test_no_effect_is_twice_in_pairs_of_the_thirty_third_set() -> None:
    effects = [BY_KEY[key].truth for pair in THIRTYTHIRD_PAIRS for key in pair]
    assert len(set(effects)) == len(effects) == 10


def test_labels_of_pairs_tell_of_both_effects() -> None:
    cases = [case for case in list_form_cases('thirtyfirst', 'salt') if case.kind == 'pair']
    found = list(labelled(cases))
    assert len(found) == 12
    for case, _, effects, label in found:
        assert [each['identifier'] for each in label['effects']] == [
            BY_KEY[key].truth for key, _ in case.effects
        ]
        assert all(effect.changes for effect in effects)


def test_two_effects_of_a_pair_change_different_faults(cases: list[Case]) -> None:
    for _, _, (one, other), _ in labelled(case for case in cases if case.kind == 'pair'):
        assert not set(one.changes) & set(other.changes)


def test_labels_tell_law_fixture_effects_and_class(cases: list[Case]) -> None:
    shifted = []
    for case, _, effects, label in labelled(cases):
        check_label(case, label)
        told = [
            name in label['faults'] or value == (1.0, 1.0)
            for effect in effects
            for name, value in effect.changes.items()
            if name not in ('added_mass_at', 'contrast_mode')
        ]
        assert all(told)
        shifted.append(np.linalg.norm(label['fixture_shift_mm']) > 0.0)
    assert 0.35 < np.mean(shifted) < 0.65


# What each told when there were no other bodies yet.
BEFORE = {
    'sealed': Told(
        '112334384c879c1d3582468ef795fa470c1adba715ac149c0510708b606083ed', -18.448774724249
    ),
    'sixth': Told(
        '2604b907696b2a04bb0bed935e7730c43d80f10e570763a8678edfec020ab337', 126.198077512843
    ),
    'twentieth': Told(
        '59b1da0318bf1057df033682e7ea7551167d3237ad6082774e97b874b6bfb8ca', -286.114458804334
    ),
    'thirtythird': Told(
        'c81f4a69330150a90ee45975c198a09122062e919c63e2c6a360fa47cd91c1ae', 32.209101783383
    ),
}


@pytest.mark.parametrize('name', BEFORE)
def test_cases_are_drawn_as_they_were_before_there_were_other_bodies(name: str) -> None:
    told = drawn_digest(name, 12)
    assert told.words == BEFORE[name].words
    assert told.numbers == pytest.approx(BEFORE[name].numbers, abs=1e-7)
