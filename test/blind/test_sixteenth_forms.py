# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the sixteenth set do what their labels say."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.blind_contact import check_pushes, moves_and_dents
from support.blind_draws import draw_faults, STEPS
from support.blind_rests import clamp_motion_and_load, COARSE, rest_of, tip_rises, turn_of
from support.blind_views import with_and_without

from benchmarks.blind.contact import contact_laws
from benchmarks.blind.draught import layer_share
from benchmarks.blind.faults import Faults
from benchmarks.blind.fibres import Fibres
from benchmarks.blind.flexure import angle_compliance
from benchmarks.blind.laying import lay_on_plane, softer
from benchmarks.blind.moduli import pour_value
from benchmarks.blind.observe import jostled, true_camera, true_rendering
from benchmarks.blind.paint import FIXTURE, Paint, TIP, tip_part, turned_share
from benchmarks.blind.rest_shape import stress_free_nodes
from benchmarks.blind.setups import draw_setup, GRAVITY, Setup
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.slender import even_sag, levers, SHARES, softness
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.surface import body_triangles


@pytest.mark.parametrize('step', STEPS)
def test_beads_push_by_their_energy_and_bear_no_pull(step: float) -> None:
    beads = Fibres(np.array(3e4), np.array([1.0, 0.0, 0.0]), pressed=True, knit=True)
    pressed = np.diag([0.93, 1.03, 1.03]) + np.random.default_rng(1).uniform(-0.02, 0.02, (3, 3))
    move = np.random.default_rng(2).standard_normal((3, 3))
    one, other = (beads.energy(pressed + way * step * move) for way in (1.0, -1.0))
    slope = float((beads.stress(pressed) * move).sum())
    assert slope != 0.0
    assert beads.energy(pressed) > 0.0
    assert (one - other) / (2.0 * step) == pytest.approx(slope, rel=1e-5)
    assert not beads.stress(np.diag([1.05, 0.98, 0.98])).any()
    assert beads.energy(np.eye(3)) == 0.0


@pytest.mark.parametrize('step', [1e-7, 1e-8, 1e-9])
def test_a_beaded_body_resists_as_its_forces_change(setup: Setup, step: float) -> None:
    specimen = make_specimen(setup, Faults(stiffening_form='beaded', stiffening=2.0), COARSE)
    body, random = specimen.body, np.random.default_rng(2)
    (rows,) = body.numbers.network
    # The energy's second derivative by a strain e, whose square falls by 2 e, where that is 0.1.
    assert 24.0 * rows.stiffness * 0.1 == pytest.approx(2.0 * setup.youngs_modulus)
    pressed = specimen.mesh.nodes * np.array([0.97, 1.01, 1.01])
    pressed = pressed + 1e-4 * random.standard_normal(pressed.shape)
    move = random.standard_normal(pressed.shape)
    one, other = (body.evaluate(pressed + way * step * move).gradient for way in (1.0, -1.0))
    blocks = np.asarray(body.evaluate(pressed).blocks)
    parts = np.einsum('cij,cj->ci', blocks, move[body.cells].reshape(len(blocks), -1))
    whole = np.zeros_like(pressed)
    np.add.at(whole, body.cells, parts.reshape(*body.cells.shape, 3))
    found = (one - other) / (2.0 * step)
    assert np.allclose(found, whole, rtol=0.0, atol=1e-4 * np.abs(whole).max())


def test_a_beaded_body_sags_less_than_a_bare_one(setup: Setup) -> None:
    soft = softer(setup, 0.3)
    drawn = [draw_faults('strain_stiffening/beaded', soft, size) for size in (1, 2)]
    lifts = tip_rises(soft, drawn)
    assert 0.002 < lifts[0] < lifts[1] < 0.015


def test_each_pour_has_its_own_modulus_from_the_clamp_on(setup: Setup) -> None:
    values = (0.5, -1.0, 0.25, 0.75, -0.5)
    places = np.array([0.0, 0.19, 0.21, 0.5, 0.79, 0.81, 1.0])
    expected = [0.5, 0.5, -1.0, 0.25, 0.75, -0.5, -0.5]
    assert pour_value(places, values) == pytest.approx(expected)
    assert not pour_value(places, ()).any()
    faults = Faults(contrast=0.8, contrast_mode='pours', contrast_pours=values)
    poured, whole = (make_specimen(setup, each) for each in (faults, Faults()))
    harder = np.log(np.asarray(poured.body.numbers.shear / whole.body.numbers.shear))
    share = whole.shares[whole.mesh.cells] @ whole.body.quadrature.values.T
    for number, value in enumerate(values):
        inside = (share > 0.2 * number) & (share < 0.2 * (number + 1))
        assert harder[inside] == pytest.approx(0.8 * value)


