# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the twenty-sixth set do what their labels say."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.spatial.transform import Rotation
from support.blind_derivatives import check_body_stiffness
from support.blind_draws import draw_faults, draw_sealed, SEALED
from support.blind_rests import (
    check_rests_where_borne,
    COARSE,
    moved_by_what_stiffens,
    rest_of,
)
from support.blind_views import region_errors, with_and_without

from benchmarks.blind.draught import spreading_share
from benchmarks.blind.faults import Faults
from benchmarks.blind.fibres import Fibres
from benchmarks.blind.filling import filled_shares, filling_masses
from benchmarks.blind.flexure import bobbin_compliance
from benchmarks.blind.loads import load_in_pose
from benchmarks.blind.moduli import gate_share
from benchmarks.blind.observe import jostled, true_camera
from benchmarks.blind.paint import FIXTURE, Paint, tip_part
from benchmarks.blind.rest_shape import stress_free_nodes
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.slender import aside_give, side_stiffness
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.speckle import stickered
from benchmarks.blind.surface import body_triangles


def test_a_cup_fills_as_fast_all_the_time() -> None:
    shares = filled_shares(4, 0.25)
    assert shares == pytest.approx((0.25, 0.5, 0.75, 1.0))
    assert np.diff(filled_shares(4, 0.4)) == pytest.approx(0.2, abs=2e-4)


def test_a_cup_loads_one_place_of_a_body_by_more_in_each_pose(
    setup: Setup, plain: Specimen
) -> None:
    faults, whole = draw_faults('added_mass/filling', setup), []
    for view in setup.observations:
        found = filling_masses(plain.body.masses, plain.shares, setup, view, faults)
        whole.append(1e3 * float(found.sum()))
        middle = float(found @ plain.shares / found.sum())
        assert middle == pytest.approx(faults.added_mass_at, abs=0.03)
        assert not found[np.abs(plain.shares - faults.added_mass_at) > 0.13].any()
    assert whole[-1] == pytest.approx(faults.added_mass)
    assert np.diff(whole, n=2) == pytest.approx(0.0, abs=1e-3 * faults.added_mass)
    assert 0.2 < whole[0] / whole[-1] < 0.45


def test_a_cup_draws_a_body_down_by_its_weight(setup: Setup) -> None:
    faults = draw_faults('added_mass/filling', setup)
    for pose, view in enumerate(setup.observations):
        own = replace(faults, mass_shares=(0.0,) * pose + faults.mass_shares[pose:])
        loaded, bare = (rest_of(setup, each, pose) for each in (own, Faults()))
        tip = make_specimen(setup, Faults(), COARSE).shares > 0.99
        assert ((loaded - bare)[tip] @ view.world_from_object[1, :3]).mean() < -0.0005


def test_a_mould_is_softer_the_farther_it_is_from_its_gate() -> None:
    share = np.array([0.0, 0.2, 0.35, 0.7, 0.85, 1.0])
    assert gate_share(share, 0.7) == pytest.approx([1.0, 5 / 7, 0.5, 0.0, 3 / 14, 3 / 7])
    # It is a mirror's where the gate is: 1 where farthest, be that the tip.
    assert gate_share(1.0 - share, 0.3) == pytest.approx(gate_share(share, 0.7))


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_gated_body_is_hardest_at_its_gate(family: str) -> None:
    drawn = draw_sealed(family)
    faults = draw_faults('stiffness_contrast/gated', drawn)
    soft, whole = (make_specimen(drawn, each) for each in (faults, Faults()))
    harder = np.log(np.asarray(soft.body.numbers.shear / whole.body.numbers.shear))
    mesh, values = whole.mesh, whole.body.quadrature.values
    places = mesh.lattice[mesh.cells].swapaxes(1, 2) @ values.T
    share = (places[:, 0] - drawn.shape.clamp) / (drawn.shape.length - drawn.shape.clamp)
    at, free = faults.contrast_at, share > 0.05
    # A line through two ends, on either side of the gate.
    slope = faults.contrast / at
    expected = np.where(share < at, slope * (at - share), slope * (share - at))
    assert harder[free] == pytest.approx(expected[free], abs=0.03)
    assert -4.0 < faults.contrast < -0.3
    assert harder.max() <= 0.0


