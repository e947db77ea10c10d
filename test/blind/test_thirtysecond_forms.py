# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the thirty-second set that are of body, rig and air do what their labels say."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.blind_derivatives import check_body_stiffness, check_loose_fibres
from support.blind_draws import draw_faults, draw_sealed, SEALED
from support.blind_rests import check_rests_where_borne, COARSE, rest_of, tip_moves

from benchmarks.blind.draught import wall_share
from benchmarks.blind.faults import Faults
from benchmarks.blind.fibres import Fibres
from benchmarks.blind.flexure import hexapod_compliance, hexapod_ends
from benchmarks.blind.hourglass import hourglass_masses, outer_sand
from benchmarks.blind.laying import softer
from benchmarks.blind.loads import load_in_pose
from benchmarks.blind.rest_shape import stress_free_nodes
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.sheets import sheet_value
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.weaving import WIRE

_ALONG = np.array([1.0, 0.0, 0.0])


def test_sand_runs_to_the_lower_bulb_as_fast_all_the_time(setup: Setup) -> None:
    glass = Faults(mass_flow=0.4)
    # Poses: level, rolled, 40 degrees down and 25 degrees up.
    pitches = [float(pose.world_from_object[1, 0]) for pose in setup.observations]
    assert pitches[2] < -0.5
    assert pitches[3] > 0.3
    found = [outer_sand(setup, glass, pose) for pose in range(4)]
    assert found == pytest.approx([0.4, 0.8, 1.0, 0.6])


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_an_hourglass_bears_all_of_its_sand_in_two_places(family: str) -> None:
    drawn = draw_sealed(family)
    plain, faults = (
        make_specimen(drawn, Faults(), COARSE),
        draw_faults('added_mass/hourglass', drawn),
    )
    inner, outer = faults.mass_stops
    for number, pose in enumerate(drawn.observations):
        found = hourglass_masses(plain.body.masses, plain.shares, drawn, pose, faults)
        assert 1e3 * found.sum() == pytest.approx(faults.added_mass)
        part = outer_sand(drawn, faults, number)
        expected = (1.0 - part) * inner + part * outer
        assert found @ plain.shares / found.sum() == pytest.approx(expected, abs=0.04)


def test_there_is_one_sheet_more_after_each_step() -> None:
    share = np.linspace(0.001, 0.999, 500)
    found = sheet_value(share, 5)
    sheets = 5.0 ** (1.0 - found)
    assert sheets == pytest.approx(np.ceil(5.0 * share))
    # As a roll whose modulus is that of all sheets together: ln 5 is the contrast of that.
    assert np.exp(-np.log(5.0) * found) == pytest.approx(np.ceil(5.0 * share) / 5.0)


@pytest.mark.parametrize('step', [1e-5, 1e-6, 1e-7])
def test_filaments_come_taut_one_after_another(step: float) -> None:
    many = Fibres(np.array(3e4), _ALONG, slack=True, loose=0.05, spread=0.1)
    random = np.random.default_rng(4)
    for growth in (0.09, 0.3):
        strained = np.diag([np.sqrt(1.0 + growth), 0.97, 1.02])
        # By the mean of many threads, each of which is loose as long as another.
        singles = [
            Fibres(np.array(3e4), _ALONG, slack=True, loose=0.05 + 0.1 * part)
            for part in (np.arange(2000) + 0.5) / 2000
        ]
        mean = np.mean([each.energy(strained) for each in singles])
        assert many.energy(strained) == pytest.approx(mean, rel=1e-5)
        move = random.standard_normal((3, 3))
        one, other = (many.energy(strained + way * step * move) for way in (1.0, -1.0))
        slope = float((many.stress(strained) * move).sum())
        assert (one - other) / (2.0 * step) == pytest.approx(slope, rel=1e-4)
    for still in (0.9, 1.0, 1.02):
        assert not many.stress(np.diag([still, 1.0, 1.0])).any()
    # Threads that all come taut at once are as they were.
    check_loose_fibres(singles[0], np.diag([1.2, 0.97, 1.0]), step, (0.9, 1.01))


@pytest.mark.parametrize('step', [1e-7, 1e-8, 1e-9])
def test_a_body_with_rovings_resists_as_its_forces_change(setup: Setup, step: float) -> None:
    faults = Faults(
        stiffening_form='rovings', stiffening=5.0, stiffening_from=0.01, stiffening_spread=0.2
    )
    specimen = make_specimen(setup, faults, COARSE)
    check_body_stiffness(specimen.body, specimen.mesh.nodes * [1.03, 0.98, 0.98], step=step)


