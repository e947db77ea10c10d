# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the seventeenth set do what their labels say."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.distance import pdist
from scipy.spatial.transform import Rotation
from support.blind_contact import check_pushes, dents_of
from support.blind_draws import draw_faults, STEPS
from support.blind_rests import clamp_motion_and_load, COARSE, lying, rest_of, turn_of
from support.blind_views import with_and_without

from benchmarks.blind.contact import contact_laws, highest_tops, OUTER
from benchmarks.blind.draught import drawn_in
from benchmarks.blind.faults import Faults
from benchmarks.blind.flexure import wrist_compliance
from benchmarks.blind.jaws import bowed
from benchmarks.blind.laying import lay_on_plane
from benchmarks.blind.observe import jostled, true_camera, true_rendering
from benchmarks.blind.paint import FIXTURE, tip_part
from benchmarks.blind.rest_shape import stress_free_nodes
from benchmarks.blind.setups import draw_setup, Setup
from benchmarks.blind.simulation import make_specimen, settle
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.speckle import speckled


def test_markers_have_their_masses_on_their_stalks(setup: Setup) -> None:
    faults = Faults(
        mass_form='markers',
        added_mass=9.0,
        mass_stops=(0.4, 0.9),
        mass_count=3,
        mass_arm=(2.0, 25.0),
    )
    markers = make_specimen(setup, faults)
    nodes, clamp = markers.mesh.nodes, setup.shape.clamp
    assert 1e3 * markers.added.sum() == pytest.approx(9.0)
    middle = markers.added @ nodes / markers.added.sum()
    free = setup.shape.length - clamp
    # A foot is of whole cells: some tenths of a millimetre beside its place.
    assert middle[0] == pytest.approx(clamp + 0.65 * free, abs=4e-4)
    assert middle[1:] == pytest.approx([0.002, 0.025], abs=1e-6)
    parts = [
        make_specimen(
            setup, replace(faults, added_mass=3.0, mass_stops=(at, at), mass_count=1)
        ).added
        for at in (0.4, 0.65, 0.9)
    ]
    assert markers.added == pytest.approx(sum(parts), abs=1e-12)


@pytest.mark.parametrize('pose', [1, 2])
def test_markers_on_stalks_twist_a_body_as_their_weight_asks(setup: Setup, pose: int) -> None:
    high = draw_faults('added_mass/markers', setup)
    low = replace(high, mass_arm=(0.0, 0.0))
    specimen = make_specimen(setup, Faults(), COARSE)
    tip = specimen.shares > 0.8
    one, other = (rest_of(setup, each, pose)[tip] for each in (low, high))
    # A stalk along z and a weight across: a moment about x of the other sign.
    aside = -setup.observations[pose].world_from_object[1, 1]
    assert abs(aside) > 0.2
    assert turn_of(one, other)[0] * aside < -0.005


def test_a_foil_is_on_the_upper_side_from_its_begin_to_its_end(setup: Setup) -> None:
    faults = Faults(contrast_mode='foil', contrast=1.5, contrast_at=0.1, contrast_until=0.6)
    glued, whole = (make_specimen(setup, each) for each in (faults, Faults()))
    harder = np.log(np.asarray(glued.body.numbers.shear / whole.body.numbers.shear))
    share = whole.shares[whole.mesh.cells] @ whole.body.quadrature.values.T
    inside = (whole.heights > 0.5) & (share > 0.1) & (share < 0.6)
    assert 0 < inside.sum() < 0.3 * inside.size
    assert harder == pytest.approx(1.5 * inside)


@pytest.mark.parametrize('seed', [1, 4])
def test_a_foil_stiffens_a_body_as_two_layers_do(seed: int) -> None:
    setup = draw_setup('beam', is_sealed=True, poses=4, random=np.random.default_rng(seed))
    faults = Faults(contrast_mode='foil', contrast=1.2, contrast_at=-1.0, contrast_until=2.0)
    body = make_specimen(setup, faults)
    volumes = body.body.quadrature.volumes
    layer, ratio = float(volumes[body.heights > 0.5].sum() / volumes.sum()), np.exp(1.2)
    # Timoshenko's beam of two layers: their own parts, and those about the axis of neither.
    own = (1.0 - layer) ** 3 + ratio * layer**3
    between = 12.0 * (1.0 - layer) * ratio * layer / (1.0 - layer + ratio * layer) * 0.25
    stiffer = own + between
    plain, stiff = (body.mesh.nodes - _fine_rest(setup, each) for each in (Faults(), faults))
    tip = body.shares > 0.99
    found = float(plain[tip, 2].mean() / stiff[tip, 2].mean())
    assert found == pytest.approx(stiffer, rel=0.1)


