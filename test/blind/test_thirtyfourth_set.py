# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Rigs, effects and cases of the thirty-fourth set."""

from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.blind_rigs import check_spread, drawn_rig
import yaml

from benchmarks.blind.amplitudes import LIBRARY, OUTSIDE_CLASS
from benchmarks.blind.cases import FORM_SETS, list_form_cases
from benchmarks.blind.faults import Faults
from benchmarks.blind.generator import draw_case, main
from benchmarks.blind.labels import label_of
from benchmarks.blind.observe import true_rendering
from benchmarks.blind.other_bodies import draw_other_shape, OTHER_FAMILIES
from benchmarks.blind.other_rigs import (
    at_distance,
    OtherSetup,
    rests_of,
    sees_all,
    widest,
)
from benchmarks.blind.other_sets import list_other_cases, rig_label
from benchmarks.blind.other_sizes import laid, scaled, sized, smaller, wanted_change
from benchmarks.blind.paint import FIXTURE
from benchmarks.blind.rotations import applied
from benchmarks.blind.scene_file import extra_text, scene_text
from benchmarks.blind.sensor import DRAWN
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.thirtyfourth_forms import BY_KEY_34, FORMS_34, OUTSIDE_34, PAIRS_34

CASES = list_other_cases('thirtyfourth', 'salt')
SEAL = Path(__file__).parents[2] / 'benchmarks/blind/thirtyfourth_form_sealed_labels.sha256'


@pytest.fixture(scope='module')
def elbow() -> OtherSetup:
    return drawn_rig('elbow')


@pytest.fixture(scope='module')
def low() -> OtherSetup:
    return drawn_rig('slotted', is_lower=True)


def test_a_set_has_its_cases_and_their_names_tell_nothing() -> None:
    assert Counter(case.kind for case in CASES) == {
        'clean': 18,
        'form': 22,
        'pair': 4,
        'outside': 4,
    }
    named = [case for case in CASES if case.kind != 'clean']
    assert [case.id for case in named] == [f'form_{number:03d}' for number in range(30)]
    clean = [case.id for case in CASES if case.kind == 'clean']
    assert clean == [f'world_{number:03d}' for number in range(18)]
    other = [case for case in list_other_cases('thirtyfourth', 'other') if case.kind != 'clean']
    assert [case.effects for case in named] != [case.effects for case in other]
    assert {case.effects for case in named} == {case.effects for case in other}


def test_bodies_sensors_laws_and_poses_are_spread() -> None:
    for kinds in (('clean',), ('form', 'pair', 'outside')):
        own = [case for case in CASES if case.kind in kinds]
        check_spread(own, OTHER_FAMILIES, {2, 3, 4, 5, 6})


def test_each_effect_is_there_twice_in_two_sizes_on_two_bodies() -> None:
    singles = [case for case in CASES if case.kind == 'form']
    for truth in LIBRARY:
        own = [case for case in singles if BY_KEY_34[case.effects[0][0]].truth == truth]
        assert sorted(case.effects[0][1] for case in own) == [1, 2]
        assert len({case.family for case in own}) == len({case.effects[0][0] for case in own}) == 2
    for case in CASES:
        for key, _ in case.effects:
            form = BY_KEY_34[key]
            assert case.family in (form.families or OTHER_FAMILIES)
            assert case.poses >= form.poses
    assert {OUTSIDE_CLASS[form.truth] for form in OUTSIDE_34} == {
        *('load', 'shape', 'material', 'sensor')
    }
    truths = [{BY_KEY_34[key].truth for key in pair} for pair in PAIRS_34]
    assert all(len(pair) == 2 for pair in truths)
    assert len(FORMS_34) == 22


