# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the twentieth set do what their labels say."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.blind_contact import check_pushes, moves_and_dents
from support.blind_derivatives import check_derivatives
from support.blind_draws import draw_faults, STEPS
from support.blind_rests import clamp_motion_and_load
from support.blind_views import with_and_without

from benchmarks.blind.contact import contact_laws
from benchmarks.blind.faults import Faults
from benchmarks.blind.felt import felt
from benchmarks.blind.flexure import tape_compliance
from benchmarks.blind.laying import lay_on_plane
from benchmarks.blind.moduli import overbent_share
from benchmarks.blind.observe import jostled, true_camera
from benchmarks.blind.paint import Paint, tip_part
from benchmarks.blind.rest_shape import stress_free_nodes
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import draw_setup, Setup
from benchmarks.blind.simulation import make_specimen, settle
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.sponge import sponge_masses
from benchmarks.blind.surface import body_triangles


@pytest.mark.parametrize('pose', range(4))
def test_the_water_of_a_sponge_is_less_where_that_is_higher(
    setup: Setup, plain: Specimen, pose: int
) -> None:
    faults, view = draw_faults('added_mass/sponge', setup), setup.observations[pose]
    masses, shares = plain.body.masses, plain.shares
    found = sponge_masses(masses, shares, setup, view, faults)
    assert found.sum() == pytest.approx(1e-3 * faults.added_mass)
    inner, outer = faults.mass_stops
    wet = found > 0.0
    assert np.array_equal(wet, (shares > inner) & (shares < outer) & (masses > 0.0))
    # A straight beam rises evenly.
    free = setup.shape.length - setup.shape.clamp
    rise = free * shares[wet] * view.world_from_object[1, 0]
    logs = np.log(found[wet] / masses[wet]) + rise / faults.mass_suction
    assert logs == pytest.approx(logs[0], abs=1e-9)


def test_what_was_overbent_is_soft_by_its_strain() -> None:
    share = np.array([0.0, 0.15, 0.3, 0.65, 1.0])
    moment = np.array([0.0, 0.5, 1.0, 0.5, 0.0])
    for height in (-1.0, 0.0, 0.4, 1.0):
        found = overbent_share(share, np.full(5, height), 0.3)
        assert found == pytest.approx(abs(height) * moment)
    assert not overbent_share(share, np.ones(5), 0.0).any()


def test_an_overbent_body_is_soft_where_it_was_strained(setup: Setup) -> None:
    faults = draw_faults('stiffness_contrast/overbent', setup)
    soft, whole = (make_specimen(setup, each) for each in (faults, Faults()))
    harder = np.log(np.asarray(soft.body.numbers.shear / whole.body.numbers.shear))
    places = whole.body.quadrature.values @ whole.mesh.nodes[whole.mesh.cells]
    share = (places[..., 0] - setup.shape.clamp) / (setup.shape.length - setup.shape.clamp)
    height = np.abs(places[..., 2]) / (0.5 * setup.shape.section[1])
    at = faults.contrast_at
    expected = faults.contrast * height * np.interp(share, [0.0, at, 1.0], [0.0, 1.0, 0.0])
    # Shares are told at nodes: in the cells beside the clamp alone is that another thing.
    beyond = share > 0.05
    assert harder[beyond] == pytest.approx(expected[beyond], abs=1e-6)
    assert harder.min() < -0.5


def test_foam_tape_gives_way_at_each_place_by_the_pressure_there() -> None:
    by_turn, edge, count = 0.4, 0.03, 400
    force, moment = np.array([0.4, -0.7, 1.1]), np.array([0.02, 0.05, -0.03])
    given = tape_compliance(by_turn, edge) @ np.concatenate([force, moment])
    ticks = edge * ((np.arange(count) + 0.5) / count - 0.5)
    x, y = (side.ravel() for side in np.meshgrid(ticks, ticks))
    # As places of the tape, seen from the clamp.
    arms = np.stack([x, y, np.full(len(x), -0.5 * edge)], axis=-1)
    moved = given[:3] + np.cross(given[3:], arms)
    stiffness = 12.0 / (by_turn * edge**4) * np.array([1.0 / 3.0, 1.0 / 3.0, 1.0])
    pushes = stiffness * moved * (edge / count) ** 2
    assert pushes.sum(axis=0) == pytest.approx(force, rel=1e-4)
    assert np.cross(arms, pushes).sum(axis=0) == pytest.approx(moment, rel=1e-4)


