# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the twenty-first set do what their labels say."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.blind_contact import check_pushes, moves_and_dents
from support.blind_derivatives import check_derivatives
from support.blind_draws import draw_faults, STEPS
from support.blind_rests import clamp_motion_and_load, COARSE, rest_of
from support.blind_views import with_and_without

from benchmarks.blind.air_table import air_table
from benchmarks.blind.contact import contact_laws
from benchmarks.blind.fattening import sample_grid
from benchmarks.blind.faults import Faults
from benchmarks.blind.flare import flared_share
from benchmarks.blind.forms import BY_KEY
from benchmarks.blind.laying import lay_on_plane
from benchmarks.blind.moduli import soaked_share
from benchmarks.blind.observe import jostled, true_camera, true_rendering
from benchmarks.blind.ooze import oozed_masses
from benchmarks.blind.paint import FIXTURE, HALFWAY, Paint, ROOT, TIP
from benchmarks.blind.rest_shape import stress_free_nodes
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import draw_setup, GRAVITY, Setup
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.surface import body_triangles


@pytest.mark.parametrize('pose', range(4))
def test_a_lump_is_all_where_it_has_oozed_to(setup: Setup, plain: Specimen, pose: int) -> None:
    faults, view = draw_faults('added_mass/oozing', setup), setup.observations[pose]
    found = oozed_masses(plain.body.masses, plain.shares, setup, view, faults)
    assert found.sum() == pytest.approx(1e-3 * faults.added_mass)
    middle = float(found @ plain.shares / found.sum())
    assert middle == pytest.approx(faults.mass_places[pose], abs=0.03)
    assert np.ptp(plain.shares[found > 0.0]) < 0.3


@pytest.mark.parametrize('family', ['beam', 'arch', 'fin', 'tee'])
def test_a_lump_oozes_to_where_its_body_points_down(family: str) -> None:
    drawn = draw_setup(family, is_sealed=True, poses=4, random=np.random.default_rng(3))
    places = np.array(draw_faults('added_mass/oozing', drawn).mass_places)
    assert places.min() >= 0.3
    assert places.max() <= 0.95
    downs = np.array([-pose.world_from_object[1, 0] for pose in drawn.observations[1:]])
    steps = np.diff(places)
    # By one rate, but for where an end stops it.
    goes_on = (places[1:] < 0.95) & (places[1:] > 0.3)
    rates = steps[goes_on] / downs[goes_on]
    assert goes_on.sum() >= 2
    assert rates.min() > 0.29
    assert rates.max() < 0.46
    assert np.all(steps * downs >= 0.0)


def test_oil_falls_by_the_exponential_from_a_surface_inwards() -> None:
    share = np.array([0.05, 0.2, 0.2, 0.2, 1.0])
    below = np.array([0.0, -0.001, 0.0, 0.003, 0.006])
    expected = [0.0, 1.0, 1.0, np.exp(-1.0), np.exp(-2.0)]
    assert soaked_share(share, below, 0.1, 0.003) == pytest.approx(expected)


def test_a_soaked_body_is_soft_near_its_surface(setup: Setup) -> None:
    faults = draw_faults('stiffness_contrast/soaked', setup)
    soft, whole = (make_specimen(setup, each) for each in (faults, Faults()))
    harder = np.log(np.asarray(soft.body.numbers.shear / whole.body.numbers.shear))
    places = whole.body.quadrature.values @ whole.mesh.nodes[whole.mesh.cells]
    share = (places[..., 0] - setup.shape.clamp) / (setup.shape.length - setup.shape.clamp)
    half = 0.5 * np.array(setup.shape.section)
    below = (half - np.abs(places[..., 1:])).min(axis=-1)
    expected = faults.contrast * np.exp(-below / faults.contrast_depth)
    inside, dry = share > faults.contrast_at + 0.05, share < faults.contrast_at - 0.05
    assert harder[inside] == pytest.approx(expected[inside], abs=1e-6)
    assert harder[dry] == pytest.approx(0.0, abs=1e-9)
    assert harder.min() < -0.5


