# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effects in other forms than the library's, and worlds where everything is a little off."""

import json

import numpy as np
import pytest
import yaml

from benchmarks.blind.amplitudes import LIBRARY
from benchmarks.blind.cases import FORM_SETS, list_form_cases
from benchmarks.blind.contact import contact_laws
from benchmarks.blind.faults import Faults
from benchmarks.blind.forms import FORMS, off_the_truth
from benchmarks.blind.generator import draw_case
from benchmarks.blind.labels import label_of
from benchmarks.blind.observe import true_rendering
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.rest_shape import stress_free_nodes
from benchmarks.blind.scene_file import scene_text
from benchmarks.blind.sensor import DRAWN
from benchmarks.blind.setups import draw_setup, Setup
from benchmarks.blind.simulation import make_specimen, settle

COARSE = 0.5


@pytest.fixture(scope='module')
def setup() -> Setup:
    return draw_setup('beam', is_sealed=False, poses=4, random=np.random.default_rng(4))


def _rest(setup: Setup, faults: Faults, pose: int = 0) -> np.ndarray:
    return settle(make_specimen(setup, faults, COARSE), setup, setup.observations[pose], faults)


def _held(setup: Setup, faults: Faults, pose: int = 0) -> np.ndarray:
    return _rest(setup, faults, pose)[make_specimen(setup, faults, COARSE).mesh.held]


def test_sets_share_no_form_and_leave_no_effect_out() -> None:
    names = [form.key for forms in FORMS.values() for form in forms]
    assert len(set(names)) == len(names)
    assert {form.truth for forms in FORMS.values() for form in forms} == set(LIBRARY)


# Drawing this set takes half a minute: sizes of halves that come apart are found by simulation. It
# is drawn whole by the tests of later sets, too.
_LONG = 'nineteenth'


@pytest.mark.parametrize(
    'set_name',
    [pytest.param(own, marks=pytest.mark.slow) if own == _LONG else own for own in FORM_SETS],
)
@pytest.mark.slow
def test_cases_of_forms_can_be_written_down(set_name: str) -> None:
    cases = list_form_cases(set_name)
    assert len({case.id for case in cases}) == len(cases)
    assert {case.sensor for case in cases} == set(DRAWN)
    for case in cases:
        if 'contact_plane' in str(case.effects):
            continue  # Drawing it takes a simulation.
        setup, effects, faults = draw_case(case)
        label = label_of(case, setup, effects, faults, np.zeros(3))
        assert json.loads(json.dumps(label))['sensor'] == case.sensor
        assert yaml.safe_load(scene_text(setup))['pose']['position_std'] > 0.0


def test_scene_states_other_placements_than_the_camera_sees(setup: Setup) -> None:
    errors, stated = [], []
    for seed in range(40):
        world = off_the_truth(setup, 'l515', np.random.default_rng(seed))
        stated.append(world.pose_errors[0] / 0.0003)
        for observation in world.observations:
            assert observation.stated is not None
            apart = np.linalg.inv(observation.world_from_object) @ observation.stated
            errors.append(np.arccos(np.clip((np.trace(apart[:3, :3]) - 1.0) / 2.0, -1.0, 1.0)))
    # Three axes of 0.2 degrees each.
    assert np.sqrt(np.mean(np.square(errors))) == pytest.approx(
        np.sqrt(3.0) * np.deg2rad(0.2), rel=0.1
    )
    assert set(np.round(stated, 9)) == {0.5, 1.0, 2.0}


def test_uneven_clamp_turns_about_one_axis_and_a_sliding_one_not_at_all(setup: Setup) -> None:
    plain = _held(setup, Faults())
    moved = {
        form: _held(setup, Faults(clamp_form=form, clamp_compliance=amount)) - plain
        for form, amount in (('uneven', 1.5), ('shear', 0.005), ('turn', 1.5))
    }
    assert np.ptp(moved['shear'], axis=0).max() < 1e-12
    assert np.linalg.norm(moved['shear'][0]) > 1e-4
    # Turned about y nothing moves along y.
    assert np.abs(moved['uneven'][:, 1]).max() < 1e-9
    assert np.abs(moved['turn'][:, 1]).max() > 1e-6


