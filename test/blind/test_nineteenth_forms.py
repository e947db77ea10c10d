# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the nineteenth set do what their labels say."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import fsolve
from support.blind_contact import dents_of
from support.blind_derivatives import check_body_stiffness, check_derivatives, check_loose_fibres
from support.blind_draws import draw_faults, STEPS
from support.blind_rests import COARSE, lying, rest_of, tip_moves, tip_rises
from support.blind_views import with_and_without

from benchmarks.blind.catenary import cable_length, hanging, slung
from benchmarks.blind.contact import contact_laws
from benchmarks.blind.exposure import exposure
from benchmarks.blind.faults import Faults
from benchmarks.blind.fibres import Fibres
from benchmarks.blind.flap import turned_flap
from benchmarks.blind.laying import lay_on_plane, softer
from benchmarks.blind.marbling import marbled_value
from benchmarks.blind.observe import true_rendering
from benchmarks.blind.paint import FIXTURE
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.rest_shape import stress_free_nodes
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import draw_setup, GRAVITY, Setup
from benchmarks.blind.simulation import make_specimen, settle
from benchmarks.blind.specimen import Specimen


def _chain_end(pull: np.ndarray, length: float, count: int) -> np.ndarray:
    """Return where a chain of links ends that hangs from the origin by a pull (aside, up)."""
    link = length / count
    # Each link points along what it bears: all that hangs from it, and the half of itself.
    up = pull[1] - length + link * (np.arange(count) + 0.5)
    bears = np.stack([np.full(count, pull[0]), up], axis=-1)
    return np.asarray((link * bears / np.linalg.norm(bears, axis=1)[:, None]).sum(axis=0))


@pytest.mark.parametrize(('wide', 'high'), [(0.08, -0.03), (0.05, 0.04), (0.1, 0.0)])
def test_a_slack_cable_pulls_as_a_chain_of_links_does(wide: float, high: float) -> None:
    length = 0.13
    energy, (aside, down), _ = hanging(np.array([wide]), np.array([high]), length)
    assert np.isfinite(energy).all()
    there = _chain_end(np.array([aside[0], down[0]]), length, 4000)
    assert there == pytest.approx([wide, high], abs=1e-6)
    found = fsolve(lambda pull: _chain_end(pull, length, 400) - [wide, high], [0.05, 0.06])
    assert found == pytest.approx([aside[0], down[0]], rel=1e-3)
    # Both its ends bear all of it.
    other = hanging(np.array([wide]), np.array([-high]), length)[1][1]
    assert down + other == pytest.approx(length)


def test_a_taut_cable_turns_a_line_search_back() -> None:
    energy = hanging(np.array([0.1, 0.1]), np.array([0.05, 0.02]), 0.11)[0]
    assert np.isinf(energy).tolist() == [True, False]


@pytest.mark.parametrize('step', STEPS)
def test_a_slung_cable_pulls_by_its_energy(
    setup: Setup, plain: Specimen, rests: list[np.ndarray], step: float
) -> None:
    faults = draw_faults('added_mass/slung', setup)
    for pose in (0, 2, 3):
        law = slung(
            plain.mesh.nodes, plain.body.masses, plain.shares, setup.observations[pose], faults
        )
        stiff = check_derivatives(law, rests[pose], step=step)
        tied = stiff.any(axis=1)
        assert 0.0 < tied.mean() < 0.3
        assert np.abs(plain.shares[tied] - faults.added_mass_at).max() < 0.2


