# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the eighteenth set do what their labels say."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.blind_contact import check_pushes, dents_of
from support.blind_derivatives import check_body_stiffness, check_loose_fibres
from support.blind_draws import draw_faults, STEPS
from support.blind_rests import COARSE, lying, rest_of, tip_moves, tip_rises
from support.blind_views import with_and_without

from benchmarks.blind.bounce import bounced_share
from benchmarks.blind.contact import contact_laws, highest_tops
from benchmarks.blind.faults import Faults
from benchmarks.blind.fibres import Fibres
from benchmarks.blind.laying import lay_on_plane, softer
from benchmarks.blind.masses import tip_direction
from benchmarks.blind.moduli import settled_share
from benchmarks.blind.observe import jostled, true_camera, true_rendering
from benchmarks.blind.paint import FIXTURE, tip_part
from benchmarks.blind.rest_shape import stress_free_nodes
from benchmarks.blind.setups import draw_setup, GRAVITY, Setup
from benchmarks.blind.simulation import make_specimen, settle
from benchmarks.blind.specimen import Specimen


def test_a_tool_has_its_middle_ahead_of_the_tip(setup: Setup) -> None:
    faults = Faults(mass_form='tool', added_mass=9.0, added_mass_at=0.94, mass_ahead=20.0)
    tool = make_specimen(setup, faults)
    free = setup.shape.length - setup.shape.clamp
    assert 1e3 * tool.added.sum() == pytest.approx(9.0)
    middle = tool.added @ tool.mesh.nodes / tool.added.sum()
    # A foot is of whole cells: some tenths of a millimetre beside its place.
    assert middle[0] == pytest.approx(setup.shape.clamp + 0.94 * free + 0.02, abs=1.5e-3)
    assert middle[0] > setup.shape.length
    assert middle[1:] == pytest.approx([0.0, 0.0], abs=1e-6)


def test_a_tool_points_on_along_an_arch() -> None:
    setup = draw_setup('arch', is_sealed=True, poses=4, random=np.random.default_rng(3))
    shape = setup.shape
    turned = Rotation.from_rotvec([0.0, 0.0, shape.arch * (shape.length - shape.clamp)])
    assert tip_direction(setup) == pytest.approx(turned.apply([1.0, 0.0, 0.0]), abs=1e-4)
    faults = draw_faults('added_mass/tool', setup)
    ahead, foot = (
        own.added @ own.mesh.nodes / own.added.sum()
        for own in (make_specimen(setup, each) for each in (faults, replace(faults, mass_ahead=0)))
    )
    assert ahead - foot == pytest.approx(1e-3 * faults.mass_ahead * tip_direction(setup), abs=1e-5)


def test_a_tool_bends_a_body_as_its_weight_and_moment_ask(setup: Setup) -> None:
    faults = Faults(mass_form='tool', added_mass=2.0, added_mass_at=0.94, mass_ahead=20.0)
    specimen = make_specimen(setup, Faults(), COARSE)
    tip = specimen.shares > 0.99
    width, height = setup.shape.section
    bends = setup.youngs_modulus * width * height**3 / 12.0
    moves = []
    for each in (Faults(), replace(faults, mass_ahead=0.0), faults):
        moves.append(float(rest_of(setup, each)[tip, 2].mean()))
    free = setup.shape.length - setup.shape.clamp
    # Bernoulli's beam with a moment at its outer end, which the weight's part across it has.
    across = float(-setup.observations[0].world_from_object[1, 2])
    moment = 2e-3 * GRAVITY * across * 0.02
    assert moves[2] - moves[1] == pytest.approx(0.5 * moment * free**2 / bends, rel=0.15)
    assert moves[1] < moves[0]


@pytest.mark.parametrize('step', STEPS)
def test_loose_threads_pull_by_their_energy_once_they_are_taut(step: float) -> None:
    threads = Fibres(np.array(3e4), np.array([1.0, 0.0, 0.0]), slack=True, loose=0.04)
    drawn = np.diag([1.08, 0.97, 0.97]) + np.random.default_rng(1).uniform(-0.02, 0.02, (3, 3))
    check_loose_fibres(threads, drawn, step, still=(1.019, 1.0, 0.95))


@pytest.mark.parametrize('step', [1e-7, 1e-8, 1e-9])
def test_a_threaded_body_resists_as_its_forces_change(setup: Setup, step: float) -> None:
    faults = Faults(stiffening_form='threaded', stiffening=2.0, stiffening_from=0.01)
    specimen = make_specimen(setup, faults, COARSE)
    (threads,) = specimen.body.numbers.network
    stiffness = 8.0 * np.asarray(threads.stiffness) / setup.youngs_modulus
    assert set(np.unique(np.round(stiffness, 9))) == {0.0, 2.0}
    check_body_stiffness(specimen.body, specimen.mesh.nodes, step=step)


