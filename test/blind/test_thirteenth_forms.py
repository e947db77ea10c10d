# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms and causes of the thirteenth set do what their labels say."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from support.blind_derivatives import check_body_stiffness, check_derivatives
from support.blind_draws import draw_faults
from support.blind_rests import COARSE, lying, rest_of, tip_moves, turn_of

from benchmarks.blind.blower import blown
from benchmarks.blind.contact import contact_laws
from benchmarks.blind.dish import dish_tops
from benchmarks.blind.faults import Faults
from benchmarks.blind.fibres import Fibres
from benchmarks.blind.heights import by_height
from benchmarks.blind.laying import lay_on_plane
from benchmarks.blind.observe import true_rendering
from benchmarks.blind.paint import tip_part
from benchmarks.blind.pane import apparent
from benchmarks.blind.pool import channel, pooled
from benchmarks.blind.renderer import Camera
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.thirteenth_outside import THIRTEENTH_OUTSIDE

CRAZED = Faults(crazed=0.6)
Depths = Callable[[Faults, int], np.ndarray]


def test_a_body_off_its_reel_straightens_by_a_power_of_time(setup: Setup) -> None:
    faults = draw_faults('rest_curvature/recovering', setup)
    times = np.log(1.0 + np.arange(4))
    powers = -np.log(faults.curvature_shares[1:]) / times[1:]
    assert powers == pytest.approx(np.full(3, powers[0]), rel=1e-3)
    assert 0.4 <= powers[0] <= 0.8
    for pose, left in enumerate(faults.curvature_shares):
        y, z = faults.rest_curvature
        steady = replace(faults, rest_curvature=(left * y, left * z), curvature_shares=())
        found, expected = rest_of(setup, faults, pose), rest_of(setup, steady, pose)
        # Masses are those of the shape that it had at first.
        assert np.allclose(found, expected, rtol=0.0, atol=2e-5)


def test_a_blower_presses_sides_by_the_square_of_the_cosine(setup: Setup, plain: Specimen) -> None:
    mesh, shape = plain.mesh, setup.shape
    angle = np.deg2rad(25.0)
    way = np.array([0.0, np.cos(angle), np.sin(angle)])
    forces = blown(mesh, plain.shares, 0.3 * way, shape)
    width, height = shape.section
    pressure = 0.3 / max(width, height)
    expected = pressure * np.array([0.0, height * np.cos(angle) ** 2, width * np.sin(angle) ** 2])
    assert forces.sum(axis=0) == pytest.approx(expected, rel=1e-6, abs=1e-12)
    lee = (mesh.lattice[:, 1] > -0.49 * width) & (mesh.lattice[:, 2] > -0.49 * height)
    assert not forces[lee].any()
    assert not forces[mesh.lattice[:, 0] < 0.99 * shape.clamp].any()
    against = blown(mesh, plain.shares, np.array([-0.3, 0.0, 0.0]), shape)
    assert against[:, 0].sum() == pytest.approx(-pressure * width * height / _free(setup))


def _free(setup: Setup) -> float:
    return setup.shape.length - setup.shape.clamp


def test_a_blower_moves_a_body_where_it_meets_a_weak_side(setup: Setup, plain: Specimen) -> None:
    for size, least, most in ((1, 0.003, 0.012), (2, 0.006, 0.022)):
        faults = draw_faults('gravity_tilt/blower', setup, size)
        assert least < max(tip_moves(setup, plain, faults, plain.shares > 0.99)) < most


def test_a_border_recedes_outward_from_pose_to_pose(
    setup: Setup, plain: Specimen, rests: list[np.ndarray], depths: Depths
) -> None:
    faults = draw_faults('depth_bias_by_region/receding', setup)
    assert np.all(np.diff(faults.region_places) > 0.0)
    for pose, place in enumerate(faults.region_places):
        steady = replace(faults, region_places=(), region_from=place)
        assert np.array_equal(depths(faults, pose), depths(steady, pose))
    wet = []
    for pose in range(4):
        view = true_rendering(plain, setup, setup.observations[pose], faults, rests[pose])
        wet.append(float(tip_part(view.labels).sum() / (view.labels >= 0).sum()))
    assert wet[0] > 1.5 * wet[3] > 0.0


def test_a_liquid_fills_its_channel_up_to_one_level(plain: Specimen, setup: Setup) -> None:
    faults = draw_faults('added_mass/pooled', setup)
    room = channel(plain.mesh.lattice, plain.body.masses, plain.shares, faults)
    inner, outer = faults.mass_stops
    assert room.sum() == pytest.approx(1e-3 * faults.added_mass / faults.mass_filled)
    assert not room[(plain.shares <= inner) | (plain.shares >= outer)].any()
    # A channel that falls outward by 12 degrees.
    heights = -0.2 * plain.mesh.nodes[:, 0]
    _, weights, _ = pooled(room, 1e-3 * faults.added_mass)(heights)
    assert weights.sum() == pytest.approx(1e-3 * faults.added_mass * GRAVITY)
    there = room > 0.0
    part = weights[there] / GRAVITY / room[there]
    assert np.all(np.diff(part[np.argsort(heights[there])]) <= 1e-9)
    assert part.max() == pytest.approx(1.0)
    assert part.min() == 0.0