def test_steady_forces_are_tilts_to_first_order_in_the_frame_they_are_fixed_to(
    setup: Setup,
) -> None:
    tilts = {
        form: [
            _rest(setup, Faults(gravity_tilt=(0.5, -0.4), tilt_form=form), pose) for pose in (0, 1)
        ]
        for form in ('tilt', 'side_force', 'rig_force')
    }
    clean = [_rest(setup, Faults(), pose) for pose in (0, 1)]
    apart = {
        form: [np.abs(found[pose] - tilts['tilt'][pose]).max() for pose in (0, 1)]
        for form, found in tilts.items()
    }
    moves = [np.abs(tilts['tilt'][pose] - clean[pose]).max() for pose in (0, 1)]
    # In the first pose all are the same to second order; rolled, what turned with the rig is not.
    assert max(apart['side_force']) < 0.02 * min(moves)
    assert apart['rig_force'][0] < 0.02 * moves[0]
    assert apart['rig_force'][1] > 0.3 * moves[1]


def _given_way(setup: Setup, form: str) -> tuple[np.ndarray, np.ndarray]:
    """Return how far a plain clamp gives way by pose, the least first, and a form's shares."""
    plain, turned, own = (
        [_held(setup, Faults(clamp_form=kind, clamp_compliance=give), pose) for pose in range(4)]
        for kind, give in (('turn', 0.0), ('turn', 1.0), (form, 1.0))
    )
    sizes = [
        np.array([np.abs(a - b).max() for a, b in zip(moved, plain, strict=True)])
        for moved in (turned, own)
    ]
    order = np.argsort(sizes[0])
    return sizes[0][order], (sizes[1] / sizes[0])[order]


@pytest.mark.slow
def test_a_clamp_that_hardens_gives_way_less_than_in_proportion(setup: Setup) -> None:
    sizes, shares = _given_way(setup, 'hardening')
    assert sizes[-1] > 1.2 * sizes[0], 'poses ask unlike moments of it'
    assert shares[-1] < shares[0]


def test_a_clamp_that_softens_gives_way_more_than_in_proportion(setup: Setup) -> None:
    _, shares = _given_way(setup, 'softening')
    assert shares[-1] > shares[0]


def test_a_push_on_the_outer_part_leaves_the_inner_one_to_the_moment(setup: Setup) -> None:
    specimen = make_specimen(setup, Faults(), COARSE)
    for pose in (0, 1):
        tilted, pushed = (
            _rest(setup, Faults(gravity_tilt=(0.5, -0.4), tilt_form=form), pose)
            for form in ('tilt', 'outer_push')
        )
        clean = _rest(setup, Faults(), pose)
        free = specimen.shares > 0.0
        one, other = (tilted - clean)[free].ravel(), (pushed - clean)[free].ravel()
        alike = one @ other / (np.linalg.norm(one) * np.linalg.norm(other))
        assert 0.9 < alike < 1.0 - 1e-6


def test_a_root_that_is_bent_at_rest_carries_a_straight_outer_half(setup: Setup) -> None:
    bent = make_specimen(setup, Faults(rest_curvature=(2.0, 0.0), curvature_form='root'), COARSE)
    lattice = bent.mesh.lattice
    middle = 0.5 * (setup.shape.clamp + setup.shape.length)
    outer = lattice[:, 0] > middle + 1e-9
    stress_free = stress_free_nodes(
        bent.mesh.nodes, setup.shape, Faults(rest_curvature=(2.0, 0.0), curvature_form='root')
    )
    ways = np.column_stack([np.ones(outer.sum()), lattice[outer]])
    left = np.linalg.lstsq(ways, stress_free[outer], rcond=None)[1]
    whole = np.column_stack([np.ones(len(lattice)), lattice])
    bent_all = np.linalg.lstsq(whole, stress_free, rcond=None)[1]
    assert np.sqrt(left.max() / outer.sum()) < 0.1 * np.sqrt(bent_all.max() / len(lattice))


