# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the twenty-fifth set do what their labels say."""

from dataclasses import replace

import numpy as np
import pytest
from support.blind_contact import check_pushes, dents_of
from support.blind_derivatives import check_body_stiffness, check_loose_fibres
from support.blind_draws import draw_faults, draw_sealed, SEALED, STEPS
from support.blind_jaws import pitched_in_poses
from support.blind_rests import (
    check_rests_where_borne,
    COARSE,
    lying,
    moved_by_what_stiffens,
    rest_of,
)
from support.blind_views import region_errors, with_and_without

from benchmarks.blind.cradle import cradled_masses, outer_part
from benchmarks.blind.draught import curtain_share
from benchmarks.blind.faults import Faults
from benchmarks.blind.fibres import Fibres
from benchmarks.blind.flexure import suction_compliance
from benchmarks.blind.forms import BY_KEY
from benchmarks.blind.laying import lay_on_plane
from benchmarks.blind.loads import load_in_pose
from benchmarks.blind.moduli import ribbon_share
from benchmarks.blind.observe import jostled, true_camera
from benchmarks.blind.paint import Paint, tip_part
from benchmarks.blind.rotations import rotation
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.speckle import on_board
from benchmarks.blind.surface import body_triangles


@pytest.mark.parametrize('slope', [0.0, 20.0, -35.0, 40.0])
def test_threads_bear_a_weight_that_hangs_plumb_below_what_they_make(slope: float) -> None:
    drop, apart = 0.02, 0.04
    angle = np.deg2rad(slope)
    # Upright plane: the outer place is lower by a positive slope, and the triangle goes with it.
    ahead = np.array([np.cos(angle), -np.sin(angle)])
    inner, outer = np.zeros(2), apart * ahead
    weight = 0.5 * apart * ahead + drop * np.array([-np.sin(angle), -np.cos(angle)])
    # Along its two threads, what bears it.
    ways = np.stack([inner - weight, outer - weight], axis=1)
    pulls = np.linalg.solve(ways, [0.0, 1.0])
    found = outer_part(np.array([np.sin(angle), 0.0, -np.cos(angle)]), drop, apart)
    # Neither is slack.
    assert pulls.min() > 0.0
    # The moment about the inner place of what the outer thread draws: across the body alone.
    draw = -pulls[1] * ways[:, 1]
    moment = outer[0] * draw[1] - outer[1] * draw[0]
    assert found == pytest.approx(-moment / (apart * np.cos(angle)), abs=1e-12)


@pytest.mark.parametrize('pose', range(4))
def test_a_cradled_weight_loads_a_body_in_two_places(
    setup: Setup, plain: Specimen, pose: int
) -> None:
    faults, view = draw_faults('added_mass/cradled', setup), setup.observations[pose]
    found = cradled_masses(plain.body.masses, plain.shares, setup, view, faults)
    assert found.sum() == pytest.approx(1e-3 * faults.added_mass)
    inner, outer = faults.mass_stops
    is_near = np.minimum(np.abs(plain.shares - inner), np.abs(plain.shares - outer)) < 0.13
    assert found[~is_near].max() == 0.0
    apart = (outer - inner) * (setup.shape.length - setup.shape.clamp)
    part = outer_part(-view.world_from_object[1, :3], faults.mass_drop, apart)
    middle = float(found @ plain.shares / found.sum())
    assert middle == pytest.approx(inner + part * (outer - inner), abs=0.03)


def test_a_cradled_weight_hangs_nearer_to_what_is_higher(setup: Setup) -> None:
    down = np.array([0.5, 0.3, -0.8])
    assert outer_part(down, 0.01, 0.05) < 0.5 < outer_part(-down, 0.01, 0.05)
    assert outer_part(np.array([0.9, 0.0, -0.3]), 0.02, 0.03) == 0.0
    parts = []
    faults = draw_faults('added_mass/cradled', setup)
    for view in setup.observations:
        parts.append(outer_part(-view.world_from_object[1, :3], faults.mass_drop, 0.04))
    assert np.ptp(parts) > 0.3