@pytest.mark.parametrize('family', ['bridge', 'wings'])
def test_rigs_are_as_they_are_to_be(family: str) -> None:
    setup = drawn_rig(family, seed=4)
    kind = OTHER_FAMILIES[family]
    turns = [view.world_from_object[:3, :3] for view in setup.observations]
    assert widest(turns) > 60.0
    assert 0.97 * kind.sags[0] < setup.sag / setup.body.free < 1.03 * kind.sags[1]
    assert 15e3 < setup.youngs_modulus < 15e6
    assert 3 <= setup.frames <= 10
    assert 950.0 <= setup.density <= 1300.0
    assert 0.45 <= setup.poissons_ratio <= 0.495
    assert 0.12 <= setup.depth_from_world[2, 3] <= 1.2
    assert 0.00015 <= setup.sensor.bias <= 0.0012
    specimen = make_specimen(setup, Faults(), 0.8)
    rests = rests_of(specimen, setup, Faults())
    assert sees_all(setup, rests)
    assert not sees_all(setup, rests, margin=1.0)
    far = [np.linalg.norm(rest - specimen.mesh.nodes, axis=1).max() for rest in rests]
    assert max(far) == pytest.approx(setup.sag, rel=1e-6)
    for rest, view in zip(rests, setup.observations, strict=True):
        small = replace(setup, camera=smaller(setup.camera))
        rendering = true_rendering(specimen, small, view, Faults(), rest)
        is_body = np.isfinite(rendering.depth[..., 4]) & (rendering.labels[..., 4] != FIXTURE)
        rows, columns = np.nonzero(is_body)
        assert len(rows) > 40
        assert min((rows + rendering.row).min(), (columns + rendering.column).min()) > 0
        assert (rows + rendering.row).max() < small.camera.height - 1
        assert (columns + rendering.column).max() < small.camera.width - 1
        points = applied(setup.depth_from_world @ view.world_from_object, rest)
        assert np.nanmin(rendering.depth) > points[:, 2].min() - 2.0 * setup.rim


def test_fixtures_lie_around_all_that_is_held(elbow: OtherSetup) -> None:
    for family in ('portal', 'bridge', 'wings', 'tube'):
        shape = draw_other_shape(family, np.random.default_rng(1))
        setup = replace(elbow, shape=shape, fixture_shift=(0.001, 0.0, -0.0005))
        assert len(setup.fixtures) == len(setup.body.held)
        extra = yaml.safe_load(extra_text(setup, None))['fixture']
        boxes = extra.get('boxes') or [extra['box']]
        assert len(boxes) == len(setup.fixtures)
        held = yaml.safe_load(scene_text(setup))['held']
        assert len(held) == len(boxes)
        shift = np.array(setup.fixture_shift)
        for stated, box, part in zip(boxes, setup.body.held, held.values(), strict=True):
            low, high = (np.array([stated[axis] for axis in 'xyz']) - shift[:, None]).T
            held_low, held_high = np.array([part['box'][axis] for axis in 'xyz']).T
            assert held_low == pytest.approx(np.array(box)[:, 0], abs=2e-6)
            assert held_high == pytest.approx(np.array(box)[:, 1], abs=2e-6)
            assert low[1:] == pytest.approx(np.array(box)[1:, 0] - setup.rim)
            assert high[1:] == pytest.approx(np.array(box)[1:, 1] + setup.rim)
            # The body comes out of a block a little before it is free.
            assert low[0] - box[0][0] < 0.3 * setup.rim
            assert box[0][1] - high[0] < 0.3 * setup.rim


def test_noise_grows_with_the_distance() -> None:
    for name, power in (('l515', 1.0), ('d405', 2.0), ('itof', 1.0)):
        usual = DRAWN[name](np.random.default_rng(1), 0.34)
        near, far = (at_distance(usual, distance, 0.0005) for distance in (0.34, 0.68))
        assert near.noise == pytest.approx(usual.noise)
        assert far.noise == pytest.approx(2.0**power * usual.noise)
        assert far.step == pytest.approx(usual.step * (4.0 if name == 'd405' else 1.0))
        assert far.bias == 0.0005


def test_the_scene_says_what_is_known(elbow: OtherSetup) -> None:
    scene = yaml.safe_load(scene_text(elbow))
    assert ('smooth_error' in scene['sensor']) == (elbow.smooth_stated is not None)
    assert scene['sensor']['noise'] == pytest.approx(elbow.sensor.noise)
    young = scene['regions']['body']['youngs_modulus']
    assert young['start'] == elbow.start_modulus != elbow.youngs_modulus
    assert young['min'] < elbow.youngs_modulus < young['max']


