# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Rigs, effects and cases of the thirty-sixth set."""

from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.blind_rigs import check_spread, drawn_rig
import yaml

from benchmarks.blind.amplitudes import LIBRARY, OUTSIDE_CLASS
from benchmarks.blind.cases import FORM_SETS
from benchmarks.blind.faults import Faults
from benchmarks.blind.generator import draw_case
from benchmarks.blind.labels import label_of
from benchmarks.blind.later_bodies import LATER_FAMILIES
from benchmarks.blind.other_ranges import RANGES_34
from benchmarks.blind.other_rigs import OtherSetup, rests_of, sees_all
from benchmarks.blind.other_sets import list_other_cases, OTHER_SETS, rig_label
from benchmarks.blind.other_sizes import laid
from benchmarks.blind.scene_file import extra_text, scene_text
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.thirtyfifth_forms import RANGES_35, wanted_change_35
from benchmarks.blind.thirtysixth_forms import RANGES_36

CONTENTS = OTHER_SETS['thirtysixth']
CASES = list_other_cases('thirtysixth', 'salt')
SEAL = Path(__file__).parents[2] / 'benchmarks/blind/thirtysixth_form_sealed_labels.sha256'
_SENSOR = {'camera_offset', 'depth_affine', 'depth_bias_by_region'}


def _combinations(set_name: str) -> list[frozenset[str]]:
    """Return the effects of a set's pairs."""
    contents = OTHER_SETS[set_name]
    return [frozenset(contents.by_key[key].truth for key in pair) for pair in contents.pairs]


@pytest.fixture(scope='module')
def wye() -> OtherSetup:
    return drawn_rig('wye', ranges=RANGES_36)


def test_a_set_has_its_cases_and_their_names_tell_nothing() -> None:
    kinds = Counter(case.kind for case in CASES)
    assert kinds == {'clean': 12, 'form': 14, 'pair': 12, 'outside': 2}
    named = [case for case in CASES if case.kind != 'clean']
    assert [case.id for case in named] == [f'form_{number:03d}' for number in range(28)]
    clean = [case.id for case in CASES if case.kind == 'clean']
    assert clean == [f'world_{number:03d}' for number in range(12)]
    assert 'thirtysixth' not in FORM_SETS


def test_a_salt_tells_where_effects_are_and_on_which_bodies() -> None:
    named, other = (
        [case for case in list_other_cases('thirtysixth', salt) if case.kind != 'clean']
        for salt in ('salt', 'other')
    )
    assert [case.effects for case in named] != [case.effects for case in other]
    assert {case.effects for case in named} == {case.effects for case in other}
    bodies = [{case.effects: case.family for case in cases} for cases in (named, other)]
    assert bodies[0] != bodies[1]


def test_bodies_sensors_laws_and_poses_are_spread() -> None:
    check_spread(CASES, LATER_FAMILIES, {2, 3, 4, 5})


def test_each_effect_is_there_on_bodies_it_makes_sense_on() -> None:
    truths = Counter(form.truth for form in CONTENTS.forms)
    assert set(truths) == set(LIBRARY)
    assert set(truths.values()) == {1, 2}
    every = (*CONTENTS.forms, *CONTENTS.paired, *CONTENTS.outside)
    assert len(CONTENTS.by_key) == len(every)
    assert {key for pair in CONTENTS.pairs for key in pair} <= set(CONTENTS.by_key)
    for case in CASES:
        forms = [CONTENTS.by_key[key] for key, _ in case.effects]
        assert all(case.family in (form.families or LATER_FAMILIES) for form in forms)
        assert case.poses >= max((form.poses for form in forms), default=2)
    assert {OUTSIDE_CLASS[form.truth] for form in CONTENTS.outside} == {'shape', 'sensor'}


def test_pairs_are_all_others() -> None:
    pairs = _combinations('thirtysixth')
    assert len(set(pairs)) == len(pairs) == 12
    assert all(len(pair) == 2 for pair in pairs)
    assert not set(pairs) & {*_combinations('thirtyfourth'), *_combinations('thirtyfifth')}
    counts = Counter(effect for pair in pairs for effect in pair)
    assert set(counts) == set(LIBRARY)
    assert set(counts.values()) == {2, 3}
    assert sum(pair <= _SENSOR for pair in pairs) <= 2