def test_a_threaded_body_sags_less_than_a_bare_one(setup: Setup) -> None:
    soft = softer(setup, 0.3)
    lifts = tip_rises(
        soft, [draw_faults('strain_stiffening/threaded', soft, size) for size in (1, 2)]
    )
    assert 0.002 < lifts[0] < lifts[1] < 0.02


def test_what_settled_falls_evenly_from_the_clamp_to_its_end(setup: Setup) -> None:
    places = np.array([0.0, 0.15, 0.3, 0.6, 0.61, 1.0])
    assert settled_share(places, 0.6) == pytest.approx([1.0, 0.75, 0.5, 0.0, 0.0, 0.0])
    faults = Faults(contrast=1.4, contrast_mode='settled', contrast_at=0.6)
    graded, whole = (make_specimen(setup, each) for each in (faults, Faults()))
    harder = np.log(np.asarray(graded.body.numbers.shear / whole.body.numbers.shear))
    share = whole.shares[whole.mesh.cells] @ whole.body.quadrature.values.T
    assert harder == pytest.approx(1.4 * np.interp(share, [0.0, 0.6], [1.0, 0.0]))


def test_jaws_that_gape_hold_a_body_farther_in_alone(setup: Setup, plain: Specimen) -> None:
    faults = Faults(clamp_gape=8.0)
    gaping = make_specimen(setup, faults, COARSE)
    inner = gaping.mesh.nodes[gaping.body.held]
    assert inner[:, 0].max() == pytest.approx(setup.shape.clamp - 0.008)
    for pose in (0, 3):
        rest = rest_of(setup, faults, pose)
        # What is held stays, and all else weighs and is as long as it was.
        assert rest[gaping.body.held] == pytest.approx(inner, abs=1e-12)
    assert gaping.body.masses.sum() == pytest.approx(plain.body.masses.sum())
    assert gaping.center == pytest.approx(plain.center)


def test_a_body_in_jaws_that_gape_sags_as_a_longer_beam(setup: Setup) -> None:
    free, gape = setup.shape.length - setup.shape.clamp, 0.012
    sags = []
    for faults in (Faults(), Faults(clamp_gape=1e3 * gape)):
        specimen = make_specimen(setup, faults)
        rest = settle(specimen, setup, setup.observations[0], faults)
        tip = specimen.shares > 0.99
        sags.append(float((specimen.mesh.nodes - rest)[tip, 2].mean()))
    # Bernoulli's beam by its own weight: by the fourth power of its length; shear adds less.
    assert sags[1] / sags[0] == pytest.approx((1.0 + gape / free) ** 4, rel=0.06)


def test_jaws_that_gape_move_a_tip_by_some_4_and_10_mm(setup: Setup, plain: Specimen) -> None:
    for size, least, most in ((1, 2.5, 6.0), (2, 6.0, 16.0)):
        faults = draw_faults('compliant_clamp/gaping', setup, size)
        tip = make_specimen(setup, faults, COARSE).shares > 0.99
        moves = tip_moves(setup, plain, faults, tip)
        assert least < 1e3 * max(moves) < most


@pytest.fixture(scope='module')
def on_a_crate(setup: Setup) -> tuple[Setup, Faults]:
    """A set-up whose body lies on a crate's foam in the first pose, and that foam."""
    return lay_on_plane(setup, draw_faults('contact_plane/crate', setup), np.random.default_rng(1))


def test_a_crate_bears_a_body_by_its_crests(
    on_a_crate: tuple[Setup, Faults], plain: Specimen
) -> None:
    laid, faults = on_a_crate
    assert faults.contact_height is not None
    moves = []
    for pose in range(4):
        found, move = lying(laid, plain, faults, pose)
        moves.append(move)
        dents = dents_of(laid, faults, found, pose)
        assert (dents.max() > 0.0) == (pose in (0, 2))
        assert dents.max() < 0.009
    assert 0.006 < moves[0] < 0.013
    assert moves[2] > 0.001
    assert moves[1] == moves[3] == 0.0