@pytest.mark.parametrize('pose', range(4))
def test_a_clamp_on_foam_tape_rests_where_that_bears_the_body(
    setup: Setup, plain: Specimen, pose: int
) -> None:
    faults = draw_faults('compliant_clamp/taped', setup)
    motion, load = clamp_motion_and_load(setup, plain, faults, pose)
    compliance = tape_compliance(faults.clamp_compliance, faults.clamp_length)
    given = compliance @ load
    assert motion == pytest.approx(given, abs=2e-5)
    assert np.linalg.norm(motion[3:]) > 0.02


def test_a_greased_slide_creeps_along_its_rail_by_the_weight_along_it(setup: Setup) -> None:
    scatter = np.array(draw_faults('clamp_offset/greased', setup).clamp_scatter)
    assert not scatter[:, 3:].any()
    places = scatter[:, :3]
    _, sizes, ways = np.linalg.svd(places)
    assert sizes[1] < 1e-3 * sizes[0]
    along = places @ ways[0]
    # From pose to pose it goes by one rate.
    steps = np.diff(along, prepend=0.0)
    weights = [-pose.world_from_object[1, :3] @ ways[0] for pose in setup.observations]
    rate = float(steps @ weights) / float(np.square(weights).sum())
    assert rate > 0.0
    assert steps == pytest.approx(rate * np.array(weights), abs=1e-3)
    assert np.abs(along).max() == pytest.approx(10.0, rel=0.16)


@pytest.fixture(scope='module')
def on_felt(setup: Setup) -> tuple[Setup, Faults]:
    """A set-up whose body lies on felt in the first pose, and that felt."""
    return lay_on_plane(setup, draw_faults('contact_plane/felt', setup), np.random.default_rng(1))


def test_felt_bears_a_body_and_lets_its_tip_sink_in(
    on_felt: tuple[Setup, Faults], plain: Specimen
) -> None:
    laid, faults = on_felt
    moves, dents = moves_and_dents(laid, plain, faults)
    assert 0.007 < moves[0] < 0.013
    assert moves[0] > moves[2] > 0.001
    assert moves[1] == moves[3] == 0.0
    assert 0.001 < dents[0] < 0.006


@pytest.mark.parametrize('step', STEPS)
def test_felt_pushes_by_its_energy(
    on_felt: tuple[Setup, Faults], plain: Specimen, step: float
) -> None:
    laid, faults = on_felt
    check_pushes(laid, plain, faults, step)
    # Beyond eight lengths as well, where it goes on as stiff.
    dents = 0.002 * np.array([-0.5, 0.5, 3.0, 7.9, 12.0])
    normal = np.array([0.0, 0.6, 0.8])
    places = np.outer(0.03 - dents, normal) + np.array([0.02, 0.0, 0.0])
    pressed = felt(normal, 0.03, np.array([2.0, 2.0, 1.0, 0.01, 0.01]), 0.002)
    stiff = check_derivatives(pressed, places, step=step, share=1e-4)
    assert stiff.any(axis=1).tolist() == [False, True, True, True, True]


def test_felt_presses_by_the_exponential_of_the_dent(
    on_felt: tuple[Setup, Faults], plain: Specimen
) -> None:
    laid, faults = on_felt
    assert faults.contact_height is not None
    (law,) = contact_laws(plain.areas, plain.shares, laid.observations[0], faults)
    world = laid.observations[0].world_from_object
    # All nodes at one height.
    up = world[1, :3]
    flat = plain.mesh.nodes - np.outer(plain.mesh.nodes @ up + world[1, 3], up)
    for dent in (-0.001, 0.0, 0.5, 2.0, 5.0):
        deep = flat + (faults.contact_height - dent * faults.contact_bend) * up
        pushes = -law(deep).gradient @ up
        pressure = faults.contact_pressure * np.expm1(max(dent, 0.0))
        assert pushes == pytest.approx(pressure * plain.areas, rel=1e-6, abs=1e-12)