def test_pours_have_e_in_the_mean_and_differ(setup: Setup) -> None:
    faults = draw_faults('stiffness_contrast/pours', setup)
    assert sum(faults.contrast_pours) == pytest.approx(0.0, abs=1e-3)
    assert max(np.abs(faults.contrast_pours)) == 1.0


def test_an_angle_iron_gives_way_as_all_its_slices_do_and_aside_of_its_load() -> None:
    length, count, slant = 0.06, 2000, np.deg2rad(40.0)
    found = angle_compliance(0.3, length, 40.0)
    # Its weak axis is turned from y towards z; about the other it is four times as stiff.
    turned = Rotation.from_rotvec([slant, 0.0, 0.0]).as_matrix()
    per_slice = turned @ np.diag([0.3, 0.3, 0.075]) @ turned.T / count
    whole = np.zeros((6, 6))
    for number in range(count):
        arm = np.array([(1.0 - (number + 0.5) / count) * length, 0.0, 0.0])
        carried = np.concatenate([np.cross(arm, np.eye(3)), np.eye(3)])
        whole += carried @ per_slice @ carried.T
    assert np.allclose(found, whole, rtol=0.0, atol=1e-6 * np.abs(whole).max())
    assert np.allclose(found, found.T, rtol=0.0, atol=1e-15)
    shift = found[:3] @ np.array([0.0, 0.0, -1.0, 0.0, 0.0, 0.0])
    assert abs(shift[1]) > 0.3 * abs(shift[2])


@pytest.mark.parametrize('pose', range(4))
def test_a_clamp_on_an_angle_iron_rests_where_that_bears_the_body(
    setup: Setup, plain: Specimen, pose: int
) -> None:
    faults = draw_faults('compliant_clamp/angle iron', setup)
    motion, load = clamp_motion_and_load(setup, plain, faults, pose)
    compliance = angle_compliance(faults.clamp_compliance, faults.clamp_length, faults.clamp_slant)
    expected = compliance @ load
    assert motion[:3] == pytest.approx(expected[:3], abs=2e-5)
    assert motion[3:] == pytest.approx(expected[3:], abs=2e-3)


def test_a_clamp_is_shaken_on_by_how_far_the_rig_is_turned(setup: Setup, plain: Specimen) -> None:
    faults = draw_faults('clamp_offset/shaken', setup)
    poses = [Rotation.from_matrix(one.world_from_object[:3, :3]) for one in setup.observations]
    ways = [(poses[n + 1] * poses[n].inv()).magnitude() for n in range(3)]
    last, held = np.array(faults.clamp_scatter[-1]), plain.mesh.held
    for pose in range(4):
        share, rest = sum(ways[:pose]) / sum(ways), rest_of(setup, faults, pose)
        assert np.array(faults.clamp_scatter[pose]) == pytest.approx(share * last, abs=2e-4)
        turn = turn_of(plain.mesh.nodes[held], rest[held])
        assert turn == pytest.approx(share * np.deg2rad(last[3:]), abs=1e-4)


@pytest.fixture(scope='module')
def on_a_brush(setup: Setup) -> tuple[Setup, Faults]:
    """A set-up whose body lies on a brush in the first pose, and that brush."""
    return lay_on_plane(setup, draw_faults('contact_plane/brush', setup), np.random.default_rng(1))


def test_a_brush_bears_a_body_and_lets_its_tip_sink_in(
    on_a_brush: tuple[Setup, Faults], plain: Specimen
) -> None:
    laid, faults = on_a_brush
    moves, dents = moves_and_dents(laid, plain, faults)
    assert [dent > 0.3 * faults.contact_bend for dent in dents] == [True, False, True, False]
    assert 0.007 < moves[0] < 0.013
    assert moves[0] > moves[2] > 0.001
    assert moves[1] == moves[3] == 0.0


@pytest.mark.parametrize('step', STEPS)
def test_a_brush_pushes_by_its_energy(
    on_a_brush: tuple[Setup, Faults], plain: Specimen, step: float
) -> None:
    laid, faults = on_a_brush
    check_pushes(laid, plain, faults, step)