def _fine_rest(setup: Setup, faults: Faults) -> np.ndarray:
    """Return where a body rests in its first pose in cells of the usual size [m]."""
    return settle(make_specimen(setup, faults), setup, setup.observations[0], faults)


def test_a_wrist_gives_way_by_the_moment_about_each_of_its_joints() -> None:
    compliance, length = 0.3, 0.06
    found = wrist_compliance(compliance, length)
    force, moment = np.array([0.4, -0.7, 1.1]), np.array([0.02, 0.05, -0.03])
    shift, turn = np.zeros(3), np.zeros(3)
    for axis, place in ((0, 0.0), (1, -0.06), (2, -0.09)):
        joint = np.array([place, 0.0, 0.0])
        by = np.zeros(3)
        by[axis] = compliance * (moment + np.cross(-joint, force))[axis]
        # What is rigid beyond a joint turns about that: the clamp is at the origin.
        small = Rotation.from_rotvec(1e-6 * by)
        shift += 1e6 * (joint + small.apply(-joint))
        turn += by
    expected = np.concatenate([shift, turn])
    assert found @ np.concatenate([force, moment]) == pytest.approx(expected, rel=1e-4, abs=1e-9)
    assert np.allclose(found, found.T, rtol=0.0, atol=1e-15)
    assert np.linalg.matrix_rank(found, tol=1e-9) == 3


@pytest.mark.parametrize('pose', range(4))
def test_a_clamp_on_a_wrist_rests_where_that_bears_the_body(
    setup: Setup, plain: Specimen, pose: int
) -> None:
    faults = draw_faults('compliant_clamp/wrist', setup)
    motion, load = clamp_motion_and_load(setup, plain, faults, pose)
    compliance = wrist_compliance(faults.clamp_compliance, faults.clamp_length)
    expected = compliance @ load
    assert motion[:3] == pytest.approx(expected[:3], abs=2e-5)
    assert motion[3:] == pytest.approx(expected[3:], abs=2e-3)


def test_bowed_jaws_bend_what_they_hold_to_an_arc_and_turn_all_beyond(
    setup: Setup, plain: Specimen
) -> None:
    faults = Faults(clamp_bow=(2.0, -3.0))
    mesh, clamp = plain.mesh, setup.shape.clamp
    found = bowed(plain, faults).mesh.nodes
    free = np.setdiff1d(np.arange(len(found)), mesh.held)
    assert pdist(found[free]) == pytest.approx(pdist(mesh.nodes[free]), abs=1e-12)
    turn = turn_of(mesh.nodes[free], found[free])
    assert turn == pytest.approx(clamp * np.array([0.0, 2.0, -3.0]), abs=1e-9)
    # The middle line is a part of a circle about an axis across the inner end.
    axis, size = np.array([0.0, 2.0, -3.0]), np.hypot(2.0, 3.0)
    center = np.cross(axis, [1.0, 0.0, 0.0]) / size**2
    on_line = mesh.held[np.abs(mesh.nodes[mesh.held, 1:]).max(axis=1) < 1e-9]
    assert len(on_line) >= 2
    assert np.linalg.norm(found[on_line] - center, axis=1) == pytest.approx(1.0 / size)
    inner = mesh.nodes[:, 0] == 0.0
    assert found[inner] == pytest.approx(mesh.nodes[inner])
    # Faces at the mouth stay as they were to those beyond, which carry them on.
    mouth = mesh.held[mesh.nodes[mesh.held, 0] > clamp - 1e-9]
    moved = np.concatenate([found[mouth], found[free]])
    assert pdist(moved) == pytest.approx(
        pdist(np.concatenate([mesh.nodes[mouth], mesh.nodes[free]])), abs=1e-12
    )


def test_bowed_jaws_hold_their_part_where_they_bend_it(setup: Setup, plain: Specimen) -> None:
    faults = draw_faults('clamp_offset/bowed', setup)
    held = plain.mesh.held
    bent = bowed(plain, faults).mesh.nodes[held]
    for pose in (0, 3):
        assert rest_of(setup, faults, pose)[held] == pytest.approx(bent, abs=1e-12)
    assert not np.allclose(bent, plain.mesh.nodes[held], rtol=0.0, atol=5e-4)


@pytest.fixture(scope='module')
def on_a_cushion(setup: Setup) -> tuple[Setup, Faults]:
    """A set-up whose body lies on a cushion in the first pose, and that cushion."""
    return lay_on_plane(
        setup, draw_faults('contact_plane/cushion', setup), np.random.default_rng(1)
    )


