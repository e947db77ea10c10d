# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the thirty-third set that are of body, rig and air do what their labels say."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.blind_contact import check_pushes, moves_and_outer_dents
from support.blind_derivatives import check_derivatives
from support.blind_draws import draw_faults, draw_sealed, SEALED, STEPS
from support.blind_rests import COARSE, rest_of, tip_moves

from benchmarks.blind.draught import spread_out
from benchmarks.blind.faults import Faults
from benchmarks.blind.harness import wires_share
from benchmarks.blind.heat_gun import gun_heat, spread_heat
from benchmarks.blind.laying import lay_on_plane
from benchmarks.blind.loads import load_in_pose
from benchmarks.blind.motor_heat import heated_on
from benchmarks.blind.pitching import belt_errors, stated_pitches
from benchmarks.blind.rest_shape import stress_free_nodes
from benchmarks.blind.rim import rim, rim_tops
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.wrapping import CORNER

_ALONG = np.array([1.0, 0.0, 0.0])


def test_one_wire_less_goes_on_beyond_each_gauge() -> None:
    share = np.array([[0.0, 0.39], [0.41, 0.69], [0.71, 0.99]])
    found = wires_share(share, (0.4, 0.7, 0.95))
    assert found == pytest.approx(np.array([[3, 3], [2, 2], [1, 0]]) / 3.0)
    assert not wires_share(share, ()).any()


def test_a_harness_weighs_as_its_wires_do_and_lies_on_the_upper_side(setup: Setup) -> None:
    gauges = np.array([0.4, 0.6, 0.95])
    faults = Faults(mass_form='harness', added_mass=20.0, mass_gauges=tuple(gauges))
    specimen = make_specimen(setup, faults)
    added = specimen.added
    assert 1e3 * added.sum() == pytest.approx(20.0)
    # Each wire is as heavy by its length, from the clamp to its gauge.
    for power in (1, 2):
        expected = (gauges ** (power + 1)).sum() / (power + 1) / gauges.sum()
        found = added @ np.clip(specimen.shares, 0.0, 1.0) ** power / added.sum()
        assert found == pytest.approx(expected, abs=0.02)
    heights = specimen.mesh.nodes[:, 2] / (0.5 * setup.shape.section[1])
    assert added @ heights / added.sum() > 0.5


def test_heat_spreads_by_its_equation() -> None:
    share, step, later = np.linspace(-0.4, 1.0, 15), 1e-3, 1e-4
    at, width, wider = 0.2, 0.15, 0.4

    def warm(place: np.ndarray, time: float) -> np.ndarray:
        grown = 1.0 + wider * time
        return spread_heat(place, at, width * np.sqrt(grown), wider, 0) / np.sqrt(grown)

    assert warm(share, 2.0) == pytest.approx(spread_heat(share, at, width, wider, 2))
    # A quarter of the rate at which the square of its width grows is the diffusivity.
    curve = (warm(share + step, 1.0) - 2.0 * warm(share, 1.0) + warm(share - step, 1.0)) / step**2
    rate = (warm(share, 1.0 + later) - warm(share, 1.0 - later)) / (2.0 * later)
    expected = 0.25 * wider * width**2 * curve
    assert rate == pytest.approx(expected, abs=1e-4 * np.abs(expected).max())
    assert np.abs(expected).max() > 0.01
    assert spread_heat(np.array([at, at + width]), at, width, wider, 0) == pytest.approx(
        [1.0, np.exp(-1.0)]
    )


@pytest.mark.parametrize('family', ['beam', 'tee'])
def test_a_body_is_softer_where_a_gun_warmed_it(family: str) -> None:
    drawn = draw_sealed(family)
    faults = draw_faults('stiffness_contrast/heat gun', drawn)
    heated, whole = (make_specimen(drawn, each, COARSE) for each in (faults, Faults()))
    share = whole.shares[whole.mesh.cells] @ whole.body.quadrature.values.T
    for pose in range(4):
        numbers = heated_on(heated, pose, faults).body.numbers
        for found, before in (
            (numbers.shear, whole.body.numbers.shear),
            (numbers.bulk, whole.body.numbers.bulk),
        ):
            softer = np.log(np.asarray(found / before))
            assert softer == pytest.approx(
                faults.contrast * gun_heat(share, faults, pose), abs=1e-9
            )
            assert softer.min() < -0.3


def test_a_body_rests_in_a_pose_as_one_on_which_heat_is_so_from_the_first(setup: Setup) -> None:
    faults = draw_faults('stiffness_contrast/heat gun', setup)
    grown = np.sqrt(1.0 + 2.0 * faults.contrast_wider)
    spread = Faults(
        contrast_mode='heat gun',
        contrast=faults.contrast / grown,
        contrast_at=faults.contrast_at,
        contrast_width=faults.contrast_width * grown,
    )
    assert rest_of(setup, faults, 2) == pytest.approx(rest_of(setup, spread, 2), abs=1e-7)
    moved = rest_of(setup, faults, 2) - rest_of(setup, Faults(), 2)
    assert np.linalg.norm(moved, axis=1).max() > 0.003