@pytest.mark.parametrize('step', [1e-5, 1e-6, 1e-7])
def test_a_ruffled_tape_pulls_by_its_energy(setup: Setup, step: float) -> None:
    faults = Faults(stiffening_form='ruffled', stiffening=2.0, stiffening_from=0.04)
    (family,) = make_specimen(setup, faults, COARSE).body.numbers.network
    tape = replace(family, stiffness=np.array(3e4))
    drawn = np.diag([1.07, 0.97, 0.97]) + np.random.default_rng(1).uniform(-0.02, 0.02, (3, 3))
    move = np.random.default_rng(2).standard_normal((3, 3))
    one, other = (tape.energy(drawn + way * step * move) for way in (1.0, -1.0))
    slope = float((tape.stress(drawn) * move).sum())
    assert slope != 0.0
    assert (one - other) / (2.0 * step) == pytest.approx(slope, rel=1e-5)
    # It does not push, and at first it hardly pulls.
    assert not tape.stress(np.diag([0.95, 1.0, 1.0])).any()
    growth = np.array([0.004, 0.4])
    pulls = [
        float(tape.energy(np.diag([np.sqrt(1.0 + each), 1.0, 1.0]))) / (3e4 * each**2)
        for each in growth
    ]
    assert pulls == pytest.approx(growth / (growth + 0.04))


@pytest.mark.parametrize('step', [1e-7, 1e-8, 1e-9])
def test_a_body_with_a_tape_resists_as_its_forces_change(setup: Setup, step: float) -> None:
    faults = Faults(stiffening_form='ruffled', stiffening=2.0, stiffening_from=0.03)
    specimen = make_specimen(setup, faults, COARSE)
    check_body_stiffness(specimen.body, specimen.mesh.nodes * [1.03, 0.98, 0.98], step=step)


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_tape_lies_along_the_upper_side_of_every_body(family: str) -> None:
    drawn = draw_sealed(family)
    faults = draw_faults('strain_stiffening/ruffled', drawn)
    specimen = make_specimen(drawn, faults)
    (found,) = specimen.body.numbers.network
    assert isinstance(found, Fibres)
    there = np.broadcast_to(found.stiffness, specimen.heights.shape) > 0.0
    assert np.array_equal(there, specimen.heights > 0.5)
    # Of the highest row of points, and of no other.
    assert 0.1 < there.mean() < 0.3
    assert found.stiffness[there] == pytest.approx(
        faults.stiffening * drawn.youngs_modulus / 8.0, rel=1e-6
    )


def test_a_layer_along_one_side_is_as_stiff_as_a_cut_section_tells() -> None:
    stiff, part = side_stiffness(0.3, 0.25, 30.0), 0.25
    high = (np.arange(4000) + 0.5) / 4000.0
    bears = 1.0 + stiff * (high > 1.0 - part)
    middle = (bears * high).sum() / bears.sum()
    second = (bears * (high - middle) ** 2).mean()
    assert 1.0 - 1.0 / (12.0 * second) == pytest.approx(0.3, abs=2e-3)


# A fin hangs on a slant, and a tee's tip is heavy.
@pytest.mark.parametrize('family', ['arch', 'waist', 'fin', 'tee'])
def test_a_tape_holds_a_body_where_it_bends_down_and_not_upside_down(family: str) -> None:
    moves = moved_by_what_stiffens('strain_stiffening/ruffled', family)
    assert 0.0025 < moves[0] < 0.007
    assert 0.006 < moves[1] < 0.016


def test_four_bobbins_bear_by_what_each_is_pressed_and_sheared() -> None:
    by_turn, length = 0.4, 0.05
    # By shifts and turns of the clamp, how each bobbin is pressed and sheared.
    whole = np.zeros((6, 6))
    for ahead, aside in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
        place = 0.5 * length * np.array([ahead, 0.6 * aside, -1.0])
        carried = np.array([*np.eye(3), *np.cross(np.eye(3), place)]).T
        whole += carried.T @ np.diag([0.4, 0.4, 1.0]) @ carried
    expected = np.linalg.inv(whole)
    # About y through the bobbins' middle they are told: four springs half a length away.
    expected *= by_turn * length**2
    found = bobbin_compliance(by_turn, length)
    assert found == pytest.approx(expected, abs=1e-9)
    assert found[4, 4] == by_turn
    assert found[3, 3] == pytest.approx(by_turn / 0.36)