def test_a_ribbon_goes_once_round_a_body_in_a_turn() -> None:
    faults = Faults(contrast_wave=0.8, contrast_at=0.1, contrast_side=1.0)
    share = np.array([0.1, 0.1, 0.1, 0.3, 0.3, 0.5, 0.7, 0.9, 0.2])
    across = np.array([1.0, -0.3, 0.0, 0.0, 0.0, -1.0, 0.0, 0.5, 1.0])
    height = np.array([0.0, 0.0, 1.0, 1.0, -1.0, 0.0, -0.5, 0.0, 1.0])
    found = ribbon_share(share, across, height, faults)
    assert found == pytest.approx([1.0, 0.0, 0.5, 1.0, 0.0, 1.0, 1.0, 1.0, 1.0])
    # The other way round it is where that is in a mirror.
    back = replace(faults, contrast_side=-1.0)
    assert ribbon_share(share, across, -height, back) == pytest.approx(found)


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_body_with_a_ribbon_is_soft_where_that_is(family: str) -> None:
    drawn = draw_sealed(family)
    faults = draw_faults('stiffness_contrast/ribbon', drawn)
    soft, whole = (make_specimen(drawn, each) for each in (faults, Faults()))
    harder = np.log(np.asarray(soft.body.numbers.shear / whole.body.numbers.shear))
    mesh, values = whole.mesh, whole.body.quadrature.values
    places = mesh.lattice[mesh.cells].swapaxes(1, 2) @ values.T
    share = (places[:, 0] - drawn.shape.clamp) / (drawn.shape.length - drawn.shape.clamp)
    width, height = drawn.shape.section
    # As complex numbers: how far a place's direction agrees with the ribbon's.
    way = places[:, 1] / width + 1j * places[:, 2] / height
    turns = faults.contrast_side * (share - faults.contrast_at) / faults.contrast_wave
    agrees = (way * np.exp(-2j * np.pi * turns)).real / np.abs(way)
    free = share > 0.05
    expected = 0.5 * faults.contrast * (1.0 + agrees)
    assert harder[free] == pytest.approx(expected[free], abs=1e-6)
    assert -4.0 < faults.contrast < -0.3
    assert harder.max() < 0.0 or harder.max() == pytest.approx(0.0, abs=0.1)


@pytest.mark.parametrize('step', STEPS)
def test_blocks_push_by_their_energy_once_they_touch(setup: Setup, step: float) -> None:
    faults = Faults(stiffening_form='vertebrae', stiffening=2.0, stiffening_from=0.04)
    (family,) = make_specimen(setup, faults, COARSE).body.numbers.network
    blocks = replace(family, stiffness=np.array(3e4))
    bent = np.diag([0.92, 1.03, 1.03]) + np.random.default_rng(1).uniform(-0.02, 0.02, (3, 3))
    check_loose_fibres(blocks, bent, step, still=(0.981, 1.0, 1.2))


@pytest.mark.parametrize('step', [1e-7, 1e-8, 1e-9])
def test_a_body_with_blocks_resists_as_its_forces_change(setup: Setup, step: float) -> None:
    faults = Faults(stiffening_form='vertebrae', stiffening=2.0, stiffening_from=0.01)
    specimen = make_specimen(setup, faults, COARSE)
    shorter = specimen.mesh.nodes * np.array([0.9, 1.05, 1.05])
    check_body_stiffness(specimen.body, shorter, step=step)


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_blocks_lie_along_the_lower_side_of_every_body(family: str) -> None:
    drawn = draw_sealed(family)
    faults = draw_faults('strain_stiffening/vertebrae', drawn)
    specimen = make_specimen(drawn, faults)
    (found,) = specimen.body.numbers.network
    assert isinstance(found, Fibres)
    there = np.broadcast_to(found.stiffness, specimen.heights.shape) > 0.0
    assert np.array_equal(there, specimen.heights < -0.5)
    # Of the lowest row of points, and of no other.
    assert 0.1 < there.mean() < 0.3
    assert found.stiffness[there] == pytest.approx(
        faults.stiffening * drawn.youngs_modulus / 8.0, rel=1e-6
    )


# A fin hangs on a slant, and a tee's tip is heavy.
@pytest.mark.parametrize('family', ['arch', 'waist', 'fin', 'tee'])
def test_blocks_hold_a_body_where_it_bends_down_and_not_upside_down(family: str) -> None:
    moves = moved_by_what_stiffens('strain_stiffening/vertebrae', family)
    assert 0.0025 < moves[0] < 0.006
    assert 0.006 < moves[1] < 0.014