def test_a_crate_has_a_crest_every_wave_and_troughs_between() -> None:
    faults = Faults(
        contact_form='crate',
        contact_ahead=0.02,
        contact_at=-0.01,
        contact_wave=0.04,
        contact_trough=0.012,
    )
    steps = np.array([[0.0, 0.0], [1.0, 0.0], [0.5, 0.5], [0.5, 0.0], [0.0, 0.5], [0.25, 0.1]])
    places = np.full((6, 3), 0.3)
    places[:, [0, 2]] = np.array([0.02, -0.01]) + 0.04 * steps
    # Crests also amid four, troughs beside each; halfway up where one way is a quarter.
    lower = 0.012 * np.array([0.0, 0.0, 0.0, 1.0, 1.0, 0.5])
    assert highest_tops(places, faults) == pytest.approx(0.3 + lower)


@pytest.mark.parametrize('step', STEPS)
def test_a_crate_pushes_by_its_energy(
    on_a_crate: tuple[Setup, Faults], plain: Specimen, step: float
) -> None:
    laid, faults = on_a_crate
    check_pushes(laid, plain, faults, step)


def test_a_crate_presses_upright_by_its_stiffness_where_it_is_dented(
    on_a_crate: tuple[Setup, Faults], plain: Specimen
) -> None:
    laid, faults = on_a_crate
    assert faults.contact_height is not None
    (law,) = contact_laws(plain.areas, plain.shares, laid.observations[0], faults)
    found, up = rest_of(laid, faults), laid.observations[0].world_from_object[1, :3]
    pushes, dents = -law(found).gradient @ up, dents_of(laid, faults, found)
    assert pushes.max() > 0.0
    expected = faults.contact_stiffness * plain.areas * np.maximum(dents, 0.0)
    assert pushes == pytest.approx(expected)