def test_bristles_that_are_bent_over_press_no_more(
    on_a_brush: tuple[Setup, Faults], plain: Specimen
) -> None:
    laid, faults = on_a_brush
    (law,) = contact_laws(plain.areas, plain.shares, laid.observations[0], faults)
    up = laid.observations[0].world_from_object[1, :3]
    for deep in (0.2, 0.3):
        pushes = -law(plain.mesh.nodes - deep * up).gradient @ up
        assert pushes == pytest.approx(faults.contact_pressure * plain.areas)


def test_a_smudge_errs_most_in_its_middle_and_falls_around_it(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    faults = draw_faults('depth_affine/smudge', setup)
    x, y = np.array(faults.depth_spot) + np.array([setup.camera.cx, setup.camera.cy])
    for pose in (0, 3):
        view, right, there = with_and_without(plain, setup, faults, pose, rests[pose])
        rows, columns, _ = np.nonzero(there)
        away = np.hypot(columns + right.column - x, rows + right.row - y) / faults.depth_width
        expected = 1e-3 * faults.depth_bias * np.exp(-(away**2))
        assert view.depth[there] - right.depth[there] == pytest.approx(expected, abs=1e-9)
        assert 0.008 < np.abs(expected).max() < 0.013


def test_turns_are_counted_around_a_section_that_is_wide_or_not() -> None:
    lattice = np.array([[0.0, -0.02, -0.005], [0.1, 0.02, 0.005]])
    corners = np.array([[0.02, 0.0], [0.02, 0.005], [0.0, 0.005], [-0.02, 0.0], [0.02, -0.005]])
    points = np.concatenate([np.full((5, 1), 0.03), corners], axis=1)
    expected = [0.0, 0.125, 0.25, 0.5, 0.875]
    assert turned_share(points, lattice) == pytest.approx(expected)


def test_a_wound_tape_goes_on_by_its_distance_in_a_turn(setup: Setup, plain: Specimen) -> None:
    begin, distance = 0.3, 0.3
    surface = body_triangles(
        plain.mesh,
        plain.mesh.nodes,
        plain.shares,
        Paint(begin, bands=(distance, 0.5), is_wound=True),
    )
    middles = surface.corners.mean(axis=1)
    share = (middles[:, 0] - setup.shape.clamp) / (setup.shape.length - setup.shape.clamp)
    across = middles[:, 1:] / (0.5 * np.array(setup.shape.section))
    phases = []
    for y, z in ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)):
        # Along the middle of one side, over two turns.
        near = np.abs(across - np.array([y, z])).max(axis=1) < 0.25
        chosen = near & (surface.labels == TIP) & (share > begin) & (share < begin + 2 * distance)
        assert chosen.any()
        phases.append(np.angle(np.exp(2j * np.pi * share[chosen] / distance).mean()))
    turned = np.diff(phases) / (2.0 * np.pi) % 1.0
    assert turned == pytest.approx(0.25, abs=0.06)