def test_rovings_lie_along_the_four_edges() -> None:
    drawn = draw_sealed('waist')
    faults = draw_faults('strain_stiffening/rovings', drawn)
    specimen = make_specimen(drawn, faults, COARSE)
    (found,) = specimen.body.numbers.network
    there = np.broadcast_to(found.stiffness, specimen.heights.shape) > 0.0
    quadrature, mesh = specimen.body.quadrature, specimen.mesh
    places = mesh.lattice[mesh.cells].swapaxes(1, 2) @ quadrature.values.T
    quarters = 0.25 * np.array(drawn.shape.section)[:, None]
    near = (np.abs(places[:, 1:]) > quarters).all(axis=1)
    assert np.array_equal(there, near)
    assert 0.05 < there.mean() < 0.3
    assert found.stiffness[there] == pytest.approx(
        faults.stiffening * drawn.youngs_modulus / 8.0, rel=1e-6
    )
    assert (found.loose, found.spread) == (faults.stiffening_from, faults.stiffening_spread)


@pytest.mark.slow
@pytest.mark.parametrize('family', SEALED)
def test_rovings_hold_a_body_whichever_way_up_it_is(family: str) -> None:
    drawn = draw_sealed(family)
    soft = softer(drawn, 0.3)
    plain = make_specimen(soft, Faults(), COARSE)
    # A fin is thin and hardly strained.
    for size, least, most in ((1, 1.2, 7.5), (2, 3.0, 16.0)):
        faults = draw_faults('strain_stiffening/rovings', drawn, size)
        moves = 1e3 * np.array(tip_moves(soft, plain, faults, plain.shares > 0.99))
        assert least < moves[0] < most
        assert least < moves[3] < most


def test_a_hexapod_gives_way_as_its_legs_grow_longer() -> None:
    by_turn, height = 0.4, 0.07
    above, below = hexapod_ends(height)
    assert above[:, 2] - below[:, 2] == pytest.approx(height)
    legs = np.linalg.norm(above - below, axis=1)
    assert np.ptp(legs) < 1e-12
    found = hexapod_compliance(by_turn, height)
    assert found[4, 4] == pytest.approx(by_turn)
    # Six legs bear a load: by statics each a force along itself, by which it grows longer, all by
    # as much for as large a force; and then by geometry the plate is where their ends are.
    lines = (above - below) / legs[:, None]
    loads = np.random.default_rng(3).standard_normal((4, 6))
    gives = []
    for load in loads:
        motion = 1e-4 * found @ load
        turn = Rotation.from_rotvec(motion[3:])
        grown = np.linalg.norm(turn.apply(above) + motion[:3] - below, axis=1) - legs
        balance = np.vstack([lines.T, np.cross(above, lines).T])
        gives.append(grown / (1e-4 * np.linalg.solve(balance, load)))
    assert np.array(gives) == pytest.approx(np.median(gives), rel=0.01)


@pytest.mark.parametrize('pose', [0, 1])
def test_a_clamp_on_a_hexapod_rests_where_that_bears_the_body(
    setup: Setup, plain: Specimen, pose: int
) -> None:
    faults = draw_faults('compliant_clamp/hexapod', setup)
    compliance = hexapod_compliance(faults.clamp_compliance, faults.clamp_length)
    check_rests_where_borne(setup, plain, faults, pose, compliance)


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_key_presses_a_body_away_from_one_jaw_after_another(family: str) -> None:
    drawn, sides = draw_sealed(family), []
    middle = 0.5 * drawn.shape.clamp * _ALONG
    for size, most in ((1, 4.0), (2, 10.0)):
        scatter = np.array(draw_faults('clamp_offset/chuck key', drawn, size).clamp_scatter)
        for motion in scatter:
            turn = Rotation.from_rotvec(motion[3:], degrees=True)
            # The inner end stays, and the tip goes aside.
            inner = middle + turn.apply(-middle) + 1e-3 * motion[:3]
            assert inner == pytest.approx(0.0, abs=1e-6)
            tip = 1e3 * turn.apply(drawn.shape.length * _ALONG)
            assert np.hypot(*tip[1:]) == pytest.approx(most, rel=0.16)
            sides.append(np.arctan2(tip[2], tip[1]))
    # A third of a turn on each time, and where it was after three.
    ahead = np.diff(np.reshape(sides, (2, 4)), axis=1)
    assert np.exp(1j * ahead) == pytest.approx(np.exp(2j / 3.0 * np.pi), abs=1e-3)


def test_a_jet_is_fastest_some_way_from_its_wall() -> None:
    faults = Faults(tilt_point=(0.1, 0.2, 0.3), tilt_width=0.04)
    # Who goes along z has -x on the right.
    right = 0.04 * np.array([-1.0, 0.0, 0.5, 1.0, 2.0])
    places = np.column_stack([0.1 - right, np.linspace(-1.0, 1.0, 5), np.linspace(2.0, -3.0, 5)])
    found = wall_share(places, np.array([0.0, 0.0, 3.0]), faults)
    assert found == pytest.approx([0.0, 0.0, 0.25 * np.e, 1.0, 4.0 * np.exp(-2.0)])
    mirrored = Faults(tilt_point=(0.1, 0.2, 0.3), tilt_width=-0.04)
    places[:, 0] = 0.2 - places[:, 0]
    assert wall_share(places, np.array([0.0, 0.0, 3.0]), mirrored) == pytest.approx(found)