def test_bounced_light_errs_by_the_inverse_square_of_the_way_from_its_sheet(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    faults = draw_faults('depth_affine/bounced', setup)
    sheet = np.array(faults.depth_point)
    assert -0.2 < sheet[1] < -0.15
    camera = setup.camera
    for pose in (0, 3):
        view, right, there = with_and_without(plain, setup, faults, pose, rests[pose])
        rows, columns, _ = np.nonzero(there)
        # Back through the stored camera to the world, whose places the pixels see again.
        depths = right.depth[there]
        pixels = np.stack([columns + right.column, rows + right.row], axis=-1)
        rays = (pixels - np.array([camera.cx, camera.cy])) / np.array([camera.fx, camera.fy])
        seen = depths[:, None] * np.column_stack([rays, np.ones(len(rays))])
        assert camera.project(seen) == pytest.approx(pixels, abs=1e-9)
        world = np.linalg.inv(setup.depth_from_world)
        ways = np.linalg.norm(seen @ world[:3, :3].T + world[:3, 3] - sheet, axis=1)
        expected = 1e-3 * faults.depth_bias * (np.linalg.norm(sheet) / ways) ** 2
        assert view.depth[there] - depths == pytest.approx(expected, abs=1e-9)
        assert 0.006 < expected.max() < 0.017
        empty = bounced_share(right, setup, faults.depth_point)[~there]
        assert np.isfinite(empty).all()


def test_strips_lie_along_the_middle_of_each_side(setup: Setup) -> None:
    faults = draw_faults('depth_bias_by_region/lengthwise', setup)
    body = make_specimen(setup, Faults())
    for pose in (0, 1, 3):
        seen = []
        for each in (faults, replace(faults, region_strip=0.0)):
            view = true_rendering(body, setup, setup.observations[pose], each, body.mesh.nodes)
            seen.append(tip_part(view.labels) > 0.0)
        strips, whole = seen
        assert not strips[~whole].any()
        assert not strips[view.labels == FIXTURE].any()
        assert strips.sum() / whole.sum() == pytest.approx(faults.region_strip, abs=0.15)


def test_a_strip_ends_as_far_from_the_middle_as_stated() -> None:
    setup = draw_setup('beam', is_sealed=True, poses=4, random=np.random.default_rng(2))
    plain = make_specimen(setup, Faults())
    faults = Faults(region_bias=5.0, region_strip=0.5, region_from=0.0)
    pose = setup.observations[0]
    view, right = (
        true_rendering(plain, setup, pose, each, plain.mesh.nodes) for each in (faults, Faults())
    )
    wrong = np.isfinite(right.depth) & (view.depth != right.depth)
    rows, columns, samples = np.nonzero(wrong)
    camera = setup.camera
    # Of the nine samples of a pixel the place in the image, then that in the object frame.
    down, across = (samples // 3 - 1) / 3.0, (samples % 3 - 1) / 3.0
    x = (columns + across + right.column - camera.cx) / camera.fx
    y = (rows + down + right.row - camera.cy) / camera.fy
    seen = right.depth[wrong][:, None] * np.column_stack([x, y, np.ones(len(x))])
    back = np.linalg.inv(setup.depth_from_world @ pose.world_from_object)
    places = seen @ back[:3, :3].T + back[:3, 3]
    outward = np.abs(places[:, 1:]) / (0.5 * np.array(setup.shape.section))
    on_side = (outward > 0.999).any(axis=1) & (places[:, 0] < setup.shape.length - 1e-4)
    assert on_side.sum() > 500
    # Triangles are some 2 mm long.
    assert outward[on_side].min(axis=1).max() == pytest.approx(0.5, abs=0.25)
    assert outward[on_side].min(axis=1).min() < 0.05


def test_a_camera_is_put_back_a_little_otherwise_each_time(setup: Setup, plain: Specimen) -> None:
    faults = draw_faults('camera_offset/put back', setup)
    scatter = np.array(faults.camera_scatter)
    assert np.linalg.norm(scatter[:, 3:], axis=1) == pytest.approx(1.5, rel=0.16)
    # No pose is like another.
    apart = np.linalg.norm(scatter[:, None] - scatter[None], axis=-1)
    assert apart[~np.eye(4, dtype=bool)].min() > 0.5
    foot, stored = np.array(faults.camera_foot), np.linalg.inv(setup.depth_from_world)
    for pose, whole in zip(setup.observations, scatter, strict=True):
        shift, turn = whole[:3], whole[3:]
        found = np.linalg.inv(true_camera(plain, setup, jostled(setup, pose, faults)))
        turned = stored[:3, :3].T @ found[:3, :3]
        expected = Rotation.from_rotvec(turn, degrees=True).as_matrix()
        assert turned == pytest.approx(expected, abs=1e-6)
        # Its foot is where it was, but for the shift.
        away = stored[:3, :3].T @ (found[:3, :3] @ foot + found[:3, 3] - stored[:3, 3]) - foot
        assert 1e3 * away == pytest.approx(shift, abs=1e-3)


def test_a_fan_pushes_by_its_share_of_each_pose(setup: Setup) -> None:
    faults = draw_faults('gravity_tilt/fan', setup)
    assert max(faults.tilt_shares) == 1.0
    assert min(faults.tilt_shares) > 0.25
    for pose, share in enumerate(faults.tilt_shares):
        # A side force that is steady in the world, as large as that share.
        angles = np.deg2rad(faults.gravity_tilt)
        down = Rotation.from_rotvec([angles[0], 0.0, angles[1]]).apply([0.0, -1.0, 0.0])
        size = float(np.hypot(down[0], down[2])) * share
        ways = np.array([-down[2], down[0]]) / np.hypot(down[0], down[2])
        tilt = np.rad2deg(np.arcsin(size)) * ways
        steady = Faults(tilt_form='side_force', gravity_tilt=tuple(tilt))
        same = rest_of(setup, steady, pose)
        assert rest_of(setup, faults, pose) == pytest.approx(same, abs=2e-6)


@pytest.mark.parametrize('edge', [0.2, 0.45])
def test_what_hung_over_an_edge_is_straight_on_the_table(setup: Setup, edge: float) -> None:
    shape = setup.shape
    free = shape.length - shape.clamp
    shares = np.linspace(0.0, 1.0, 2401)
    nodes = np.zeros((2401, 3))
    nodes[:, 0] = shape.clamp + shares * free
    faults = Faults(rest_curvature=(0.0, 0.2), curvature_form='overhanging', curvature_at=edge)
    bent = stress_free_nodes(nodes, shape, faults)
    steps = np.diff(bent, axis=0)
    slopes = np.arctan2(steps[:, 1], steps[:, 0])
    middles = 0.5 * (shares[1:] + shares[:-1])
    assert slopes[middles < edge] == pytest.approx(0.0, abs=1e-12)
    # Beyond it, turned by the moment of the even load outside: what is left falls by its cube.
    whole = slopes[-1]
    left = ((1.0 - middles) / (1.0 - edge)) ** 3
    assert slopes[middles > edge] == pytest.approx(
        whole * (1.0 - left[middles > edge]), abs=0.04 * whole
    )
    assert bent[-1, 1] == pytest.approx(0.5 * 0.2 * free**2, rel=0.02)
    assert not bent[:, 2].any()
    lengths = np.linalg.norm(steps, axis=1)
    assert lengths.sum() == pytest.approx(free, rel=1e-6)