def test_a_sunbeam_wanders_over_what_is_seen(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    faults, largest = draw_faults('depth_affine/sunbeam', setup), []
    way = np.deg2rad(faults.depth_slant)
    for pose in range(4):
        view, right, there = with_and_without(plain, setup, faults, pose, rests[pose])
        rows, columns, _ = np.nonzero(there)
        # The beam's middle goes through a place that moves along with it.
        x, y = faults.depth_spot + pose * faults.depth_wander * np.array(
            [np.cos(way), np.sin(way)]
        )
        ahead = columns + right.column - setup.camera.cx - x
        aside = rows + right.row - setup.camera.cy - y
        away = (ahead * np.cos(way) + aside * np.sin(way)) / faults.depth_width
        expected = 1e-3 * faults.depth_bias * np.exp(-(away**2))
        assert view.depth[there] - right.depth[there] == pytest.approx(expected, abs=1e-9)
        largest.append(np.abs(expected).max())
    assert 0.008 < max(largest) < 0.013


def test_what_is_bleached_goes_with_how_a_side_faced_the_sun(
    setup: Setup, plain: Specimen
) -> None:
    faults = Faults(region_from=0.3, region_sun=(0.6, -0.8))
    where = (plain.mesh, plain.mesh.nodes, plain.shares)
    found = body_triangles(*where, Paint(faults.region_from, sun=faults.region_sun))
    whole = tip_part(body_triangles(*where, Paint(faults.region_from)).labels)
    a, b, c = found.corners.swapaxes(0, 1)
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    outward = np.sign(
        (normals * (found.corners.mean(axis=1) - [a[:, 0].mean(), 0, 0])).sum(axis=1)
    )
    lit = np.maximum(outward * (normals[:, 1:] @ faults.region_sun), 0.0)
    # To the nearest twentieth, on the sides of a straight beam.
    sides = np.abs(normals[:, 0]) < 0.5
    assert tip_part(found.labels)[sides] == pytest.approx((whole * lit)[sides], abs=0.026)
    assert set(np.round(tip_part(found.labels), 2)) == {0.0, 0.6, 0.8}
    assert not tip_part(found.labels)[~sides].any()


def test_a_bleached_body_errs_on_sides_that_are_seen(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    faults, largest = draw_faults('depth_bias_by_region/bleached', setup), []
    for pose in range(4):
        view, right, there = with_and_without(plain, setup, faults, pose, rests[pose])
        largest.append(np.abs(view.depth[there] - right.depth[there]).max())
    assert 0.007 < max(largest) < 0.014


def test_a_camera_is_tugged_about_its_foot_towards_one_place_of_the_rig(
    setup: Setup, plain: Specimen
) -> None:
    faults = draw_faults('camera_offset/tugged', setup)
    assert faults.camera_foot is not None
    stored = np.linalg.inv(setup.depth_from_world)
    foot = stored[:3, :3] @ np.array(faults.camera_foot) + stored[:3, 3]
    turns, moves = [], []
    for pose in setup.observations:
        found = np.linalg.inv(true_camera(plain, setup, jostled(setup, pose, faults)))
        turn = Rotation.from_matrix(found[:3, :3] @ stored[:3, :3].T)
        assert found[:3, 3] == pytest.approx(foot + turn.apply(stored[:3, 3] - foot), abs=1e-9)
        turns.append(np.rad2deg(turn.magnitude()))
        moves.append(found[:3, 3] - stored[:3, 3])
    assert min(turns) == pytest.approx(0.0, abs=1e-9)
    assert max(turns) == pytest.approx(1.75, rel=0.16)
    # Towards the rig, which is ahead.
    ahead = setup.depth_from_world[2, :3]
    assert all(float(move @ ahead) >= -1e-9 for move in moves)


def test_a_table_on_soft_feet_leans_to_one_place_of_the_rig(setup: Setup) -> None:
    faults = draw_faults('gravity_tilt/floating', setup)
    x, z = np.deg2rad(faults.tilt_scatter).T
    # What a small tilt draws to the side, of the weight.
    sides = np.stack([z, -x], axis=-1)
    levels = [pose.world_from_object[[0, 2], :3] for pose in setup.observations]
    heavy = np.linalg.lstsq(np.concatenate(levels), sides.ravel(), rcond=None)[0]
    assert np.array(levels) @ heavy == pytest.approx(sides, abs=2e-5)
    assert 0.05 < np.linalg.norm(heavy) < 0.6
    assert np.hypot(*faults.gravity_tilt) == pytest.approx(
        0.4 * np.rad2deg(np.linalg.norm(heavy[1:])), rel=0.01
    )


def test_a_table_draws_a_body_to_where_it_leans(setup: Setup) -> None:
    stiff = replace(setup, youngs_modulus=20.0 * setup.youngs_modulus)
    tilted = ((6.0, -4.0), (0.0, 0.0), (-3.0, 5.0), (1.0, 1.0))
    faults = Faults(tilt_form='floating', gravity_tilt=(2.0, 3.0), tilt_scatter=tilted)
    specimen = make_specimen(stiff, Faults())
    for pose, (x, z) in enumerate(tilted):
        usual = Faults(gravity_tilt=(2.0 + x, 3.0 + z))
        found, expected = (
            settle(specimen, stiff, stiff.observations[pose], each) for each in (faults, usual)
        )
        assert found == pytest.approx(expected, abs=1e-9)


def test_a_crammed_body_is_bent_twice_at_right_angles(setup: Setup) -> None:
    shape = setup.shape
    free = shape.length - shape.clamp
    nodes = np.zeros((2001, 3))
    nodes[:, 0] = shape.clamp + np.linspace(0.0, 1.0, 2001) * free
    faults = Faults(
        rest_curvature=(0.0, 2.0),
        curvature_form='crammed',
        curvature_at=0.25,
        curvature_again=0.65,
        curvature_back=0.8,
    )
    steps = np.diff(stress_free_nodes(nodes, shape, faults), axis=0)
    assert np.linalg.norm(steps, axis=1).sum() == pytest.approx(free, rel=1e-6)
    ways = steps / np.linalg.norm(steps, axis=1)[:, None]
    inner, outer = 2.0 * free, 0.8 * 2.0 * free
    before, between, after = (ways[int(2000 * share)] for share in (0.1, 0.45, 0.9))
    assert before == pytest.approx([1.0, 0.0, 0.0], abs=1e-9)
    assert between == pytest.approx([np.cos(inner), np.sin(inner), 0.0], abs=1e-6)
    # The second bend leaves the plane of the first by its whole turn.
    assert np.arccos(between @ after) == pytest.approx(outer, rel=1e-4)
    assert abs(after[2]) == pytest.approx(np.sin(outer), rel=1e-4)


@pytest.mark.parametrize('family', ['arch', 'fin'])
def test_a_sponge_and_a_tug_are_drawn_for_other_bodies_too(family: str) -> None:
    drawn = draw_setup(family, is_sealed=True, poses=4, random=np.random.default_rng(3))
    plain = make_specimen(drawn, Faults(), 0.5)
    faults = draw_faults('added_mass/sponge', drawn)
    line = np.array([[drawn.shape.clamp, 0.0, 0.0], [drawn.shape.length, 0.0, 0.0]])
    for view in drawn.observations:
        found = sponge_masses(plain.body.masses, plain.shares, drawn, view, faults)
        wet, shares = found > 0.0, plain.shares
        rise = np.diff(applied(view.world_from_object, drawn.shape.place(line))[:, 1])[0]
        density = np.log(found[wet] / plain.body.masses[wet])
        # Wetter towards the tip where that is lower.
        trend = np.polyfit(shares[wet], density, 1)[0]
        assert (abs(rise) < 0.015) or (trend * rise < 0.0)