def test_a_slung_cable_is_longer_than_the_way_and_draws_down_and_back(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    faults, shares = draw_faults('added_mass/slung', setup), plain.shares
    anchor = 1e-3 * np.array(faults.mass_anchor)
    free = setup.shape.length - setup.shape.clamp
    place = np.array([setup.shape.clamp + faults.added_mass_at * free, 0.0, 0.0])
    near = (np.abs(shares - faults.added_mass_at) < 0.05).astype(float)
    length = cable_length(plain.mesh.nodes, near, faults)
    way = float(np.linalg.norm(place - anchor))
    assert length == pytest.approx((1.0 + faults.mass_longer) * way, rel=0.08)
    view = setup.observations[0]
    law = slung(plain.mesh.nodes, plain.body.masses, shares, view, faults)
    force = -law(rests[0]).gradient.sum(axis=0)
    down = float(-view.world_from_object[1, :3] @ force)
    assert 0.2 < down / (1e-3 * faults.added_mass * GRAVITY) < 0.6
    assert force[0] < 0.0


@pytest.mark.parametrize('step', STEPS)
def test_coils_push_by_their_energy_once_they_touch(step: float) -> None:
    coils = Fibres(np.array(3e4), np.array([1.0, 0.0, 0.0]), pressed=True, loose=0.04)
    bent = np.diag([0.92, 1.03, 1.03]) + np.random.default_rng(1).uniform(-0.02, 0.02, (3, 3))
    check_loose_fibres(coils, bent, step, still=(0.981, 1.0, 1.05))


@pytest.mark.parametrize('step', [1e-7, 1e-8, 1e-9])
def test_a_body_with_coils_resists_as_its_forces_change(setup: Setup, step: float) -> None:
    faults = Faults(stiffening_form='coils', stiffening=2.0, stiffening_from=0.01)
    specimen = make_specimen(setup, faults, COARSE)
    (coils,) = specimen.body.numbers.network
    stiffness = 8.0 * np.asarray(coils.stiffness) / setup.youngs_modulus
    assert set(np.unique(np.round(stiffness, 9))) == {0.0, 2.0}
    shorter = specimen.mesh.nodes * np.array([0.9, 1.05, 1.05])
    check_body_stiffness(specimen.body, shorter, step=step)


def test_a_body_with_coils_sags_less_than_a_bare_one(setup: Setup) -> None:
    soft = softer(setup, 0.3)
    lifts = tip_rises(
        soft, [draw_faults('strain_stiffening/coils', soft, size) for size in (1, 2)]
    )
    assert 0.002 < lifts[0] < lifts[1] < 0.02


def test_swirls_are_of_mean_0_and_variance_1_and_as_long_as_stated() -> None:
    places = np.array([0.3, 0.4])
    still = np.array([[0.2, 0.2], [-0.1, -0.1]])
    # A seed gives one draw of the two places, a quarter of a wave apart.
    found = np.array([marbled_value(places, still, 0.4, seed) for seed in range(1, 3001)])
    assert found.mean(axis=0) == pytest.approx([0.0, 0.0], abs=0.06)
    assert found.var(axis=0) == pytest.approx([1.0, 1.0], abs=0.08)
    # Rates are normal: what is alike falls by the exponential of the square of the way.
    expected = np.exp(-0.5 * (0.5 * np.pi) ** 2)
    assert np.corrcoef(found.T)[0, 1] == pytest.approx(expected, abs=0.06)


def test_a_marbled_body_has_its_swirls_where_it_is(setup: Setup) -> None:
    faults = draw_faults('stiffness_contrast/marbled', setup)
    marbled, whole = (make_specimen(setup, each) for each in (faults, Faults()))
    harder = np.log(np.asarray(marbled.body.numbers.shear / whole.body.numbers.shear))
    places = whole.body.quadrature.values @ whole.mesh.nodes[whole.mesh.cells]
    # A straight beam of one section: places are shares of its length, width and height.
    free = setup.shape.length - setup.shape.clamp
    share = np.maximum(places[..., 0] - setup.shape.clamp, 0.0) / free
    across = np.moveaxis(places[..., 1:], -1, 0)
    across = across / (0.5 * np.array(setup.shape.section)[:, None, None])
    value = marbled_value(share, across, faults.contrast_wave, faults.contrast_seed)
    # Shares are told at nodes: in the cells beside the clamp alone is that another thing.
    beyond = share > 0.05
    assert harder[beyond] == pytest.approx(faults.contrast * value[beyond], abs=1e-6)
    assert np.ptp(harder[beyond]) > 1.0


def test_glue_holds_a_body_by_its_lower_face_alone(setup: Setup, plain: Specimen) -> None:
    faults = Faults(clamp_form='glued', clamp_gape=6.0)
    glued = make_specimen(setup, faults, COARSE)
    held, nodes = glued.body.held, glued.mesh.nodes
    assert nodes[held, 2] == pytest.approx(-0.5 * setup.shape.section[1])
    assert nodes[held, 0].max() == pytest.approx(setup.shape.clamp - 0.006)
    assert len(held) > 15
    below = nodes[:, 2] < -0.5 * setup.shape.section[1] + 1e-9
    assert not np.setdiff1d(np.flatnonzero(below & (nodes[:, 0] < 0.012)), held).size
    for pose in (0, 3):
        rest = rest_of(setup, faults, pose)
        assert rest[held] == pytest.approx(nodes[held], abs=1e-12)
        # Above the glue it gives way, the more the farther up.
        aside = np.linalg.norm(rest - nodes, axis=1)
        inner = (nodes[:, 0] > 0.005) & (nodes[:, 0] < setup.shape.clamp - 0.006)
        high = nodes[:, 2] > 0.5 * setup.shape.section[1] - 1e-9
        assert aside[inner & high].max() > 1e-4
    assert glued.body.masses.sum() == pytest.approx(plain.body.masses.sum())


def test_glue_gives_a_tip_away_by_some_4_and_10_mm(setup: Setup, plain: Specimen) -> None:
    for size, least, most in ((1, 2.5, 8.0), (2, 6.0, 16.0)):
        faults = draw_faults('compliant_clamp/glued', setup, size)
        tip = make_specimen(setup, faults, COARSE).shares > 0.99
        assert least < 1e3 * max(tip_moves(setup, plain, faults, tip)) < most


def test_a_body_in_a_slot_tips_to_where_its_weight_draws(setup: Setup, plain: Specimen) -> None:
    faults = draw_faults('clamp_offset/rattling', setup)
    scatter = np.array(faults.clamp_scatter)
    assert not scatter[:, :4].any()
    for turns in np.abs(scatter[:, 4:]).T:
        # Against one wall or the other, and amid them before it came to one at first.
        assert len(np.unique(turns[turns > 0.0])) == 1
    for pose, observation in enumerate(setup.observations):
        held = plain.mesh.held
        found = rest_of(setup, faults, pose)[held]
        lower = -(applied(observation.world_from_object, found))[:, 1]
        before = -(applied(observation.world_from_object, plain.mesh.nodes[held]))[:, 1]
        sunk = lower - before
        mouth = plain.mesh.nodes[held, 0] > setup.shape.clamp - 1e-6
        inner = plain.mesh.nodes[held, 0] < 1e-6
        assert sunk[mouth].mean() > 2e-4
        assert sunk[inner].mean() == pytest.approx(-sunk[mouth].mean(), abs=1e-4)


def test_a_body_in_a_slot_stays_where_its_weight_hardly_draws_aside(setup: Setup) -> None:
    first, rolled = setup.observations[:2]
    twice = replace(setup, observations=(first, rolled, replace(first, name='again')))
    level, _, again = np.array(draw_faults('clamp_offset/rattling', twice).clamp_scatter)
    # About z it turned once it was rolled to the side, and not before.
    assert level[5] == 0.0
    assert again[5] != 0.0
    assert again[4] == level[4] != 0.0


@pytest.fixture(scope='module')
def on_a_flap(setup: Setup) -> tuple[Setup, Faults]:
    """A set-up whose body lies on a flap in the first pose, and that flap."""
    return lay_on_plane(setup, draw_faults('contact_plane/flap', setup), np.random.default_rng(1))


def test_a_flap_lifts_a_body_in_two_poses(
    on_a_flap: tuple[Setup, Faults], plain: Specimen
) -> None:
    laid, faults = on_a_flap
    moves = [lying(laid, plain, faults, pose)[1] for pose in range(4)]
    assert 0.006 < moves[0] < 0.015
    assert moves[2] > 0.001
    assert moves[1] == pytest.approx(0.0, abs=1e-9)
    assert moves[3] == pytest.approx(0.0, abs=1e-9)


def test_a_flap_turns_by_the_moment_about_its_hinge(
    on_a_flap: tuple[Setup, Faults], plain: Specimen
) -> None:
    laid, faults = on_a_flap
    view, found = laid.observations[0], rest_of(laid, faults)
    assert faults.contact_height is not None
    hinge = np.array([faults.contact_ahead, faults.contact_height, 0.0])
    arms = applied(view.world_from_object, found) - hinge
    # What the body lies on is what neither its clamp nor its weight bears.
    inner = plain.body.evaluate(found, with_stiffness=False).gradient
    weight = GRAVITY * plain.body.masses[:, None] * view.world_from_object[1, :3]
    pushes = (inner + weight) @ view.world_from_object[:3, :3].T
    pushes[plain.mesh.held] = 0.0
    moment = abs(float(np.cross(arms, pushes)[:, 2].sum()))
    touched = np.linalg.norm(pushes, axis=1).argmax()
    turn = float(np.arctan2(-arms[touched, 1], abs(arms[touched, 0])))
    assert 0.02 < turn < 0.2
    assert faults.contact_give * moment == pytest.approx(turn, rel=0.02)
    assert 0.06 < abs(arms[touched, 0]) < 0.11


@pytest.mark.parametrize('step', STEPS)
def test_a_turned_flap_pushes_by_its_energy(
    on_a_flap: tuple[Setup, Faults], plain: Specimen, step: float
) -> None:
    laid, faults = on_a_flap
    view = laid.observations[0]
    tip = applied(view.world_from_object, plain.mesh.nodes[plain.shares > 0.99]).mean(axis=0)
    turned = turned_flap(faults, 0.05, float(np.sign(tip[0] - faults.contact_ahead)))
    (law,) = contact_laws(plain.areas, plain.shares, view, turned)
    dented = rest_of(laid, faults) - 0.002 * view.world_from_object[1, :3]
    away = (np.abs(dents_of(laid, turned, dented)) > 1e-4) & (plain.shares > 0.41)
    stiff = check_derivatives(law, dented, step=step, is_smooth=away, share=1e-4)
    assert np.abs(stiff[away]).max() > 0.0
    # Square to the flap, whose free end is down.
    force = -law(dented).gradient.sum(axis=0) @ view.world_from_object[:3, :3].T
    lean = np.sign(tip[0] - faults.contact_ahead) * np.tan(0.05)
    assert force[0] / force[1] == pytest.approx(lean)
    inner = plain.shares < 0.39
    assert not law(dented).gradient[inner].any()


def test_a_frame_is_exposed_by_the_inverse_of_its_mean_light() -> None:
    depth = np.full((4, 5, 9), np.inf)
    depth[1:3, :2], depth[1:3, 2:4] = 0.3, 0.6
    facing = np.where(np.isfinite(depth), 0.5, 1.0)
    facing[1:3, 2:4] = 0.1
    view = Rendering(0, 0, depth, np.where(np.isfinite(depth), 1, -1), facing)
    # One half at the distance, aslant; one twice as far, and darker than counts.
    assert exposure(view, 0.3) == pytest.approx(1.0 / (0.5 * (0.5 + 1.0 / 3.0 / 4.0)))
    empty = replace(view, depth=np.full(depth.shape, np.inf))
    assert exposure(empty, 0.3) == 1.0


def test_a_frame_errs_alike_all_over_by_how_long_it_is_exposed(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    faults, errors = draw_faults('depth_affine/exposed', setup), []
    distance = float(np.linalg.norm(setup.depth_from_world[:3, 3]))
    for pose in range(4):
        view, right, there = with_and_without(plain, setup, faults, pose, rests[pose])
        error = view.depth[there] - right.depth[there]
        assert np.ptp(error) < 1e-12
        squares = np.mean((distance / right.depth[there]) ** 2)
        light = float(1e-3 * faults.depth_bias / error.mean())
        # As bright as what is met squarely at most, and as dark as counts at least.
        assert 1.0 / 3.0 < light / squares < 1.0
        errors.append(abs(float(error.mean())))
    assert 0.006 < min(errors) < max(errors) < 0.025
    assert max(errors) > 1.1 * min(errors)


def test_what_fingers_left_falls_by_the_exponential_of_the_way_from_the_tip() -> None:
    setup = draw_setup('beam', is_sealed=True, poses=4, random=np.random.default_rng(2))
    plain = make_specimen(setup, Faults())
    faults = Faults(region_bias=5.0, region_decay=0.4)
    pose, camera = setup.observations[0], setup.camera
    view, right = (
        true_rendering(plain, setup, pose, each, plain.mesh.nodes) for each in (faults, Faults())
    )
    body = np.isfinite(right.depth) & (right.labels != FIXTURE)
    rows, columns, samples = np.nonzero(body)
    # Of the nine samples of a pixel the place in the image, then that in the object frame.
    down, across = (samples // 3 - 1) / 3.0, (samples % 3 - 1) / 3.0
    x = (columns + across + right.column - camera.cx) / camera.fx
    y = (rows + down + right.row - camera.cy) / camera.fy
    seen = right.depth[body][:, None] * np.column_stack([x, y, np.ones(len(x))])
    ahead = applied(np.linalg.inv(setup.depth_from_world @ pose.world_from_object), seen)[:, 0]
    share = (ahead - setup.shape.clamp) / (setup.shape.length - setup.shape.clamp)
    error = view.depth[body] - right.depth[body]
    # To the nearest twentieth, of triangles that are some 2 mm long.
    assert error == pytest.approx(0.005 * np.exp((share - 1.0) / 0.4), abs=0.005 * 0.08)
    assert error.max() == pytest.approx(0.005, rel=0.06)
    fixture = right.labels == FIXTURE
    assert np.array_equal(view.depth[fixture], right.depth[fixture])


def test_a_camera_that_follows_shifts_all_that_it_sees(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    moved = Faults(center_scatter=((4.0, -7.0), (0.0, 0.0), (-3.0, 2.0), (1.0, 1.0)))
    for pose in (0, 2):
        view, right = (
            true_rendering(plain, setup, setup.observations[pose], each, rests[pose])
            for each in (moved, Faults())
        )
        shift = (view.column - right.column, view.row - right.row)
        assert shift == moved.center_scatter[pose]
        there = np.isfinite(right.depth)
        # A sample on the very outline may fall to either side.
        assert (np.isfinite(view.depth) == there).mean() > 0.9999
        both = there & np.isfinite(view.depth)
        assert np.median(np.abs(view.depth[both] - right.depth[both])) < 1e-9


def test_a_camera_follows_by_one_share_of_how_far_a_body_is_off(setup: Setup) -> None:
    scatter = np.array(draw_faults('camera_offset/framed', setup).center_scatter)
    assert np.linalg.norm(scatter, axis=1).max() < 17.5 * 1.16
    shape, camera, gains = setup.shape, setup.camera, []
    middle = [0.5 * (shape.clamp + shape.length), 0.0, 0.0]
    for pose, found in zip(setup.observations, scatter, strict=True):
        x, y, z = applied(setup.depth_from_world @ pose.world_from_object, np.array([middle]))[0]
        off = np.array([camera.fx * x / z, camera.fy * y / z])
        gains.append(-float(found @ off) / float(off @ off))
        assert found == pytest.approx(-gains[-1] * off, abs=2e-3)
    assert gains == pytest.approx([gains[0]] * 4, abs=2e-3)
    assert 0.1 < gains[0] <= 1.001


@pytest.mark.parametrize('count', [1.2, 2.4])
def test_a_body_from_ridges_is_bent_by_the_sine(setup: Setup, count: float) -> None:
    shape = setup.shape
    free = shape.length - shape.clamp
    shares = np.linspace(0.0, 1.0, 3601)
    nodes = np.zeros((3601, 3))
    nodes[:, 0] = shape.clamp + shares * free
    faults = Faults(rest_curvature=(0.0, 0.2), curvature_form='wavy', curvature_waves=count)
    bent = stress_free_nodes(nodes, shape, faults)
    steps = np.diff(bent, axis=0)
    slopes = np.arctan2(steps[:, 1], steps[:, 0])
    # Turned by the integral of a sine: most after half a wave, and not at all after a whole one.
    expected = 1.0 - np.cos(2.0 * np.pi * count * 0.5 * (shares[1:] + shares[:-1]))
    size = float(slopes @ expected / (expected @ expected))
    assert slopes == pytest.approx(size * expected, abs=0.02 * size)
    assert bent[-1, 1] == pytest.approx(0.5 * 0.2 * free**2, rel=0.02)
    assert not bent[:, 2].any()
    assert np.linalg.norm(steps, axis=1).sum() == pytest.approx(free, rel=1e-6)


def test_a_wavy_body_rests_apart_from_a_straight_one(setup: Setup) -> None:
    faults = draw_faults('rest_curvature/wavy', setup)
    wavy = make_specimen(setup, faults, COARSE)
    stiff = replace(setup, youngs_modulus=1e4 * setup.youngs_modulus)
    body = make_specimen(stiff, faults, COARSE)
    rest = settle(body, stiff, stiff.observations[0], faults)
    expected = stress_free_nodes(wavy.mesh.nodes, setup.shape, faults)
    assert rest == pytest.approx(expected, abs=2e-4)