@pytest.mark.parametrize('pose', range(4))
def test_a_jet_pushes_a_body_by_how_far_from_the_wall_its_parts_are(
    setup: Setup, plain: Specimen, pose: int
) -> None:
    faults, view = draw_faults('gravity_tilt/wall jet', setup), setup.observations[pose]
    blown, still = (load_in_pose(plain, setup, view, each).forces for each in (faults, Faults()))
    pushes = (blown - still) @ view.world_from_object[:3, :3].T
    pushes /= plain.body.masses[:, None]
    x, z = np.deg2rad(faults.gravity_tilt)
    tilt = float(np.hypot(x, z))
    whole = GRAVITY * np.sin(tilt) / tilt * np.array([z, 0.0, -x])
    sizes = pushes @ whole / (whole @ whole)
    assert pushes == pytest.approx(np.outer(sizes, whole), abs=1e-9)
    assert 0.5 < sizes.max() <= 1.0
    free = plain.shares > 0.0
    assert not sizes[~free].any()
    # By how far all of them are along the level across the jet, from what the wall goes through.
    places = plain.mesh.nodes @ view.world_from_object[:3, :3].T + view.world_from_object[:3, 3]
    across = np.array([x, 0.0, z]) / tilt
    way = (places - faults.tilt_point) @ across / faults.tilt_width
    expected = np.where(way > 0.0, way**2 * np.exp(2.0 - 2.0 * way), 0.0)
    assert sizes[free] == pytest.approx(expected[free], abs=1e-9)


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_jet_moves_a_tip_by_some_4_and_up_to_10_mm(family: str) -> None:
    drawn = draw_sealed(family)
    plain = make_specimen(drawn, Faults(), COARSE)
    # It blows no harder than with the weight.
    for size, least, most in ((1, 2.5, 6.0), (2, 5.0, 14.0)):
        faults = draw_faults('gravity_tilt/wall jet', drawn, size)
        moves = tip_moves(drawn, plain, faults, plain.shares > 0.99)
        assert least < 1e3 * max(moves) < most


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_woven_body_is_bent_at_three_wires_alone_and_back_at_the_second(family: str) -> None:
    drawn = draw_sealed(family)
    free, step = drawn.shape.length - drawn.shape.clamp, 1e-5
    for size, most in ((1, 0.004), (2, 0.010)):
        faults = draw_faults('rest_curvature/woven', drawn, size)
        ahead = np.linspace(0.0, 1.0, 401)[:-1, None] + np.array([0.0, step])
        line = (drawn.shape.clamp + free * ahead.reshape(-1))[:, None] * _ALONG
        bent = stress_free_nodes(line, drawn.shape, faults).reshape(400, 2, 3)
        ways = (bent[:, 1] - bent[:, 0]) / (step * free)
        turns = np.cross(ways[:-1], ways[1:])
        wires = np.array(faults.curvature_wires)
        away = np.abs(0.5 * (ahead[1:, 0] + ahead[:-1, 0])[:, None] - wires)
        near = away < 0.5 * WIRE + 0.003
        assert len(wires) == 3
        assert np.abs(turns[~near.any(axis=1)]).max() < 1e-4
        # Each by as much, the second the other way.
        first, second, third = near.T.astype(float) @ turns
        assert np.linalg.norm(first) > 0.05
        assert second == pytest.approx(-first, abs=0.03 * np.linalg.norm(first))
        assert third == pytest.approx(first, abs=0.03 * np.linalg.norm(first))
        tip = stress_free_nodes(np.array([drawn.shape.length * _ALONG]), drawn.shape, faults)
        assert np.hypot(*tip[0, 1:]) == pytest.approx(most, rel=0.2)


@pytest.mark.slow
@pytest.mark.parametrize('family', ['beam', *SEALED])
@pytest.mark.parametrize(
    'key', ['added_mass/hourglass', 'stiffness_contrast/rolled sheets', 'compliant_clamp/hexapod']
)
def test_sizes_move_each_body_by_some_4_and_10_mm(family: str, key: str) -> None:
    drawn = draw_sealed(family)
    plain = make_specimen(drawn, Faults(), COARSE)
    for size, least, most in ((1, 2.5, 6.0), (2, 6.0, 14.0)):
        moves = tip_moves(drawn, plain, draw_faults(key, drawn, size), plain.shares > 0.99)
        assert least < 1e3 * max(moves) < most


def test_an_hourglass_draws_a_body_down_as_its_sand_runs(setup: Setup) -> None:
    faults, tips = draw_faults('added_mass/hourglass', setup), []
    tip = make_specimen(setup, Faults(), COARSE).shares > 0.99
    for number in (0, 2):
        found, clean = (
            rest_of(setup, each, number)[tip].mean(axis=0) for each in (faults, Faults())
        )
        down = -setup.observations[number].world_from_object[1, :3]
        tips.append(float((found - clean) @ down))
    assert min(tips) > 0.002