def test_a_shelf_carries_the_outer_half_alone(setup: Setup) -> None:
    clean = _rest(setup, Faults())
    world = setup.observations[0].world_from_object
    heights = clean @ world[:3, :3].T[:, 1] + world[1, 3]
    faults = Faults(contact_height=float(heights.min()) + 0.004, contact_form='shelf')
    specimen = make_specimen(setup, faults, COARSE)
    (law,) = contact_laws(specimen.areas, specimen.shares, setup.observations[0], faults)
    deep = law(clean - 0.05 * world[1, :3])
    pushed = np.abs(deep.gradient).max(axis=1) > 0.0
    assert pushed.any()
    assert specimen.shares[pushed].min() > 0.5


def test_a_push_that_grows_along_the_body_bends_it_as_a_tilt_does_in_every_pose(
    setup: Setup,
) -> None:
    for pose in (0, 1):
        tilted, pushed = (
            _rest(setup, Faults(gravity_tilt=(0.5, -0.4), tilt_form=form), pose)
            for form in ('tilt', 'growing')
        )
        clean = _rest(setup, Faults(), pose)
        one, other = (tilted - clean).ravel(), (pushed - clean).ravel()
        assert one @ other > 0.95 * np.linalg.norm(one) * np.linalg.norm(other)
        assert 0.5 < np.linalg.norm(other) / np.linalg.norm(one) < 0.95


def test_a_clamp_that_slips_once_is_where_it_should_be_before(setup: Setup) -> None:
    slip = Faults(clamp_late=True, clamp_shift=(2.0, -1.0, 0.5))
    moves = [_held(setup, slip, pose) - _held(setup, Faults(), pose) for pose in range(4)]
    assert [bool(np.abs(move).max() > 1e-3) for move in moves] == [False, False, True, True]


def test_an_error_by_disparity_grows_with_the_square_of_the_depth(setup: Setup) -> None:
    view, errors = setup.observations[0], {}
    rest = _rest(setup, Faults())
    for form in ('affine', 'disparity'):
        specimen = make_specimen(setup, Faults(), COARSE)
        plain, off = (
            true_rendering(specimen, setup, view, Faults(depth_bias=bias, depth_form=form), rest)
            for bias in (0.0, 3.0)
        )
        seen = np.isfinite(plain.depth)
        assert np.array_equal(np.isfinite(off.depth), seen)
        depths = plain.depth[seen]
        errors[form] = off.depth[seen] - depths
    assert np.allclose(errors['affine'], 0.003)
    near, far = np.argmin(depths), np.argmax(depths)
    expected = (depths[far] / depths[near]) ** 2
    assert errors['disparity'][far] / errors['disparity'][near] == pytest.approx(expected)
    assert expected > 1.05


def test_errors_of_depth_run_across_the_image_or_settle(setup: Setup) -> None:
    specimen = make_specimen(setup, Faults(), COARSE)
    rests = [_rest(setup, Faults(), pose) for pose in range(2)]

    def errors(form: str, pose: int) -> tuple[np.ndarray, np.ndarray]:
        view = setup.observations[pose]
        plain, off = (
            true_rendering(
                specimen, setup, view, Faults(depth_bias=bias, depth_form=form), rests[pose]
            )
            for bias in (0.0, 4.0)
        )
        seen = np.isfinite(plain.depth)
        _, columns, _ = np.nonzero(seen)
        found = off.depth[seen] - plain.depth[seen]
        return found, columns + plain.column - setup.camera.cx

    found, columns = errors('ramp', 0)
    assert np.allclose(found, 0.004 * (0.7 + columns / setup.camera.width), atol=1e-12)
    for pose, expected in ((0, 0.004), (1, 0.0028)):
        assert np.allclose(errors('settling', pose)[0], expected, atol=1e-12)


def test_a_coat_reaches_to_the_tip(setup: Setup) -> None:
    specimen = make_specimen(
        setup, Faults(added_mass=3.0, added_mass_at=0.5, mass_form='coat'), 1.0
    )
    assert specimen.added.sum() == pytest.approx(0.003, rel=1e-12)
    assert specimen.added @ specimen.shares / 0.003 == pytest.approx(0.75, abs=0.06)