@pytest.mark.parametrize('pose', range(4))
def test_hot_glue_gives_way_more_from_pose_to_pose(
    setup: Setup, plain: Specimen, pose: int
) -> None:
    faults = draw_faults('compliant_clamp/hot glue', setup)
    motion, load = clamp_motion_and_load(setup, plain, faults, pose)
    assert motion[:3] == pytest.approx(0.0, abs=1e-6)
    given = faults.clamp_compliance * faults.clamp_shares[pose] * load[3:]
    assert motion[3:] == pytest.approx(given, abs=2e-5)
    logs = np.log(faults.clamp_shares)
    assert faults.clamp_shares[-1] == 1.0
    assert np.diff(logs) == pytest.approx(np.full(3, logs[-1] - logs[-2]), abs=2e-3)
    assert 0.4 < logs[-1] - logs[-2] < 0.8


def test_a_leash_draws_a_holder_to_one_place_of_the_room(setup: Setup) -> None:
    scatter = np.array(draw_faults('clamp_offset/leashed', setup).clamp_scatter)
    shifts, turns = 1e-3 * scatter[:, :3], np.deg2rad(scatter[:, 3:])
    # What comes to the middle of what is held, and what that turns its outer end by.
    assert turns[:, 0] == pytest.approx(0.0, abs=1e-9)
    ways = shifts / np.linalg.norm(shifts, axis=1)[:, None]
    moments = np.cross([-1.0, 0.0, 0.0], ways)
    rate = float((turns * moments).sum() / np.square(moments).sum())
    assert rate > 0.0
    assert turns == pytest.approx(rate * moments, abs=1e-4)
    # All lines along which it is drawn meet in one place.
    end = np.array([[-0.02, 0.0, 0.0]])
    starts, lines = [], []
    for pose, way in zip(setup.observations, ways, strict=True):
        starts.append(applied(pose.world_from_object, end)[0])
        lines.append(pose.world_from_object[:3, :3] @ way)
    across = [np.eye(3) - np.outer(line, line) for line in lines]
    anchor = np.linalg.solve(
        sum(across), sum(one @ start for one, start in zip(across, starts, strict=True))
    )
    for start, line in zip(starts, lines, strict=True):
        away = anchor - start
        assert away @ line == pytest.approx(np.linalg.norm(away), rel=1e-4)
    assert 0.3 < np.linalg.norm(anchor) < 0.8
    way = setup.shape.length - 0.5 * setup.shape.clamp
    assert np.linalg.norm(turns, axis=1).max() * way == pytest.approx(0.011, rel=0.16)


@pytest.fixture(scope='module')
def on_air(setup: Setup) -> tuple[Setup, Faults]:
    """A set-up whose body hovers in the first pose, and the table."""
    return lay_on_plane(
        setup, draw_faults('contact_plane/hovering', setup), np.random.default_rng(1)
    )


def test_air_lifts_a_tip_that_does_not_touch_the_table(
    on_air: tuple[Setup, Faults], plain: Specimen
) -> None:
    laid, faults = on_air
    moves, dents = moves_and_dents(laid, plain, faults)
    assert 0.007 < moves[0] < 0.013
    assert moves[0] > moves[2] > 0.001
    # It is felt a little from afar.
    assert max(moves[1], moves[3]) < 2e-4
    assert abs(dents[0]) < 0.003


@pytest.mark.parametrize('step', STEPS)
def test_air_pushes_by_its_energy(
    on_air: tuple[Setup, Faults], plain: Specimen, step: float
) -> None:
    laid, faults = on_air
    check_pushes(laid, plain, faults, step)
    # Beyond four lengths as well, where it goes on as stiff.
    dents = 0.002 * np.array([-1.5, 0.0, 3.0, 3.9, 6.0])
    normal = np.array([0.0, 0.6, 0.8])
    places = np.outer(0.03 - dents, normal) + np.array([0.02, 0.0, 0.0])
    pressed = air_table(normal, 0.03, np.array([2.0, 2.0, 0.5, 0.2, 0.2]), 0.002)
    stiff = check_derivatives(pressed, places, step=step, share=1e-4)
    assert stiff.any(axis=1).all()


def test_air_presses_by_the_exponential_of_the_height(
    on_air: tuple[Setup, Faults], plain: Specimen
) -> None:
    laid, faults = on_air
    assert faults.contact_height is not None
    (law,) = contact_laws(plain.areas, plain.shares, laid.observations[0], faults)
    world = laid.observations[0].world_from_object
    # All nodes at one height.
    up = world[1, :3]
    flat = plain.mesh.nodes - np.outer(plain.mesh.nodes @ up + world[1, 3], up)
    for high in (-3.0, -1.0, 0.0, 1.0, 4.0):
        places = flat + (faults.contact_height + high * faults.contact_bend) * up
        pressure = faults.contact_pressure * np.exp(-high)
        assert -law(places).gradient @ up == pytest.approx(pressure * plain.areas, rel=1e-6)