def test_a_liquid_weighs_by_the_slope_of_its_energy(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    faults, view = draw_faults('added_mass/pooled', setup), setup.observations[0]
    (law,) = by_height(plain.mesh.lattice, plain.body.masses, plain.shares, view, faults)
    move, h = np.random.default_rng(3).standard_normal(rests[0].shape), 1e-6
    one, other = (law(rests[0] + way * h * move).energy for way in (1.0, -1.0))
    slope = float((law(rests[0]).gradient * move).sum())
    assert (one - other) / (2.0 * h) == pytest.approx(slope, rel=1e-4)


def test_a_liquid_runs_outward_where_a_body_sags_and_inward_where_it_rises(
    setup: Setup, plain: Specimen
) -> None:
    faults = draw_faults('added_mass/pooled', setup)
    middles = []
    for pose in (0, 2, 3):
        view = setup.observations[pose]
        (law,) = by_height(plain.mesh.lattice, plain.body.masses, plain.shares, view, faults)
        weights = law(rest_of(setup, faults, pose)).gradient @ view.world_from_object[1, :3]
        middles.append(float(weights @ plain.shares / weights.sum()))
    rises = [setup.observations[pose].world_from_object[1, 0] for pose in (2, 3)]
    assert rises[0] < 0.0 < rises[1]
    assert middles[0] > 0.55
    assert middles[1] > middles[2] + 0.1


@pytest.mark.parametrize('sign', [-1.0, 1.0])
def test_streaks_swing_by_the_sine_of_the_place_aslant(setup: Setup, sign: float) -> None:
    faults = Faults(
        contrast=0.8 * sign, contrast_mode='streaky', contrast_wave=1.25, contrast_slant=0.05
    )
    streaky, whole = (make_specimen(setup, each, 1.0) for each in (faults, Faults()))
    stiffer = np.log(np.asarray(streaky.body.numbers.shear / whole.body.numbers.shear))
    values = whole.body.quadrature.values
    share = whole.shares[whole.mesh.cells] @ values.T
    expected = 0.8 * sign * np.sin(2.0 * np.pi * (share - 0.05 * whole.heights) / 1.25)
    assert np.allclose(stiffer, expected, rtol=0.0, atol=1e-9)


@pytest.fixture(scope='module')
def in_a_dish(setup: Setup) -> tuple[Setup, Faults]:
    """A set-up whose body lies in a dish in the first pose, and that dish."""
    return lay_on_plane(setup, draw_faults('contact_plane/dish', setup), np.random.default_rng(1))


def test_a_dish_holds_a_body_up_where_it_touches(
    in_a_dish: tuple[Setup, Faults], plain: Specimen
) -> None:
    laid, faults = in_a_dish
    assert faults.contact_height is not None
    for pose, touches in enumerate((True, False, True, False)):
        view = laid.observations[pose]
        found, moved = lying(laid, plain, faults, pose)
        tops = dish_tops(applied(view.world_from_object, found), faults)[plain.shares > 0.6]
        dent = faults.contact_height - float(tops.min())
        assert (dent > 0.0) == touches
        assert dent < 0.0005
        assert (0.002 < moved < 0.02) == touches
        (law,) = contact_laws(plain.areas, plain.shares, view, faults)
        assert law(found).gradient.any() == touches
        check_derivatives(law, found - 0.003 * view.world_from_object[1, :3])


def test_a_clamp_that_rubs_lags_by_its_friction_and_stays_where_it_was(
    setup: Setup, plain: Specimen
) -> None:
    faults = draw_faults('compliant_clamp/rubbing', setup)
    held, center = plain.mesh.held, plain.center
    before, least = np.zeros(3), faults.clamp_compliance * faults.clamp_rub
    for pose, view in enumerate(setup.observations):
        rest = rest_of(setup, faults, pose)
        weight = plain.body.masses[:, None] * (-GRAVITY * view.world_from_object[1, :3])
        # About a clamp's middle weight is all that turns a body; held nodes bear their own.
        moment = np.cross(rest - center, weight).sum(axis=0)
        turn = turn_of(plain.mesh.nodes[held], rest[held])
        lag = faults.clamp_compliance * moment - turn
        assert np.linalg.norm(lag) == pytest.approx(least, rel=0.02)
        # It went on the way that the spring drew it.
        went = turn - before
        assert went @ lag > 0.95 * np.linalg.norm(went) * np.linalg.norm(lag)
        before = turn
    stuck = replace(faults, clamp_rub=5.0 * faults.clamp_rub)
    plain_rest = rest_of(setup, Faults())
    assert np.allclose(rest_of(setup, stuck), plain_rest, rtol=0.0, atol=1e-9)


def test_a_pane_shows_points_where_their_rays_leave_it() -> None:
    normal = np.array([0.3, -0.5, 0.0])
    normal = np.array([*normal[:2], np.sqrt(1.0 - normal @ normal)])
    point, thick, index = np.array([0.04, 0.02, 0.33]), 0.02, 1.49
    seen = apparent(point, thick, normal)
    # Trace the ray from the camera on: into the pane, through it, and out again.
    ray = seen / np.linalg.norm(seen)
    across = ray - (ray @ normal) * normal
    inside = across / index + np.sqrt(1.0 - (across @ across) / index**2) * normal
    enters = ray * (0.1 / (ray @ normal))
    leaves = enters + inside * (thick / (inside @ normal))
    missed = np.cross(point - leaves, ray)
    assert np.linalg.norm(missed) < 1e-8
    assert np.linalg.norm(np.cross(point, ray)) > 3e-3
    straight = apparent(0.3 * normal, thick, normal)
    assert straight == pytest.approx((0.3 - thick * (1.0 - 1.0 / index)) * normal)


def test_a_pane_brings_depths_nearer_by_some_5_and_10_mm(setup: Setup, depths: Depths) -> None:
    for size, least, most in ((1, 0.002, 0.007), (2, 0.004, 0.014)):
        clean, found = (
            depths(Faults(), 0),
            depths(draw_faults('camera_offset/pane', setup, size), 0),
        )
        nearer = np.median(clean[np.isfinite(clean)]) - np.median(found[np.isfinite(found)])
        assert least < nearer < most


def test_sides_of_cracks_push_by_their_energy_and_do_not_pull() -> None:
    cracks = Fibres(np.array(3e4), np.array([1.0, 0.0, 0.0]), pressed=True)
    random = np.random.default_rng(1)
    shut = np.diag([0.93, 1.03, 1.03]) + random.uniform(-0.02, 0.02, (3, 3))
    move, h = random.standard_normal((3, 3)), 1e-6
    one, other = (cracks.energy(shut + way * h * move) for way in (1.0, -1.0))
    slope = float((cracks.stress(shut) * move).sum())
    assert slope != 0.0
    assert (one - other) / (2.0 * h) == pytest.approx(slope, rel=1e-5, abs=1e-3)
    assert not cracks.stress(np.diag([1.05, 0.98, 0.98])).any()


def test_a_crazed_body_is_whole_where_it_is_pressed(setup: Setup) -> None:
    crazed, whole = (make_specimen(setup, each, COARSE) for each in (CRAZED, Faults()))
    above = crazed.heights > 0.5
    softer = np.asarray(crazed.body.numbers.shear / whole.body.numbers.shear)
    assert softer[above] == pytest.approx(0.4)
    assert np.array_equal(softer[~above], np.ones((~above).sum()))
    cracks = crazed.body.numbers.fabric
    assert cracks is not None
    # Along the body a small push meets E again: that of the rubber and 8 K.
    again = 0.4 * setup.youngs_modulus + 8.0 * cracks.stiffness
    assert again[above] == pytest.approx(setup.youngs_modulus)
    assert not cracks.stiffness[~above].any()
    check_body_stiffness(crazed.body, crazed.mesh.nodes * np.array([0.94, 1.0, 1.0]))


def test_a_crazed_body_sags_where_its_upper_side_is_drawn_alone(
    setup: Setup, plain: Specimen
) -> None:
    for size, least, most in ((1, 0.002, 0.008), (2, 0.005, 0.016)):
        crazed = THIRTEENTH_OUTSIDE['crazed'](size, setup, np.random.default_rng(8))
        moves = tip_moves(setup, plain, Faults(**crazed.changes), plain.shares > 0.99)
        assert least < moves[0] < most
        assert moves[3] < 0.2 * moves[0], 'turned over, its cracks are shut'


def test_columns_of_a_skewed_image_go_with_the_row() -> None:
    straight = Camera(640, 480, 600.0, 600.0, 320.0, 240.0)
    points = np.array([[0.02, 0.05, 0.3], [0.02, -0.05, 0.3], [0.02, 0.0, 0.3]])
    shift = replace(straight, skew=0.1).project(points) - straight.project(points)
    assert shift == pytest.approx(np.array([[10.0, 0.0], [-10.0, 0.0], [0.0, 0.0]]))


def test_a_skewed_image_shifts_a_body_by_some_5_and_10_mm(setup: Setup) -> None:
    half = 0.055  # Of what is seen, above and below the image's middle [m].
    for size, least, most in ((1, 0.004, 0.006), (2, 0.008, 0.012)):
        skewed = THIRTEENTH_OUTSIDE['skewed'](size, setup, np.random.default_rng(8))
        assert least < half * abs(skewed.changes['skewed']) < most