def test_a_suction_cups_wall_bears_by_what_it_is_drawn_and_sheared() -> None:
    by_turn, width = 0.4, 0.03
    # Springs around a ring, each soft by as much along x, and half as stiff aside of that.
    around = 2.0 * np.pi * (np.arange(60) + 0.5) / 60.0
    places = np.stack([0.0 * around, np.cos(around), np.sin(around)], axis=1)
    places = places * 0.5 * width - np.array([width, 0.0, 0.0])
    whole = np.zeros((6, 6))
    for place in places:
        carried = np.hstack([np.eye(3), -np.cross(place, np.eye(3)).T @ np.eye(3)])
        # How a place moves by a shift, and by a turn: turn x place.
        carried[:, 3:] = -np.array(
            [[0, -place[2], place[1]], [place[2], 0, -place[0]], [-place[1], place[0], 0]]
        )
        whole += carried.T @ np.diag([1.0, 0.5, 0.5]) @ carried / 60.0
    found = suction_compliance(by_turn, width)
    expected = np.linalg.inv(whole)
    # A turn by a moment about the cup's middle: by which springs' stiffness is told.
    expected *= by_turn / expected[4, 4]
    assert found == pytest.approx(expected, abs=1e-9)
    assert found[4, 4] == found[5, 5] == by_turn


@pytest.mark.parametrize('pose', range(4))
def test_a_clamp_on_a_suction_cup_rests_where_that_bears_the_body(
    setup: Setup, plain: Specimen, pose: int
) -> None:
    faults = draw_faults('compliant_clamp/suction', setup)
    compliance = suction_compliance(faults.clamp_compliance, faults.clamp_length)
    check_rests_where_borne(setup, plain, faults, pose, compliance)


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_jaws_are_pitched_by_as_many_times_what_they_should_be(family: str) -> None:
    drawn = draw_sealed(family)
    for size, most in ((1, 0.004), (2, 0.010)):
        stated, pitched = pitched_in_poses('clamp_offset/misgraded', drawn, size)
        is_steep = np.abs(stated) > 0.05
        factors = pitched[is_steep] / stated[is_steep]
        ways = np.abs(pitched - stated) * drawn.shape.length
        assert np.ptp(factors) < 1e-3
        assert max(ways) == pytest.approx(most, rel=0.16)


def test_a_body_in_misgraded_jaws_is_held_where_they_are(setup: Setup, plain: Specimen) -> None:
    faults = draw_faults('clamp_offset/misgraded', setup)
    nodes = plain.mesh.nodes[plain.mesh.held]
    for pose, motion in enumerate(faults.clamp_scatter):
        found = rest_of(setup, faults, pose)[plain.mesh.held]
        # About a hinge through the object's origin.
        turned = nodes @ rotation(np.deg2rad(motion[3:])).T
        assert found == pytest.approx(turned, abs=1e-6)


@pytest.fixture(scope='module')
def on_a_jack(setup: Setup) -> tuple[Setup, Faults]:
    """A set-up whose body lies on a jack in the first pose, and that jack."""
    return lay_on_plane(setup, draw_faults('contact_plane/jack', setup), np.random.default_rng(1))


def test_a_jack_lifts_a_body_less_the_farther_it_has_sunk(
    on_a_jack: tuple[Setup, Faults], plain: Specimen
) -> None:
    laid, faults = on_a_jack
    assert faults.contact_height is not None
    still, moves = replace(faults, contact_drops=()), []
    for pose in range(4):
        found, move = lying(laid, plain, faults, pose)
        moves.append(move)
        sunk = replace(
            faults, contact_height=faults.contact_height - 1e-3 * faults.contact_drops[pose]
        )
        dents = dents_of(laid, sunk, found, pose)
        assert (dents.max() > 0.0) == (pose in (0, 2))
        # It is hard.
        assert dents.max() < 1e-4
        assert found == pytest.approx(rest_of(laid, replace(sunk, contact_drops=()), pose))
    assert 0.007 < moves[0] < 0.013
    assert moves[0] > moves[2] > 0.001
    assert moves[1] == moves[3] == 0.0
    _, unsunk = lying(laid, plain, still, 2)
    assert 0.0008 < unsunk - moves[2] < 0.0045