def test_a_fixture_flares_over_what_is_beside_it(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    faults = draw_faults('depth_affine/flared', setup)
    for pose in (0, 3):
        view, right, there = with_and_without(plain, setup, faults, pose, rests[pose])
        errors = np.full(there.shape, np.nan)
        errors[there] = (view.depth[there] - right.depth[there]) / (1e-3 * faults.depth_bias)
        grid = sample_grid(errors)
        jaws = np.argwhere(sample_grid(right.labels) == FIXTURE)
        assert grid[tuple(jaws.T)] == pytest.approx(1.0, abs=1e-6)
        seen = np.argwhere(np.isfinite(grid))[::997]
        away = np.array([np.linalg.norm(jaws - place, axis=1).min() for place in seen]) / 3.0
        expected = np.exp(-away / faults.depth_width)
        assert grid[tuple(seen.T)] == pytest.approx(expected, abs=1e-6)
        assert 1e-3 * abs(faults.depth_bias) == pytest.approx(0.011, rel=0.16)


def test_nothing_flares_where_no_fixture_is_seen(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    view = true_rendering(plain, setup, setup.observations[0], Faults(), rests[0])
    bare = replace(view, labels=np.where(view.labels == FIXTURE, ROOT, view.labels))
    assert not flared_share(bare, 40.0).any()


def test_two_paints_lie_one_beyond_the_other(setup: Setup, plain: Specimen) -> None:
    painted = body_triangles(plain.mesh, plain.mesh.nodes, plain.shares, Paint(0.7, second=0.25))
    plainly = body_triangles(plain.mesh, plain.mesh.nodes, plain.shares, Paint(0.7))
    assert np.array_equal(painted.labels == TIP, plainly.labels == TIP)
    free = setup.shape.length - setup.shape.clamp
    share = (painted.corners[..., 0].mean(axis=1) - setup.shape.clamp) / free
    sure = (np.abs(share - 0.25) > 0.05) & (np.abs(share - 0.7) > 0.05)
    expected = np.where(share > 0.7, TIP, np.where(share > 0.25, HALFWAY, ROOT))
    assert np.array_equal(painted.labels[sure], expected[sure])


def test_two_paints_err_to_either_side(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    faults = draw_faults('depth_bias_by_region/two-tone', setup)
    bias, back = 1e-3 * faults.region_bias, faults.region_back
    for pose in (0, 2):
        view, right, there = with_and_without(plain, setup, faults, pose, rests[pose])
        errors = view.depth[there] - right.depth[there]
        levels = np.array([0.0, bias, -back * bias])
        nearest = np.abs(errors[:, None] - levels)
        assert nearest.min(axis=1) == pytest.approx(0.0, abs=1e-9)
        assert all(np.mean(nearest.argmin(axis=1) == level) > 0.05 for level in range(3))
        assert not errors[right.labels[there] == FIXTURE].any()
    assert abs(bias) == pytest.approx(0.010, rel=0.16)


def test_a_head_that_hunts_turns_to_and_fro_and_calms_down(setup: Setup, plain: Specimen) -> None:
    faults = draw_faults('camera_offset/hunting', setup)
    assert faults.camera_foot is not None
    stored = np.linalg.inv(setup.depth_from_world)
    foot = stored[:3, :3] @ np.array(faults.camera_foot) + stored[:3, 3]
    turns = []
    for pose in setup.observations:
        found = np.linalg.inv(true_camera(plain, setup, jostled(setup, pose, faults)))
        turn = Rotation.from_matrix(found[:3, :3] @ stored[:3, :3].T)
        assert found[:3, 3] == pytest.approx(foot + turn.apply(stored[:3, 3] - foot), abs=1e-9)
        turns.append(np.rad2deg(turn.as_rotvec()))
    assert np.linalg.norm(turns[0]) == pytest.approx(1.75, rel=0.16)
    calms = [-float(after @ before / (before @ before)) for before, after in pairwise(turns)]
    assert calms == pytest.approx(np.full(3, calms[0]), abs=2e-3)
    assert 0.7 < calms[0] < 0.9
    assert np.linalg.norm(np.cross(turns[0], turns[1:]), axis=1) == pytest.approx(0.0, abs=1e-3)


def test_an_arm_that_brakes_pushes_along_the_way_it_came(setup: Setup) -> None:
    faults = draw_faults('gravity_tilt/braking', setup)
    pushes = np.array(faults.tilt_pushes)
    middle = np.array([0.5 * setup.shape.length, 0.0, 0.0, 1.0])
    places = np.array([(pose.world_from_object @ middle)[:3] for pose in setup.observations])
    steps = np.diff(places, axis=0)
    assert not pushes[0].any()
    rate = float((pushes[1:] * steps).sum() / np.square(steps).sum())
    assert rate > 0.0
    assert pushes[1:] == pytest.approx(rate * steps, abs=2e-4)
    assert 0.1 < np.linalg.norm(pushes, axis=1).max() / GRAVITY < 1.0


def test_what_an_arm_draws_by_is_felt_as_gravity_is(setup: Setup, plain: Specimen) -> None:
    # A push that turns gravity about z, and leaves it as large.
    angle = np.deg2rad(8.0)
    push = (GRAVITY * np.sin(angle), GRAVITY * (1.0 - np.cos(angle)), 0.0)
    faults = Faults(tilt_form='braking', tilt_pushes=((0.0, 0.0, 0.0), push, push, push))
    for pose, expected in ((0, Faults()), (1, Faults(gravity_tilt=(0.0, 8.0)))):
        found, tilted = (rest_of(setup, each, pose) for each in (faults, expected))
        assert found == pytest.approx(tilted, abs=1e-8)


def test_a_jumbled_body_is_bent_its_own_way_in_each_part(setup: Setup) -> None:
    shape = setup.shape
    free = shape.length - shape.clamp
    nodes = np.zeros((3001, 3))
    nodes[:, 0] = shape.clamp + np.linspace(0.0, 1.0, 3001) * free
    shares = ((1.5, 0.0), (0.0, -2.0), (-1.0, 1.0))
    faults = Faults(rest_curvature=(0.0, 2.0), curvature_form='jumbled', curvature_parts=shares)
    steps = np.diff(stress_free_nodes(nodes, shape, faults), axis=0)
    assert np.linalg.norm(steps, axis=1).sum() == pytest.approx(free, rel=1e-6)
    ways = steps / np.linalg.norm(steps, axis=1)[:, None]
    ends = [ways[0], ways[1000], ways[2000], ways[-1]]
    for one, other, bends in zip(ends, ends[1:], shares, strict=False):
        turned = np.arccos(np.clip(one @ other, -1.0, 1.0))
        assert turned == pytest.approx(2.0 * np.hypot(*bends) * free / 3.0, rel=5e-3)
    # The first part as an arc about z, the second at right angles to that.
    first = 2.0 * 1.5 * free / 3.0
    assert ends[1] == pytest.approx([np.cos(first), np.sin(first), 0.0], abs=1e-3)
    assert abs((ends[2] - ends[1])[2]) == pytest.approx(np.sin(2.0 * 2.0 * free / 3.0), rel=1e-2)


@pytest.mark.parametrize('seed', range(6))
def test_the_tip_of_a_jumbled_body_is_as_far_off_as_that_of_an_arc(
    setup: Setup, seed: int
) -> None:
    changes = BY_KEY['rest_curvature/jumbled'].draw(1, setup, np.random.default_rng(seed))
    shape, faults = setup.shape, Faults(**changes)
    line = np.zeros((71, 3))
    line[:, 0] = shape.clamp + np.linspace(0.0, 1.0, 71) * (shape.length - shape.clamp)
    arc = replace(faults, curvature_form='arc', curvature_parts=())
    found, expected = (stress_free_nodes(line, shape, each) for each in (faults, arc))
    away = np.linalg.norm((found - expected)[:, 1:], axis=1)
    tip = float(np.linalg.norm(expected[-1, 1:]))
    assert away[-1] < 0.06 * tip
    assert away.max() > 0.15 * tip


@pytest.mark.parametrize('family', ['arch', 'fin', 'tee'])
def test_bodies_of_other_shapes_are_made_of_soaked_rubber_too(family: str) -> None:
    drawn = draw_setup(family, is_sealed=True, poses=4, random=np.random.default_rng(3))
    faults = draw_faults('stiffness_contrast/soaked', drawn)
    soft, whole = (make_specimen(drawn, each, COARSE) for each in (faults, Faults()))
    harder = np.log(np.asarray(soft.body.numbers.shear / whole.body.numbers.shear))
    assert faults.contrast - 1e-9 <= harder.min() < 0.3 * faults.contrast
    assert harder.max() <= 1e-12