def test_sizes_are_shares_of_the_free_length(elbow: OtherSetup) -> None:
    free = elbow.body.free
    assert wanted_change(elbow, 1) == pytest.approx(np.clip(0.03 * free, 0.0015, 0.025))
    assert wanted_change(elbow, 2) == pytest.approx(np.clip(0.08 * free, 0.0015, 0.025))
    assert scaled({'a': (1.0, -2.0), 'b': 3.0}, ('a',), 2.0) == {'a': (2.0, -4.0), 'b': 3.0}


def test_sizes_are_those_that_change_what_is_seen_so_much(elbow: OtherSetup) -> None:
    bias, change = sized(
        BY_KEY_34['depth_bias_by_region/gradual'],
        wanted_change(elbow, 2),
        elbow,
        np.random.default_rng(2),
    )
    assert abs(bias['region_bias']) == pytest.approx(1e3 * change, rel=0.01)
    form, wanted = BY_KEY_34['clamp_offset/turns on'], wanted_change(elbow, 2)
    turned, change = sized(form, wanted, elbow, np.random.default_rng(2))
    # All turns about the middle of what is held, most at the far end.
    reach = 1.1 * elbow.body.free
    assert np.deg2rad(np.linalg.norm(turned['clamp_turn'])) * reach > change


@pytest.mark.parametrize(
    'key', ['camera_offset/library', 'depth_bias_by_region/gradual', 'clamp_offset/turns on']
)
def test_effects_change_what_is_seen_by_as_much_as_wanted(elbow: OtherSetup, key: str) -> None:
    wanted = wanted_change(elbow, 2)
    _, change = sized(BY_KEY_34[key], wanted, elbow, np.random.default_rng(2))
    assert change == pytest.approx(wanted, rel=0.05)


def test_a_plane_lifts_a_body_that_hangs_above_it_else(low: OtherSetup) -> None:
    form, random = BY_KEY_34['contact_plane/library'], np.random.default_rng(3)
    setup, changes, change = laid(low, form.draw(low, random), wanted_change(low, 1), random)
    assert change == pytest.approx(wanted_change(low, 1), rel=0.15)
    faults = Faults(**changes)
    specimen = make_specimen(setup, faults, 0.8)
    normal = np.array(faults.contact_normal)
    rests = rests_of(specimen, setup, faults)
    for rest, view in zip(rests, setup.observations, strict=True):
        heights = applied(view.world_from_object, rest) @ normal - changes['contact_height']
        assert heights.min() > -0.0003
        assert heights[specimen.shares == 0.0].min() > 0.001
    for old, new in zip(low.observations, setup.observations, strict=True):
        # Moved up or down alone, the stated pose by as much.
        moved = new.world_from_object - old.world_from_object
        assert moved[[0, 2], 3] == pytest.approx(0.0)
        assert new.stated - old.stated == pytest.approx(moved)


def test_labels_tell_of_the_rig(elbow: OtherSetup) -> None:
    case = next(case for case in CASES if case.kind == 'clean' and case.family == 'bridge')
    setup, effects, faults = draw_case(case)
    label = label_of(case, setup, effects, faults, np.zeros(3))
    assert label['rubber']['law'] == case.law
    assert label['effects'] == []
    assert len(label['poses']) == case.poses
    told = rig_label(elbow)
    assert told['free_length_mm'] == pytest.approx(1e3 * elbow.body.free, abs=1e-3)
    assert told['largest_changes_mm'] == []


def test_the_set_is_none_of_the_earlier_ones_and_wants_forms(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert 'thirtyfourth' not in FORM_SETS
    with pytest.raises(ValueError, match='thirtyfourth'):
        list_form_cases('thirtyfourth')
    with pytest.raises(SystemExit):
        main(['--set', 'thirtyfourth', '--out', str(tmp_path)])
    assert 'add --forms' in capsys.readouterr().err


def test_the_seal_has_a_line_for_each_case() -> None:
    names = [line.split('  ')[1] for line in SEAL.read_text().splitlines()]
    assert names == sorted(f'{case.id}.json' for case in CASES)
    assert {len(line.split('  ')[0]) for line in SEAL.read_text().splitlines()} == {64}