@pytest.mark.parametrize('family', ['vault', 'zigzag', 'coil'])
def test_rigs_are_as_they_are_to_be(family: str) -> None:
    setup = drawn_rig(family, 4, ranges=RANGES_36)
    least, most = LATER_FAMILIES[family].sags
    assert 0.97 * least < setup.sag / setup.body.free < 1.03 * most
    assert 20e3 < setup.youngs_modulus < 8e6
    assert 3 <= setup.frames <= 8
    assert (setup.camera.width, setup.camera.height) in RANGES_36.images
    assert not set(RANGES_36.images) & {*RANGES_34.images, *RANGES_35.images}
    assert 0.18 <= setup.depth_from_world[2, 3] <= 0.9
    assert 0.00012 <= setup.sensor.bias <= 0.0007
    rests = rests_of(make_specimen(setup, Faults(), 0.8), setup, Faults())
    assert sees_all(setup, rests)
    extra = yaml.safe_load(extra_text(setup, None))
    is_one = family != 'vault'
    assert set(extra['fixture']) == {'note', 'box' if is_one else 'boxes'}
    scene = yaml.safe_load(scene_text(setup))
    assert scene['sensor'].get('smooth_error') == setup.smooth_stated
    assert sorted(RANGES_36.misstated) == pytest.approx([1.0 / 1.7, 1.0, 1.0, 1.0, 1.0, 1.7])


@pytest.mark.parametrize('key', sorted(CONTENTS.by_key))
def test_faults_are_those_of_their_forms(wye: OtherSetup, key: str) -> None:
    form = CONTENTS.by_key[key]
    drawn = form.draw(wye, np.random.default_rng(1))
    faults = Faults(**drawn)
    # They can be made larger, and are some.
    assert all(np.any(np.array(getattr(faults, name)) != 0.0) for name in form.scaled)
    assert faults != Faults()
    shares = drawn.get('shrinking_shares', (1.0, 1.0))
    assert len(shares) == len(wye.observations)
    assert shares[-1] == 1.0
    slant = drawn.get('region_slant', 0.2)
    assert 0.1 < abs(slant) < 0.5
    begin, until = drawn.get('region_from', 0.5), drawn.get('region_until', 1.0)
    assert 0.2 < begin < until <= 1.0


def test_a_body_is_laid_down_as_it_hangs_with_what_else_there_is() -> None:
    form, random = CONTENTS.by_key['contact_plane/library'], np.random.default_rng(3)
    setup = drawn_rig('crank', is_lower=True, ranges=RANGES_36)
    more = {'clamp_shift': (0.0, 0.0, 8.0)}
    moved, found, change = laid(setup, {**more, **form.draw(setup, random)}, 0.004, random)
    assert found['clamp_shift'] == more['clamp_shift']
    faults = Faults(**found)
    specimen = make_specimen(moved, faults, 0.8)
    free = replace(faults, contact_height=None)
    moves = [
        float(np.linalg.norm(one - other, axis=1).max())
        for one, other in zip(
            rests_of(specimen, moved, faults), rests_of(specimen, moved, free), strict=True
        )
    ]
    assert max(moves) == pytest.approx(change, rel=0.02)


def test_each_of_a_pair_is_clearly_seen() -> None:
    key = 'camera_offset/library'
    pair = next(case for case in CASES if case.kind == 'pair' and case.effects[0][0] == key)
    setup, effects, faults = draw_case(pair)
    assert isinstance(setup, OtherSetup)
    assert len(setup.changes) == len(effects) == 2
    assert min(setup.changes) >= 0.003
    most = max(wanted_change_35(setup, 2, np.random.default_rng(seed)) for seed in range(50))
    assert max(setup.changes) <= 1.1 * most
    label = {**label_of(pair, setup, effects, faults, np.zeros(3)), 'rig': rig_label(setup)}
    told = {effect['identifier'] for effect in label['effects']}
    assert told == {'camera_offset', 'depth_bias_by_region'}
    assert label['set'] == 'thirtysixth'
    assert min(label['rig']['largest_changes_mm']) >= 3.0


def test_the_seal_has_a_line_for_each_case() -> None:
    lines = SEAL.read_text().splitlines()
    assert [line.split('  ')[1] for line in lines] == sorted(f'{case.id}.json' for case in CASES)
    assert {len(line.split('  ')[0]) for line in lines} == {64}