@pytest.mark.parametrize('family', ['beam', 'arch', 'waist', 'tee'])
def test_a_jack_sinks_as_fast_from_pose_to_pose(family: str) -> None:
    drawn = draw_sealed(family)
    for size in (1, 2):
        faults = draw_faults('contact_plane/jack', drawn, size)
        assert faults.contact_height is not None
        drops = np.array(faults.contact_drops)
        assert drops[0] == 0.0
        assert np.diff(drops) == pytest.approx(drops[1], abs=2e-4)
        # Where it is to lift a body again by two fifths of that, it still does.
        assert 0.1 < drops[2] / faults.contact_height < 0.31


@pytest.mark.parametrize('step', STEPS)
def test_a_jack_pushes_by_its_energy(
    on_a_jack: tuple[Setup, Faults], plain: Specimen, step: float
) -> None:
    laid, faults = on_a_jack
    check_pushes(laid, plain, faults, step)


def test_what_is_bright_errs_by_another_gain(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    faults, means = draw_faults('depth_affine/two gains', setup), []
    distance = float(np.linalg.norm(setup.depth_from_world[:3, 3]))
    for pose in range(4):
        view, right, there = with_and_without(plain, setup, faults, pose, rests[pose])
        errors = (view.depth[there] - right.depth[there]) / (1e-3 * faults.depth_bias)
        light = np.maximum(right.facing[there], 1.0 / 3.0) * (distance / right.depth[there]) ** 2
        away = (light - faults.depth_full) / faults.depth_blend
        # An S of the logistic function, half of which is there where one gain goes over.
        assert errors == pytest.approx(1.0 / (1.0 + np.exp(-2.0 * away)), abs=1e-6)
        means.append(float(errors.mean()))
    assert np.ptp(means) > 0.2
    assert abs(faults.depth_bias) == pytest.approx(11.0, rel=0.16)


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_two_gains_meet_amid_the_light_of_the_poses(family: str) -> None:
    drawn = draw_sealed(family)
    for seed in range(4):
        changes = BY_KEY['depth_affine/two gains'].draw(2, drawn, np.random.default_rng(seed))
        assert 0.6 < changes['depth_full'] < 1.3
        assert 0.08 <= changes['depth_blend'] <= 0.15


def test_squares_of_a_board_take_turns_along_every_axis() -> None:
    edge, random = 0.008, np.random.default_rng(3)
    points = edge * (random.integers(-9, 9, (50, 3)) + random.uniform(0.1, 0.9, (50, 3)))
    found = on_board(points, edge)
    assert 0.2 < found.mean() < 0.8
    for axis in range(3):
        beside = points + edge * np.eye(3)[axis]
        assert np.array_equal(on_board(beside, edge), ~found)
        assert np.array_equal(on_board(beside + edge * np.eye(3)[axis], edge), found)


def test_a_board_is_on_the_outer_part_and_dark_on_half_of_it(
    setup: Setup, plain: Specimen
) -> None:
    nodes = plain.mesh.nodes
    painted = body_triangles(plain.mesh, nodes, plain.shares, Paint(0.3, board=0.009))
    middles = painted.corners.mean(axis=1)
    free = setup.shape.length - setup.shape.clamp
    outer = (middles[:, 0] - setup.shape.clamp) / free > 0.3
    parts = tip_part(painted.labels)
    assert not parts[~outer].any()
    assert set(np.unique(parts)) == {0.0, 1.0}
    assert 0.3 < parts[outer].mean() < 0.7
    # Where its squares lie, told by the sign of three sines.
    waves = np.sin(np.pi * middles / 0.009).prod(axis=1)
    clear = outer & (np.abs(waves) > 0.05)
    assert np.array_equal(parts[clear] > 0.0, waves[clear] > 0.0)


def test_what_has_a_board_on_it_errs_on_its_dark_squares(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    faults = draw_faults('depth_bias_by_region/checkered', setup)
    for pose in range(4):
        error = region_errors(plain, setup, faults, pose, rests[pose])
        assert np.minimum(np.abs(error), np.abs(error - 1.0)).max() < 1e-6
        assert 0.2 < error.mean() < 0.55
    assert abs(faults.region_bias) == pytest.approx(12.0, rel=0.16)


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_camera_on_a_desk_lamp_sinks_on_a_circle_and_keeps_its_way(family: str) -> None:
    drawn = draw_sealed(family)
    faults = draw_faults('camera_offset/desk lamp', drawn)
    plain = make_specimen(drawn, Faults(), COARSE)
    stored = np.linalg.inv(drawn.depth_from_world)
    # Level, the way the camera looks.
    ahead = stored[:3, 2] * np.array([1.0, 0.0, 1.0])
    ahead /= np.linalg.norm(ahead)
    shifts = []
    for pose in range(4):
        off = jostled(drawn, drawn.observations[pose], faults)
        found = np.linalg.inv(true_camera(plain, drawn, off))
        assert found[:3, :3] == pytest.approx(stored[:3, :3], abs=1e-12)
        shift = found[:3, 3] - stored[:3, 3]
        assert abs(shift @ np.cross(ahead, [0.0, 1.0, 0.0])) < 1e-6
        shifts.append([shift @ ahead, shift[1]])
    sizes = np.linalg.norm(shifts, axis=1)
    # It sinks, and the less the longer it does.
    assert (np.diff(np.array(shifts)[:, 1]) < 0.0).all()
    assert (np.diff(sizes, n=2) < 0.0).all()
    assert sizes[-1] == pytest.approx(0.010, rel=0.17)
    # As far from the arm's joint in every pose: chords' middles are square to the way there.
    ways = np.array(shifts)
    joint = np.linalg.lstsq(2.0 * ways, (ways**2).sum(axis=1), rcond=None)[0]
    assert 0.2 < np.linalg.norm(joint) < 0.5
    assert joint[0] < 0.0
    assert joint[1] < 0.0


@pytest.mark.parametrize('pose', range(4))
def test_a_curtain_of_air_pushes_what_is_in_it(setup: Setup, plain: Specimen, pose: int) -> None:
    faults = draw_faults('gravity_tilt/curtain', setup)
    view = setup.observations[pose]
    blown, still = (load_in_pose(plain, setup, view, each).forces for each in (faults, Faults()))
    pushes = (blown - still) @ view.world_from_object[:3, :3].T
    pushes /= plain.body.masses[:, None]
    x, z = np.deg2rad(faults.gravity_tilt)
    tilt = float(np.hypot(x, z))
    whole = GRAVITY * np.sin(tilt) / tilt * np.array([z, 0.0, -x])
    places = plain.mesh.nodes @ view.world_from_object[:3, :3].T + view.world_from_object[:3, 3]
    along = places - np.array(faults.tilt_point)
    # Beside an upright sheet: level and square to the way it blows.
    beside = (along[:, 0] * whole[2] - along[:, 2] * whole[0]) / np.linalg.norm(whole)
    felt = (1.0 - np.tanh(beside / faults.tilt_width) ** 2) ** 2 * (plain.shares > 0.0)
    assert pushes == pytest.approx(felt[:, None] * whole, abs=1e-9)
    assert np.linalg.norm(whole) < 0.99 * GRAVITY
    assert felt.max() > 0.8
    assert felt[plain.shares > 0.0].min() < 0.4


def test_a_curtain_is_alike_along_itself_and_upwards() -> None:
    faults = Faults(tilt_point=(0.03, 0.01, -0.02), tilt_width=0.04)
    way = np.array([0.3, 0.0, -1.2])
    middle = np.array([faults.tilt_point])
    moved = middle + np.array([[0.0, 0.0, 0.0], [0.0, 0.5, 0.0], [0.6, 0.0, -2.4]])
    assert curtain_share(moved, way, faults) == pytest.approx(1.0)
    aside = 0.04 * np.array([1.2, 0.0, 0.3]) / np.hypot(1.2, 0.3)
    sides = curtain_share(middle + np.stack([aside, -aside, 2.0 * aside]), way, faults)
    assert sides == pytest.approx([0.17638, 0.17638, np.cosh(2.0) ** -4], rel=1e-4)