def test_a_wound_tape_covers_its_part_and_not_as_bands_do(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    faults = draw_faults('depth_bias_by_region/wound', setup)
    seen = {}
    for name, each in (
        ('wound', faults),
        ('bands', replace(faults, region_wound=False)),
        ('all', replace(faults, region_bands=(0.0, 0.0))),
    ):
        view = true_rendering(plain, setup, setup.observations[0], each, rests[0])
        seen[name] = tip_part(view.labels) > 0.0
    body = view.labels != FIXTURE
    assert not seen['wound'][~seen['all']].any()
    assert (seen['wound'] != seen['bands'])[body].any()
    part = seen['wound'].sum() / seen['all'].sum()
    assert part == pytest.approx(faults.region_bands[1], abs=0.15)


def test_a_camera_leans_about_its_foot_to_the_heavy_side(setup: Setup, plain: Specimen) -> None:
    faults = draw_faults('camera_offset/swayed', setup)
    assert faults.camera_foot is not None
    stored = np.linalg.inv(setup.depth_from_world)
    foot = stored[:3, :3] @ np.array(faults.camera_foot) + stored[:3, 3]
    leans, levels = [], []
    for pose in setup.observations:
        found = np.linalg.inv(true_camera(plain, setup, jostled(setup, pose, faults)))
        turn = Rotation.from_matrix(found[:3, :3] @ stored[:3, :3].T)
        assert found[:3, 3] == pytest.approx(foot + turn.apply(stored[:3, 3] - foot), abs=1e-9)
        # By a turn about a level axis, its top goes to where that takes what is up.
        assert turn.as_rotvec()[1] == pytest.approx(0.0, abs=1e-5)
        leans.append(np.cross(turn.as_rotvec(), [0.0, 1.0, 0.0])[[0, 2]])
        levels.append(pose.world_from_object[[0, 2], 1:3])
    # Seen from above it leans to one place of the rig, whatever the pose.
    heavy = np.linalg.lstsq(np.concatenate(levels), np.concatenate(leans), rcond=None)[0]
    assert np.array(levels) @ heavy == pytest.approx(np.array(leans), abs=1e-5)
    assert 0.9 < np.rad2deg(np.linalg.norm(heavy)) < 1.3


def test_air_over_a_bench_presses_by_the_square_of_the_height() -> None:
    faults = Faults(tilt_above=0.08)
    heights = np.array([-0.1, -0.08, -0.04, 0.0, 0.04])
    places = np.stack([np.full(5, 0.3), heights, np.full(5, -0.2)], axis=-1)
    found = layer_share(places, np.array([0.3, 0.0, 1.0]), faults)
    assert found == pytest.approx([0.0, 0.0, 0.25, 1.0, 2.25])


def test_air_presses_a_body_less_where_that_is_nearer_to_the_bench(setup: Setup) -> None:
    faults = draw_faults('gravity_tilt/layer', setup)
    tip = make_specimen(setup, Faults(), COARSE).shares > 0.99
    moves = []
    for lower in (0.0, 0.03, 0.2):
        poses = []
        for one in setup.observations:
            matrix = one.world_from_object.copy()
            matrix[1, 3] -= lower
            poses.append(replace(one, world_from_object=matrix))
        lowered = replace(setup, observations=tuple(poses))
        away = rest_of(lowered, faults, 1) - rest_of(lowered, Faults(), 1)
        moves.append(float(np.linalg.norm(away[tip].mean(axis=0))))
    assert moves[0] > moves[1] > moves[2] == 0.0


def test_a_folded_body_turns_one_way_and_then_a_part_of_that_back(setup: Setup) -> None:
    shape = setup.shape
    free = shape.length - shape.clamp
    nodes = np.zeros((201, 3))
    nodes[:, 0] = shape.clamp + np.linspace(0.0, 1.0, 201) * free
    faults = Faults(
        rest_curvature=(0.0, 1.5),
        curvature_form='folded',
        curvature_at=0.3,
        curvature_again=0.7,
        curvature_back=0.6,
    )
    folded = stress_free_nodes(nodes, shape, faults)
    steps = np.diff(folded, axis=0)
    slopes = np.arctan2(steps[:, 1], steps[:, 0])
    whole = 1.5 * free
    assert slopes[:49] == pytest.approx(0.0, abs=1e-12)
    assert slopes[71:129] == pytest.approx(whole, abs=1e-9)
    assert slopes[151:] == pytest.approx(0.4 * whole, abs=1e-9)
    assert np.linalg.norm(steps, axis=1) == pytest.approx(free / 200.0, rel=1e-4)


def test_levers_are_those_of_slender_beams() -> None:
    setup = draw_setup('beam', is_sealed=True, poses=4, random=np.random.default_rng(1))
    assert softness(setup) == pytest.approx(1.0)
    assert levers(setup) == pytest.approx(0.5 * SHARES**2 * (3.0 - SHARES) / 0.375, abs=1e-4)
    mass = setup.density * np.prod(setup.shape.section) * (setup.shape.length - setup.shape.clamp)
    low, high = sorted(setup.shape.section)
    stiff = setup.youngs_modulus * high * low**3 / 12.0
    free = setup.shape.length - setup.shape.clamp
    assert even_sag(setup) == pytest.approx(mass * GRAVITY * free**3 / (8.0 * stiff), rel=1e-3)


def test_a_waist_is_soft_in_its_middle_and_a_crossbar_is_heavy() -> None:
    waist, tee = (
        draw_setup(family, is_sealed=True, poses=4, random=np.random.default_rng(1))
        for family in ('waist', 'tee')
    )
    thin = 1.0 - waist.shape.waist
    assert softness(waist).max() == pytest.approx(thin**-4.0, rel=1e-3)
    bar = replace(tee.shape, family='beam', solid=tee.shape.solid & tee.shape.solid[:1])
    assert even_sag(tee) > 1.2 * even_sag(replace(tee, shape=bar))