@pytest.mark.parametrize('pose', range(4))
def test_a_clamp_on_bobbins_rests_where_they_bear_the_body(
    setup: Setup, plain: Specimen, pose: int
) -> None:
    faults = draw_faults('compliant_clamp/bobbins', setup)
    compliance = bobbin_compliance(faults.clamp_compliance, faults.clamp_length)
    check_rests_where_borne(setup, plain, faults, pose, compliance)


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_table_that_was_homed_wrongly_turns_a_rig_about_one_upright_axis(family: str) -> None:
    drawn = draw_sealed(family)
    center = np.array([0.5 * drawn.shape.clamp, 0.0, 0.0])
    for size, most in ((1, 0.004), (2, 0.010)):
        turns, ways, behinds = [], [], []
        scatter = np.array(draw_faults('clamp_offset/homed', drawn, size).clamp_scatter)
        for motion, pose in zip(scatter, drawn.observations, strict=True):
            matrix = pose.world_from_object[:3, :3]
            inside = Rotation.from_rotvec(motion[3:], degrees=True)
            turns.append(matrix @ inside.as_rotvec())
            shift = 1e-3 * motion[:3]
            # What is on the axis stays: a place of the body's length.
            still = np.eye(3) - inside.as_matrix()
            behind = np.linalg.lstsq(still[:, :1], still @ center + shift, rcond=None)[0]
            assert still[:, :1] @ behind == pytest.approx(still @ center + shift, abs=1e-6)
            behinds.append(float(behind[0]))
            tip = np.array([drawn.shape.length, 0.0, 0.0])
            moved = matrix @ (inside.apply(tip - center) + center + shift - tip)
            assert moved[1] == pytest.approx(0.0, abs=1e-6)
            ways.append(float(np.linalg.norm(moved)))
        assert np.array(turns) == pytest.approx(np.tile(turns[0], (4, 1)), abs=4e-6)
        assert turns[0][[0, 2]] == pytest.approx(0.0, abs=4e-6)
        assert np.ptp(behinds) < 1e-4
        assert -0.0201 < behinds[0] < 1e-4
        assert max(ways) == pytest.approx(most, rel=0.16)


def test_a_body_on_a_table_that_was_homed_wrongly_is_turned_as_a_whole(
    setup: Setup, plain: Specimen
) -> None:
    faults = draw_faults('clamp_offset/homed', setup)
    for pose, view in enumerate(setup.observations):
        found, bare = rest_of(setup, faults, pose), rest_of(setup, Faults(), pose)
        # About the upright, gravity is the same: the body bends as before.
        turn = Rotation.from_rotvec(faults.clamp_scatter[pose][3:], degrees=True)
        assert found - found.mean(axis=0) == pytest.approx(
            turn.apply(bare - bare.mean(axis=0)), abs=1e-5
        )
        heights = (found - bare) @ view.world_from_object[1, :3]
        assert heights == pytest.approx(0.0, abs=1e-5)


