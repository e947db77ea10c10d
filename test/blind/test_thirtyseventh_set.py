# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effects, pairs and cases of the thirty-seventh set, and of the one after it: of another salt."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from support.blind_rigs import check_spread

from benchmarks.blind.amplitudes import LIBRARY, OUTSIDE_CLASS
from benchmarks.blind.generator import draw_case
from benchmarks.blind.other_rigs import OtherSetup
from benchmarks.blind.other_sets import contents_of, list_other_cases, OTHER_SETS
from benchmarks.blind.salted_effects import draw_effects, FORMS_37, PAIRS, RANGES_37, SINGLES

CONTENTS = contents_of('thirtyseventh', 'salt')
CASES = list_other_cases('thirtyseventh', 'salt')
SEALS = Path(__file__).parents[2] / 'benchmarks/blind'
# No stiffening that a pair has changes what is seen by enough.
_NOT_DRAWN = {'thirtyseventh': ('form_016',), 'thirtyeighth': ()}
_SETS_BEFORE = ('thirtyfourth', 'thirtyfifth', 'thirtysixth')


def test_a_set_has_its_cases_and_their_names_tell_nothing() -> None:
    kinds = Counter(case.kind for case in CASES)
    assert kinds == {'clean': 12, 'form': SINGLES, 'pair': PAIRS, 'outside': 2}
    named = [case.id for case in CASES if case.kind != 'clean']
    assert named == [f'form_{number:03d}' for number in range(SINGLES + PAIRS + 2)]
    assert {OUTSIDE_CLASS[form.truth] for form in CONTENTS.outside} == {'load', 'shape'}


def test_bodies_sensors_laws_and_poses_are_spread() -> None:
    check_spread(CASES, RANGES_37.families, {2, 3, 4, 5})


def test_a_salt_tells_which_effects_there_are_and_which_make_a_pair() -> None:
    again, other = contents_of('thirtyseventh', 'salt'), contents_of('thirtyseventh', 'other')
    assert again.pairs == CONTENTS.pairs
    assert len(set(CONTENTS.pairs) & set(other.pairs)) < PAIRS / 2
    assert CONTENTS.forms != other.forms


@pytest.mark.parametrize('seed', range(20))
def test_no_effect_is_beside_itself_and_no_pair_is_there_twice(seed: int) -> None:
    singles, pairs = draw_effects(np.random.default_rng(seed))
    truth = {form.key: form.truth for form in FORMS_37}
    effects = [tuple(truth[key] for key in pair) for pair in pairs]
    assert len({frozenset(pair) for pair in effects}) == PAIRS
    assert min(len(frozenset(pair)) for pair in effects) == 2
    # A body is laid down as it hangs with what else there is.
    assert 'contact_plane' not in {one for one, _ in effects}
    counts = Counter(effect for pair in effects for effect in pair)
    assert set(counts) == set(LIBRARY)
    assert set(counts.values()) <= {3, 4}
    assert len({form.truth for form in singles}) == SINGLES


def test_forms_are_those_of_the_sets_before_on_bodies_they_make_sense_on() -> None:
    known = {key: form for name in _SETS_BEFORE for key, form in OTHER_SETS[name].by_key.items()}
    assert {form.key for form in FORMS_37} <= set(known)
    by_key = {form.key: form for form in FORMS_37}
    limited = [key for key in by_key if known[key].families]
    assert limited
    assert all(set(known[key].families) <= set(by_key[key].families) for key in limited)
    for case in CASES:
        forms = [CONTENTS.by_key[key] for key, _ in case.effects]
        assert all(not form.families or case.family in form.families for form in forms)
        assert case.poses >= max((form.poses for form in forms), default=2)


def test_a_pair_is_drawn_and_each_of_it_is_clearly_seen() -> None:
    case = next(case for case in CASES if case.kind == 'pair' and 'camera' in str(case.effects))
    setup, effects, _ = draw_case(case)
    assert isinstance(setup, OtherSetup)
    assert [effect.identifier for effect in effects] == [
        CONTENTS.by_key[key].truth for key, _ in case.effects
    ]
    assert min(setup.changes) >= 0.003


@pytest.mark.parametrize('name', _NOT_DRAWN)
def test_the_seal_has_a_line_for_each_case_that_could_be_drawn(name: str) -> None:
    lines = (SEALS / f'{name}_form_sealed_labels.sha256').read_text().splitlines()
    names = sorted(f'{case.id}.json' for case in CASES if case.id not in _NOT_DRAWN[name])
    assert [line.split('  ')[1] for line in lines] == names
    assert {len(line.split('  ')[0]) for line in lines} == {64}