def test_a_cushion_bears_a_body_by_its_outer_part_alone(
    on_a_cushion: tuple[Setup, Faults], plain: Specimen
) -> None:
    laid, faults = on_a_cushion
    assert faults.contact_height is not None
    moves = []
    for pose in range(4):
        found, move = lying(laid, plain, faults, pose)
        moves.append(move)
        world = laid.observations[pose].world_from_object
        points = found @ world[:3, :3].T + world[:3, 3]
        dents = (faults.contact_height - highest_tops(points, faults))[plain.shares > 0.4]
        assert (dents.max() > 0.0) == (pose in (0, 2))
        assert dents.max() < 0.009
    assert 0.007 < moves[0] < 0.013
    assert moves[0] > moves[2] > 0.001
    assert moves[1] == moves[3] == 0.0


def test_a_cushion_is_highest_in_its_middle_and_round_there() -> None:
    faults = Faults(
        contact_form='cushion', contact_round=-0.15, contact_ahead=0.02, contact_at=-0.01
    )
    places = np.array([[0.02, 0.3, -0.01], [0.05, 0.3, -0.01], [0.02, 0.3, 0.03]])
    # What is beside its middle by d lies d^2 / (2 R) above where it would touch.
    expected = 0.3 + np.array([0.0, 0.03**2, 0.04**2]) / 0.3
    assert highest_tops(places, faults) == pytest.approx(expected)


@pytest.mark.parametrize('step', STEPS)
def test_a_cushion_pushes_by_its_energy(
    on_a_cushion: tuple[Setup, Faults], plain: Specimen, step: float
) -> None:
    laid, faults = on_a_cushion
    check_pushes(laid, plain, faults, step)


def test_a_cushion_presses_by_its_stiffness_where_it_is_dented(
    on_a_cushion: tuple[Setup, Faults], plain: Specimen
) -> None:
    laid, faults = on_a_cushion
    assert faults.contact_height is not None
    (law,) = contact_laws(plain.areas, plain.shares, laid.observations[0], faults)
    found, up = rest_of(laid, faults), laid.observations[0].world_from_object[1, :3]
    pushes, dents = -law(found).gradient @ up, dents_of(laid, faults, found)
    below = np.maximum(dents, 0.0) * (plain.shares > OUTER['cushion'])
    assert pushes.max() > 0.0
    assert pushes == pytest.approx(faults.contact_stiffness * plain.areas * below)