@pytest.fixture(scope='module')
def on_rim(setup: Setup) -> tuple[Setup, Faults]:
    """A set-up whose body lies on a bucket's rim in the first pose, and that."""
    drawn = draw_faults('contact_plane/rim', setup)
    return lay_on_plane(setup, drawn, np.random.default_rng(1))


def test_a_rim_lifts_a_body_that_lies_on_it(on_rim: tuple[Setup, Faults], plain: Specimen) -> None:
    laid, faults = on_rim
    moves, dents = moves_and_outer_dents(laid, plain, faults, 0.6)
    assert 0.006 < moves[0] < 0.015
    assert moves[2] > 0.001
    assert moves[1] == moves[3] == 0.0
    assert 0.0 < dents[0] < 0.0005
    assert max(dents[1], dents[3]) < -0.005


_BUCKET = Faults(
    contact_form='rim',
    contact_ahead=0.01,
    contact_at=-0.02,
    contact_ring=0.04,
    contact_round=0.012,
    contact_height=0.03,
)


def test_a_rim_is_a_circle_and_round_across_itself() -> None:
    away = np.array([-0.012, -0.003, 0.0, 0.002, 0.01])
    for angle in np.deg2rad([0.0, 70.0, 200.0]):
        way = np.array([np.cos(angle), 0.0, np.sin(angle)])
        points = np.array([0.01, 0.05, -0.02]) + (0.04 + away)[:, None] * way
        # As low as a parabola of the radius 12 mm.
        assert rim_tops(points, _BUCKET) == pytest.approx(0.05 + away**2 / 0.024, abs=1e-12)


@pytest.mark.parametrize('step', STEPS)
def test_a_rim_pushes_by_its_energy(
    on_rim: tuple[Setup, Faults], plain: Specimen, step: float
) -> None:
    laid, faults = on_rim
    check_pushes(laid, plain, faults, step)
    # On all sides of it as well.
    view = draw_sealed('waist').observations[2]
    turn, shift = view.world_from_object[:3, :3], view.world_from_object[:3, 3]
    random = np.random.default_rng(6)
    angles, far = random.uniform(0.0, 2.0 * np.pi, 6), random.uniform(0.031, 0.049, 6)
    points = np.column_stack([0.01 + far * np.cos(angles), far, -0.02 + far * np.sin(angles)])
    dents = np.array([-0.002, 0.001, 0.002, 0.003, 0.004, 0.002])
    points[:, 1] += 0.03 - dents - rim_tops(points, _BUCKET)
    law = rim(view, _BUCKET, np.array([9.0, 5.0, 7.0, 3.0, 4.0, 6.0]) * 100.0)
    found = law((points - shift) @ turn)
    assert found.energy == pytest.approx(
        50.0 * float((np.array([0.0, 5.0, 7.0, 3.0, 4.0, 6.0]) * dents**2).sum())
    )
    stiff = check_derivatives(law, (points - shift) @ turn, step=step, share=1e-4)
    assert stiff.any(axis=1).tolist() == [False, True, True, True, True, True]


def test_a_belt_slips_down_on_every_turn_and_stays_there() -> None:
    pitches = np.deg2rad([5.0, 5.0, -35.0, 25.0, 20.0])
    assert np.rad2deg(belt_errors(pitches)) == pytest.approx([0.0, 0.0, -40.0, -100.0, -105.0])


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_jaws_on_a_belt_are_pitched_down_about_their_hinge(family: str) -> None:
    drawn = draw_sealed(family)
    middle, turned = 0.5 * drawn.shape.clamp * _ALONG, np.diff(stated_pitches(drawn))
    for size, most in ((1, 4.0), (2, 10.0)):
        scatter = np.array(draw_faults('clamp_offset/belt', drawn, size).clamp_scatter)
        falls = []
        for pose, motion in zip(drawn.observations, scatter, strict=True):
            turn = Rotation.from_rotvec(motion[3:], degrees=True)
            assert middle + turn.apply(-middle) + 1e-3 * motion[:3] == pytest.approx(0.0, abs=1e-6)
            tip = 1e3 * drawn.shape.length * (turn.apply(_ALONG) - _ALONG)
            # Straight down, across the body.
            down = -pose.world_from_object[1, :3] @ tip
            level = np.cross(pose.world_from_object[:3, 0], [0.0, 1.0, 0.0])
            assert abs(float(level @ pose.world_from_object[:3, :3] @ tip)) < 0.02
            falls.append(np.linalg.norm(tip) * np.sign(down))
        assert falls[-1] == pytest.approx(most, rel=0.16)
        # By a share of the way so far.
        gone = np.concatenate([[0.0], np.cumsum(np.abs(turned))])
        assert falls == pytest.approx(falls[-1] * gone / gone[-1], abs=0.03)