def test_a_bent_guard_errs_by_the_square_of_the_way_across_its_bend(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    for size, most in ((1, 4.0), (2, 10.0)):
        faults = draw_faults('depth_affine/splash guard', setup, size)
        assert abs(faults.depth_bias) == pytest.approx(most, rel=0.16)
        # As a complex number, the way across the bend.
        across = np.exp(-1j * np.deg2rad(faults.depth_slant))
        for pose in range(4):
            view, right, there = with_and_without(plain, setup, faults, pose, rests[pose])
            rows, columns, _ = np.nonzero(there)
            ways = columns + right.column - setup.camera.cx - faults.depth_spot[0] + 0j
            ways += 1j * (rows + right.row - setup.camera.cy - faults.depth_spot[1])
            errors = 1e3 * (view.depth[there] - right.depth[there])
            expected = faults.depth_bias * ((ways * across).real / faults.depth_width) ** 2
            assert errors == pytest.approx(expected, abs=1e-6)
            # The fixture is farther off.
            spread = np.ptp(errors[right.labels[there] != FIXTURE])
            assert 0.3 * most < spread < 1.6 * most


def test_round_stickers_are_in_a_row_along_the_middle_of_each_side() -> None:
    apart, radius = 0.02, 0.008
    places = 0.01 * np.array([[0.0, 9.0, 0.0], [0.7, 9.0, 0.5], [0.7, 9.0, 0.8], [1.79, 9.0, 0.0]])
    assert stickered(places, 1, apart, radius).tolist() == [False, True, False, True]
    # The other side of a section by the other place across, and as far on as they are apart.
    turned = places[:, [0, 2, 1]] + np.array([3 * apart, 0.0, 0.0])
    assert stickered(turned, 2, apart, radius).tolist() == [False, True, False, True]
    assert not stickered(places, 0, apart, radius).any()
    random = np.random.default_rng(4).uniform(-0.01, 0.01, (40000, 3)) * [5.0, 1.0, 1.0]
    covered = float(stickered(random, 1, apart, radius).mean())
    assert covered == pytest.approx(np.pi * radius**2 / (apart * 0.02), abs=0.01)


def test_stickers_are_on_the_outer_part_of_a_body(setup: Setup, plain: Specimen) -> None:
    painted = body_triangles(
        plain.mesh, plain.mesh.nodes, plain.shares, Paint(0.25, stickers=(0.017, 0.008))
    )
    middles = painted.corners.mean(axis=1)
    outer = (middles[:, 0] - setup.shape.clamp) / (setup.shape.length - setup.shape.clamp) > 0.25
    parts = tip_part(painted.labels)
    assert not parts[~outer].any()
    assert set(np.unique(parts)) == {0.0, 1.0}
    assert 0.3 < parts[outer].mean() < 0.75


def test_what_has_stickers_on_it_errs_on_them_alone(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    faults = draw_faults('depth_bias_by_region/stickers', setup)
    for pose in range(4):
        error = region_errors(plain, setup, faults, pose, rests[pose])
        assert np.minimum(np.abs(error), np.abs(error - 1.0)).max() < 1e-6
        assert 0.25 < error.mean() < 0.7
    assert abs(faults.region_bias) == pytest.approx(12.0, rel=0.16)


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_camera_rolls_on_about_the_way_it_looks(family: str) -> None:
    drawn = draw_sealed(family)
    faults = draw_faults('camera_offset/rolled', drawn)
    plain = make_specimen(drawn, Faults(), COARSE)
    stored, rolls = np.linalg.inv(drawn.depth_from_world), []
    for pose in range(4):
        off = jostled(drawn, drawn.observations[pose], faults)
        found = np.linalg.inv(true_camera(plain, drawn, off))
        # It stays where it is, and looks the same way.
        assert found[:3, 2:] == pytest.approx(stored[:3, 2:], abs=1e-12)
        rolls.append(float(np.arctan2(found[:3, 0] @ stored[:3, 1], found[:3, 0] @ stored[:3, 0])))
    steps = np.diff(np.abs(rolls), prepend=0.0)
    assert (steps > 0.0).all()
    assert steps.max() < 5.1 * steps.min()
    half = 0.5 * (drawn.shape.length - drawn.shape.clamp)
    assert abs(rolls[-1]) * half == pytest.approx(0.010, rel=0.16)


def test_a_jet_pushes_as_hard_in_all_however_far_from_its_mouth() -> None:
    faults = Faults(tilt_point=(0.03, 0.01, -0.02), tilt_away=0.3)
    way = np.array([0.6, 0.0, -0.8])
    aside = np.array([0.8, 0.0, 0.6])

    def pressed(ahead: float) -> float:
        """Sum up the push over a plane across the jet, ring by ring [m^2]."""

        def ring(radius: float) -> float:
            place = np.array(faults.tilt_point) + ahead * way + radius * aside
            share = spreading_share(place[None], 3.0 * way, faults)
            return 2.0 * np.pi * radius * float(share[0])

        return float(quad(ring, 0.0, 0.4)[0])

    assert spreading_share(np.array([faults.tilt_point]), way, faults) == pytest.approx(1.0)
    # Its momentum stays: what it loses on its axis it gains in width.
    found = [pressed(ahead) for ahead in (-0.15, 0.0, 0.2)]
    assert found == pytest.approx([found[1]] * 3, rel=1e-6)
    assert found[1] == pytest.approx(0.5 * np.pi * (0.107 * 0.3) ** 2, rel=1e-6)
    up = np.add(faults.tilt_point, [0.0, 0.107 * 0.3, 0.0])
    assert spreading_share(up[None], way, faults) == pytest.approx(np.exp(-2.0))


@pytest.mark.parametrize('pose', range(4))
def test_a_hair_dryer_pushes_what_is_in_its_jet(setup: Setup, plain: Specimen, pose: int) -> None:
    faults, view = draw_faults('gravity_tilt/hair dryer', setup), setup.observations[pose]
    blown, still = (load_in_pose(plain, setup, view, each).forces for each in (faults, Faults()))
    pushes = (blown - still) @ view.world_from_object[:3, :3].T
    pushes /= plain.body.masses[:, None]
    x, z = np.deg2rad(faults.gravity_tilt)
    tilt = float(np.hypot(x, z))
    whole = GRAVITY * np.sin(tilt) / tilt * np.array([z, 0.0, -x])
    way = whole / np.linalg.norm(whole)
    places = plain.mesh.nodes @ view.world_from_object[:3, :3].T + view.world_from_object[:3, 3]
    from_mouth = places - (np.array(faults.tilt_point) - faults.tilt_away * way)
    ahead = from_mouth @ way
    # The tangent of the angle by which a place is off the axis, seen from the mouth.
    slopes = np.linalg.norm(np.cross(from_mouth, way), axis=1) / ahead
    felt = (faults.tilt_away / ahead) ** 2 * np.exp(-2.0 * (slopes / 0.107) ** 2)
    felt *= plain.shares > 0.0
    assert pushes == pytest.approx(felt[:, None] * whole, abs=1e-9)
    assert np.linalg.norm(whole) <= GRAVITY
    assert felt[plain.shares > 0.0].min() < 0.4
    assert pose or felt.max() > 0.8


def test_a_fin_gives_way_across_its_broad_side_alone() -> None:
    drawn = draw_sealed('fin')
    width, height = drawn.shape.section
    level = replace(drawn, observations=drawn.observations[:1])
    across, up = level.observations[0].world_from_object[:3, 1:3].T
    assert aside_give(level, up) == pytest.approx(1.0)
    assert aside_give(level, across) == pytest.approx((height / width) ** 2)


@pytest.mark.parametrize('at', [0.42, 0.7])
def test_a_burdened_body_is_bent_between_its_clamp_and_what_hung_on_it(
    setup: Setup, plain: Specimen, at: float
) -> None:
    shape = setup.shape
    free, curvature = shape.length - shape.clamp, np.array([0.3, -0.8])
    faults = Faults(
        curvature_form='burdened',
        rest_curvature=(float(curvature[0]), float(curvature[1])),
        curvature_at=at,
    )
    line = shape.clamp + np.linspace(0.0, 1.0, 401) * free
    bent = stress_free_nodes(np.outer(line, [1.0, 0.0, 0.0]), shape, faults)
    # As a beam: a moment that falls evenly to where it hung turns it, and that is summed up twice.
    share = (np.arange(4000) + 0.5) / 4000.0
    moments = np.maximum(at - share, 0.0)
    tip = (moments * (1.0 - share)).mean()
    slopes = np.cumsum(moments) / 4000.0
    ways = 0.5 * free**2 / tip * np.interp((line - shape.clamp) / free, share, np.cumsum(slopes))
    ways /= 4000.0
    # About y it turns x towards -z, and about z towards y.
    expected = np.outer(ways, [curvature[1], -curvature[0]])
    assert bent[:, 1:] == pytest.approx(expected, abs=0.03 * np.abs(expected).max())
    beyond = bent[(line - shape.clamp) / free > at + 0.01]
    # What is beyond stayed straight.
    assert np.abs(np.diff(beyond, n=2, axis=0)).max() < 1e-12
    assert (
        np.abs(stress_free_nodes(plain.mesh.nodes, shape, Faults()) - plain.mesh.nodes).max() == 0
    )