def test_saturated_pixels_err_by_the_light_that_is_too_much(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    faults = draw_faults('depth_affine/saturated', setup)
    distance = float(np.linalg.norm(setup.depth_from_world[:3, 3]))
    for pose in (0, 3):
        view, right, there = with_and_without(plain, setup, faults, pose, rests[pose])
        error = view.depth[there] - right.depth[there]
        light = np.maximum(right.facing[there], 1.0 / 3.0) * (distance / right.depth[there]) ** 2
        much = light > faults.depth_full
        assert 0.1 < much.mean() < 1.0
        assert not error[~much].any()
        share = (light[much] - faults.depth_full) / (1.0 - faults.depth_full)
        assert error[much] == pytest.approx(1e-3 * faults.depth_bias * share, abs=1e-9)
        assert 0.004 < np.abs(error).max() < 0.02


def test_dots_cover_their_share_and_are_of_their_size() -> None:
    edge, random = 0.007, np.random.default_rng(5)
    points = random.uniform(-0.03, 0.1, (40000, 3))
    found = speckled(points, edge, 0.6, 11)
    assert found.mean() == pytest.approx(0.6, abs=0.02)
    # All of a cube is in a dot, or nothing of it.
    middles = (np.floor(points / edge) + 0.5) * edge
    assert np.array_equal(found, speckled(middles, edge, 0.6, 11))
    beside = speckled(middles + np.array([0.0, edge, 0.0]), edge, 0.6, 11)
    assert (found & beside).mean() == pytest.approx(0.36, abs=0.03)
    assert not np.array_equal(found, speckled(points, edge, 0.6, 12))


def test_dots_are_seen_on_the_outer_part_alone(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    faults = draw_faults('depth_bias_by_region/speckled', setup)
    for pose in (0, 2):
        seen = []
        for each in (faults, replace(faults, region_dot=0.0)):
            view = true_rendering(plain, setup, setup.observations[pose], each, rests[pose])
            seen.append(tip_part(view.labels) > 0.0)
        dots, whole = seen
        assert not dots[~whole].any()
        assert not dots[view.labels == FIXTURE].any()
        assert dots.sum() / whole.sum() == pytest.approx(faults.region_cover, abs=0.2)


def test_a_camera_is_leaned_on_in_one_pose_and_springs_back_but_for_a_part(
    setup: Setup, plain: Specimen
) -> None:
    faults = draw_faults('camera_offset/leaned on', setup)
    scatter = np.array(faults.camera_scatter)
    leaned = int(np.abs(scatter).sum(axis=1).argmax())
    assert leaned in (1, 2)
    assert not scatter[:leaned].any()
    left = np.linalg.norm(scatter[-1]) / np.linalg.norm(scatter[leaned])
    assert 0.1 <= left <= 0.25
    for after in scatter[leaned + 1 :]:
        assert after == pytest.approx(left * scatter[leaned], abs=2e-4)
    assert 8.0 < np.linalg.norm(scatter[leaned, :3]) < 12.0
    stored = np.linalg.inv(setup.depth_from_world)
    moved = []
    for pose in setup.observations:
        found = np.linalg.inv(true_camera(plain, setup, jostled(setup, pose, faults)))
        moved.append(
            np.rad2deg(Rotation.from_matrix(found[:3, :3] @ stored[:3, :3].T).magnitude())
        )
    assert moved == pytest.approx(np.linalg.norm(scatter[:, 3:], axis=1), abs=1e-4)


def test_a_mouth_draws_towards_itself_by_the_fourth_power_of_the_way() -> None:
    mouth = np.array([0.1, 0.05, -0.2])
    faults, side = Faults(tilt_point=tuple(mouth)), np.array([1.2, 0.0, -1.6])
    here, half, beyond = drawn_in(
        np.array([[0.0, 0.0, 0.0], 0.5 * mouth, 3.0 * mouth]), side, faults
    )
    ahead = mouth / np.linalg.norm(mouth)
    assert here == pytest.approx(2.0 * ahead)
    assert half == pytest.approx(32.0 * ahead)
    assert beyond == pytest.approx(-0.125 * ahead)
    # As large at all places that are as far from it.
    ways = np.random.default_rng(3).standard_normal((20, 3))
    ways *= 0.13 / np.linalg.norm(ways, axis=1)[:, None]
    sizes = np.linalg.norm(drawn_in(mouth + ways, side, faults), axis=1)
    assert sizes == pytest.approx(2.0 * (np.linalg.norm(mouth) / 0.13) ** 4)


def test_an_extractor_draws_a_body_towards_its_mouth(setup: Setup) -> None:
    faults = draw_faults('gravity_tilt/extractor', setup)
    tip = make_specimen(setup, Faults(), COARSE).shares > 0.99
    # A tilt about x draws along -z, one about z along x: towards the mouth, seen from above.
    level = np.array([faults.gravity_tilt[1], -faults.gravity_tilt[0]])
    mouth = np.array(faults.tilt_point)
    assert level / np.linalg.norm(level) == pytest.approx(
        mouth[[0, 2]] / np.linalg.norm(mouth[[0, 2]]), abs=1e-3
    )
    for pose in range(4):
        hanging, found = (rest_of(setup, each, pose)[tip] for each in (Faults(), faults))
        world = setup.observations[pose].world_from_object
        ahead = mouth - world[:3, :3] @ hanging.mean(axis=0) - world[:3, 3]
        moved = world[:3, :3] @ (found - hanging).mean(axis=0)
        # What draws along a body does not move it: a quarter of the way at least is left.
        assert moved @ ahead > 0.25 * np.linalg.norm(moved) * np.linalg.norm(ahead)


@pytest.mark.parametrize('at', [0.3, 0.55])
def test_what_was_weighed_down_is_bent_most_below_the_weight(setup: Setup, at: float) -> None:
    shape = setup.shape
    free = shape.length - shape.clamp
    nodes = np.zeros((1201, 3))
    nodes[:, 0] = shape.clamp + np.linspace(0.0, 1.0, 1201) * free
    faults = Faults(rest_curvature=(0.0, 0.2), curvature_form='weighed down', curvature_at=at)
    bent = stress_free_nodes(nodes, shape, faults)
    steps = np.diff(bent, axis=0)
    slopes = np.arctan2(steps[:, 1], steps[:, 0])
    # Twelve arcs: by how much each turns, and the triangle that this is.
    turns = np.diff(slopes[[0, *range(100, 1200, 100), 1199]])
    middles = (np.arange(12) + 0.5) / 12.0
    triangle = np.interp(middles, [0.0, at, 1.0], [0.0, 1.0, 0.0])
    assert turns / turns.sum() == pytest.approx(triangle / triangle.sum(), abs=2e-3)
    # The tip is as far off as that of an arc.
    assert bent[-1, 1] == pytest.approx(0.5 * 0.2 * free**2, rel=0.01)
    assert not bent[:, 2].any()