def test_two_rings_have_the_mass_of_one(setup: Setup) -> None:
    faults = Faults(added_mass=3.0, added_mass_at=0.8, mass_form='two')
    specimen = make_specimen(setup, faults, 1.0)
    assert specimen.added.sum() == pytest.approx(0.003, rel=1e-12)
    outer = specimen.added[specimen.shares > 0.6].sum()
    assert 0.3 < outer / 0.003 < 0.7
    assert specimen.added[np.abs(specimen.shares - 0.6) < 0.08].sum() < 1e-12


@pytest.mark.parametrize('form', ['ring', 'smear', 'point'])
def test_a_mass_has_its_weight_in_every_form(setup: Setup, form: str) -> None:
    faults = Faults(added_mass=3.0, added_mass_at=0.6, mass_form=form)
    specimen = make_specimen(setup, faults, 1.0)
    assert specimen.added.sum() == pytest.approx(0.003, rel=1e-12)
    assert specimen.added @ specimen.shares / 0.003 == pytest.approx(0.6, abs=0.06)
    off_center = specimen.added @ specimen.mesh.nodes[:, 1] / 0.003
    expected = 0.4 * setup.shape.section[0] if form == 'point' else 0.0
    assert off_center == pytest.approx(expected, abs=0.1 * setup.shape.section[0])


def test_errors_of_depth_vary_over_the_image_or_from_pose_to_pose(setup: Setup) -> None:
    clean = {pose: _rest(setup, Faults(), pose) for pose in (0, 3)}
    specimen = make_specimen(setup, Faults(), COARSE)

    def seen(faults: Faults, pose: int) -> Rendering:
        observation = setup.observations[pose]
        return true_rendering(specimen, setup, observation, faults, clean[pose])

    drift = Faults(depth_bias=4.0, depth_form='drift')
    for pose, expected in ((0, 0.001), (3, 0.004)):
        plain = seen(Faults(), pose).depth
        is_hit = np.isfinite(plain)
        assert np.allclose(seen(drift, pose).depth[is_hit] - plain[is_hit], expected, atol=1e-12)
    plain = seen(Faults(), 0)
    is_hit = np.isfinite(plain.depth)
    radial = seen(Faults(depth_bias=4.0, depth_form='radial'), 0)
    apart = radial.depth[is_hit] - plain.depth[is_hit]
    rows, columns, _ = np.nonzero(is_hit)
    away = np.hypot(rows + plain.row - setup.camera.cy, columns + plain.column - setup.camera.cx)
    assert np.allclose(apart, 0.004 * (away / 240.0) ** 2, atol=1e-12)


def test_twisted_body_is_twisted_when_nothing_pulls_on_it(setup: Setup) -> None:
    faults = Faults(rest_curvature=(3.0, 4.0), curvature_form='twist')
    weightless = Faults()
    specimen = make_specimen(setup, faults, COARSE)
    plain = make_specimen(setup, weightless, COARSE)
    assert specimen.body.quadrature.volumes.sum() == pytest.approx(
        plain.body.quadrature.volumes.sum(), rel=1e-3
    )
    rest = _rest(setup, faults)
    tip = specimen.mesh.lattice[:, 0] > setup.shape.length - 1e-9
    across = rest[tip] - rest[tip].mean(axis=0)
    before = _rest(setup, weightless)[tip]
    before = before - before.mean(axis=0)
    spread = np.linalg.svd(across.T @ before)
    turn = spread[0] @ spread[2]
    angle = np.arccos(np.clip((np.trace(turn) - 1.0) / 2.0, -1.0, 1.0))
    assert angle == pytest.approx(5.0 * (setup.shape.length - setup.shape.clamp), rel=0.15)


@pytest.mark.parametrize('kind', sorted(DRAWN))
def test_sensors_are_drawn_anew(kind: str) -> None:
    one, other = (DRAWN[kind](np.random.default_rng(seed), 0.35) for seed in (0, 1))
    assert one.kind == kind
    assert one.bias != other.bias
    assert 0.0001 < one.bias < 0.0006