def test_air_that_comes_down_spreads_to_all_sides() -> None:
    faults = Faults(tilt_point=(0.1, 0.7, -0.2), tilt_width=0.2)
    angles = np.deg2rad([10.0, 120.0, 250.0, 330.0, 45.0])
    ways = np.column_stack([np.cos(angles), np.zeros(5), np.sin(angles)])
    places = np.array([0.1, -0.3, -0.2]) + 0.2 * np.array([[0.5, 1.0, 2.0, 4.0, 0.0]]).T * ways
    found = spread_out(places, np.array([3.0, 0.0, -4.0]), faults)
    speeds = np.array([0.8, 1.0, 0.8, 8.0 / 17.0, 0.0])
    assert found == pytest.approx(5.0 * speeds[:, None] ** 2 * ways, abs=1e-9)


@pytest.mark.parametrize('pose', range(4))
def test_air_pushes_a_body_away_from_where_it_comes_down(
    setup: Setup, plain: Specimen, pose: int
) -> None:
    faults, view = draw_faults('gravity_tilt/downwash', setup), setup.observations[pose]
    blown, still = (load_in_pose(plain, setup, view, each).forces for each in (faults, Faults()))
    pushes = (blown - still) @ view.world_from_object[:3, :3].T
    pushes /= plain.body.masses[:, None]
    places = plain.mesh.nodes @ view.world_from_object[:3, :3].T + view.world_from_object[:3, 3]
    away = (places - faults.tilt_point)[:, [0, 2]]
    far = np.linalg.norm(away, axis=1)
    x, z = np.deg2rad(faults.gravity_tilt)
    tilt = float(np.hypot(x, z))
    most = GRAVITY * np.sin(tilt)
    ratio = far / faults.tilt_width
    expected = most * (2.0 * ratio / (1.0 + ratio**2)) ** 2
    free = plain.shares > 0.0
    assert pushes[:, 1] == pytest.approx(0.0, abs=1e-12)
    assert not pushes[~free].any()
    assert pushes[free][:, [0, 2]] == pytest.approx(
        (expected / far)[free, None] * away[free], abs=1e-9
    )
    # Where the body is it blows about as it is stated, most of what is possible.
    stated = np.array([z, -x]) / tilt
    assert (pushes[free][:, [0, 2]] @ stated > 0.5 * most).all()


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_air_that_spreads_moves_a_tip_by_some_4_and_up_to_10_mm(family: str) -> None:
    drawn = draw_sealed(family)
    plain = make_specimen(drawn, Faults(), COARSE)
    # It blows no harder than with the weight.
    for size, least, most in ((1, 2.5, 6.5), (2, 5.0, 15.0)):
        faults = draw_faults('gravity_tilt/downwash', drawn, size)
        moves = tip_moves(drawn, plain, faults, plain.shares > 0.99)
        assert least < 1e3 * max(moves) < most


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_wrapped_body_is_bent_at_three_corners_alone_and_the_same_way(family: str) -> None:
    drawn = draw_sealed(family)
    free, step = drawn.shape.length - drawn.shape.clamp, 1e-5
    for size, most in ((1, 0.004), (2, 0.010)):
        faults = draw_faults('rest_curvature/wrapped', drawn, size)
        ahead = np.linspace(0.0, 1.0, 401)[:-1, None] + np.array([0.0, step])
        line = (drawn.shape.clamp + free * ahead.reshape(-1))[:, None] * _ALONG
        bent = stress_free_nodes(line, drawn.shape, faults).reshape(400, 2, 3)
        ways = (bent[:, 1] - bent[:, 0]) / (step * free)
        turns = np.cross(ways[:-1], ways[1:])
        corners = np.array(faults.curvature_corners)
        away = np.abs(0.5 * (ahead[1:, 0] + ahead[:-1, 0])[:, None] - corners)
        near = away < 0.5 * CORNER + 0.003
        assert np.diff(corners) == pytest.approx(np.diff(corners).mean(), abs=2e-4)
        assert np.abs(turns[~near.any(axis=1)]).max() < 1e-4
        first, second, third = near.T.astype(float) @ turns
        assert np.linalg.norm(first) > 0.02
        for other in (second, third):
            assert other == pytest.approx(first, abs=0.03 * np.linalg.norm(first))
        tip = stress_free_nodes(np.array([drawn.shape.length * _ALONG]), drawn.shape, faults)
        assert np.hypot(*tip[0, 1:]) == pytest.approx(most, rel=0.2)


@pytest.mark.slow
@pytest.mark.parametrize('family', ['beam', *SEALED])
@pytest.mark.parametrize('key', ['added_mass/harness', 'stiffness_contrast/heat gun'])
def test_sizes_move_each_body_by_some_4_and_10_mm(family: str, key: str) -> None:
    drawn = draw_sealed(family)
    plain = make_specimen(drawn, Faults(), COARSE)
    for size, least, most in ((1, 2.5, 6.0), (2, 6.0, 14.0)):
        moves = tip_moves(drawn, plain, draw_faults(key, drawn, size), plain.shares > 0.99)
        assert least < 1e3 * max(moves) < most
