# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Rigs, effects and cases of the thirty-fifth set."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from support.blind_rigs import check_spread, drawn_rig
import yaml

from benchmarks.blind.amplitudes import LIBRARY, OUTSIDE_CLASS
from benchmarks.blind.cases import FORM_SETS
from benchmarks.blind.faults import Faults
from benchmarks.blind.further_bodies import FURTHER_FAMILIES
from benchmarks.blind.further_shape import FurtherShape
from benchmarks.blind.generator import draw_case
from benchmarks.blind.labels import label_of
from benchmarks.blind.other_ranges import RANGES_34
from benchmarks.blind.other_rigs import (
    OtherSetup,
    rests_of,
    sees_all,
)
from benchmarks.blind.other_sets import list_other_cases, OTHER_SETS, rig_label
from benchmarks.blind.scene_file import extra_text, scene_text
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.thirtyfifth_forms import RANGES_35, wanted_change_35

CONTENTS = OTHER_SETS['thirtyfifth']
CASES = list_other_cases('thirtyfifth', 'salt')
SEAL = Path(__file__).parents[2] / 'benchmarks/blind/thirtyfifth_form_sealed_labels.sha256'


@pytest.fixture(scope='module')
def crank() -> OtherSetup:
    return drawn_rig('crank', ranges=RANGES_35)


def test_a_set_has_its_cases_and_their_names_tell_nothing() -> None:
    assert Counter(case.kind for case in CASES) == {
        'clean': 14,
        'form': 20,
        'pair': 6,
        'outside': 4,
    }
    named = [case for case in CASES if case.kind != 'clean']
    assert [case.id for case in named] == [f'form_{number:03d}' for number in range(30)]
    clean = [case.id for case in CASES if case.kind == 'clean']
    assert clean == [f'world_{number:03d}' for number in range(14)]
    other = [case for case in list_other_cases('thirtyfifth', 'other') if case.kind != 'clean']
    assert [case.effects for case in named] != [case.effects for case in other]
    assert {case.effects for case in named} == {case.effects for case in other}
    assert 'thirtyfifth' not in FORM_SETS


def test_bodies_sensors_laws_and_poses_are_spread() -> None:
    check_spread(CASES, FURTHER_FAMILIES, {2, 3, 4, 5})


def test_each_effect_is_there_on_bodies_it_makes_sense_on() -> None:
    truths = Counter(form.truth for form in CONTENTS.forms)
    assert set(truths) == set(LIBRARY)
    assert set(truths.values()) == {1, 2}
    assert len(CONTENTS.by_key) == len(CONTENTS.forms) + len(CONTENTS.outside) == 24
    for case in CASES:
        forms = [CONTENTS.by_key[key] for key, _ in case.effects]
        assert all(case.family in (form.families or FURTHER_FAMILIES) for form in forms)
        assert case.poses >= max((form.poses for form in forms), default=2)
    assert {OUTSIDE_CLASS[form.truth] for form in CONTENTS.outside} == {
        *('load', 'shape', 'material', 'sensor')
    }
    pairs = [{CONTENTS.by_key[key].truth for key in pair} for pair in CONTENTS.pairs]
    assert all(len(pair) == 2 for pair in pairs)


@pytest.mark.parametrize('family', ['cross', 'ribbon', 'tentacle'])
def test_rigs_are_as_they_are_to_be(family: str) -> None:
    setup = drawn_rig(family, seed=4, ranges=RANGES_35)
    least, most = FURTHER_FAMILIES[family].sags
    assert 0.97 * least < setup.sag / setup.body.free < 1.03 * most
    assert 30e3 < setup.youngs_modulus < 5e6
    assert 3 <= setup.frames <= 8
    assert (setup.camera.width, setup.camera.height) in RANGES_35.images
    assert not set(RANGES_35.images) & set(RANGES_34.images)
    assert 0.15 <= setup.depth_from_world[2, 3] <= 0.8
    assert 0.00012 <= setup.sensor.bias <= 0.0006
    specimen = make_specimen(setup, Faults(), 0.8)
    rests = rests_of(specimen, setup, Faults())
    assert sees_all(setup, rests)
    assert isinstance(setup.body, FurtherShape)
    assert not any(setup.body.touches_itself(specimen.mesh.lattice, rest) for rest in rests)
    extra = yaml.safe_load(extra_text(setup, None))
    assert {'box', 'note'} == set(extra['fixture'])
    scene = yaml.safe_load(scene_text(setup))
    assert scene['sensor'].get('smooth_error') == setup.smooth_stated


def test_stated_smooth_errors_are_off_by_what_is_drawn() -> None:
    drawn = np.array(
        [
            [setup.smooth_stated or 0.0, setup.sensor.bias]
            for setup in (drawn_rig('wedge', seed, ranges=RANGES_35) for seed in range(12))
        ]
    )
    stated = drawn[drawn[:, 0] > 0.0]
    assert 2 <= len(stated) <= 10
    factors = stated[:, 0] / stated[:, 1]
    # They are told to a hundredth of a millimetre, rounded up.
    least = np.array(sorted(set(RANGES_35.misstated)))
    over = factors[:, None] / least
    assert ((over >= 1.0) & (over < 1.0 + 1e-5 / (least * 0.00012))).any(axis=1).all()
    assert sorted(RANGES_35.misstated) == pytest.approx([1.0 / 1.5, 1.0, 1.0, 1.0, 1.0, 1.5])
    assert RANGES_34.misstated == (1.0,)


def test_changes_are_millimetres(crank: OtherSetup) -> None:
    random = np.random.default_rng(1)
    small, large = (
        np.array([wanted_change_35(crank, size, random) for _ in range(50)]) for size in (1, 2)
    )
    most = 0.12 * crank.body.free
    assert 0.0032 <= small.min() < small.max() <= max(min(0.006, most), 0.0032)
    assert min(0.006, most) <= large.min() <= large.max() <= max(min(0.012, most), 0.0032)


def test_each_of_a_pair_is_clearly_seen() -> None:
    pair = next(case for case in CASES if case.kind == 'pair' and 'ring' in str(case.effects))
    setup, effects, faults = draw_case(pair)
    assert isinstance(setup, OtherSetup)
    assert len(setup.changes) == len(effects) == 2
    assert min(setup.changes) >= 0.003
    label = {**label_of(pair, setup, effects, faults, np.zeros(3)), 'rig': rig_label(setup)}
    assert {told['identifier'] for told in label['effects']} == {'added_mass', 'depth_affine'}
    assert label['set'] == 'thirtyfifth'
    assert min(label['rig']['largest_changes_mm']) >= 3.0


@pytest.mark.parametrize('key', ['heat', 'jet', 'memory', 'wiggle'])
def test_causes_outside_the_library_are_those_of_earlier_sets(crank: OtherSetup, key: str) -> None:
    drawn = CONTENTS.by_key[key].draw(crank, np.random.default_rng(1))
    assert getattr(Faults(**drawn), key) == drawn[key]
    assert drawn[key] != 0.0
    shares = drawn.get(f'{key}_shares', (0.5, 0.5))
    assert len(shares) == len(crank.observations)
    assert 0.3 <= min(shares) <= max(shares) <= 1.0


def test_the_seal_has_a_line_for_each_case() -> None:
    lines = SEAL.read_text().splitlines()
    assert [line.split('  ')[1] for line in lines] == sorted(f'{case.id}.json' for case in CASES)
    assert {len(line.split('  ')[0]) for line in lines} == {64}
