# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the thirty-first set that are of body, rig and air do what their labels say."""

import numpy as np
import pytest
from scipy.integrate import quad
from support.blind_contact import check_pushes, moves_and_outer_dents
from support.blind_derivatives import check_derivatives
from support.blind_draws import draw_faults, draw_sealed, SEALED, STEPS
from support.blind_rests import check_rests_where_borne, COARSE, rest_of, tip_moves

from benchmarks.blind.draught import eddy_share
from benchmarks.blind.faults import Faults
from benchmarks.blind.flexure import strap_compliance
from benchmarks.blind.laying import lay_on_plane
from benchmarks.blind.loads import load_in_pose
from benchmarks.blind.motor_heat import heated_on, heated_share
from benchmarks.blind.over_rod import rod_moment
from benchmarks.blind.rest_shape import stress_free_nodes
from benchmarks.blind.saddle import saddle, saddle_tops
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.specimen import Specimen

_ALONG = np.array([1.0, 0.0, 0.0])


@pytest.mark.parametrize('wind', [0.5, -0.4])
def test_a_wire_winds_around_a_body(setup: Setup, wind: float) -> None:
    faults = Faults(
        mass_form='vine', added_mass=20.0, added_mass_at=0.3, mass_wind=wind, mass_side=40.0
    )
    specimen, half = make_specimen(setup, faults), 0.5 * np.array(setup.shape.section)
    added, nodes = specimen.added, specimen.mesh.nodes
    assert 1e3 * added.sum() == pytest.approx(20.0)
    # About an axis along the body its moments are those of a wire on the ellipse in its section.
    shares = (nodes[:, 0] - setup.shape.clamp) / (setup.shape.length - setup.shape.clamp)
    assert np.abs(added[shares < 0.1]).max() == 0.0
    for power in (0, 1):
        moments = (added * shares**power) @ nodes[:, 1:] / half / added.sum()
        for found, wave in zip(moments, (np.cos, np.sin), strict=True):
            expected = quad(
                lambda s, wave=wave, power=power: (
                    s**power * wave(np.deg2rad(40.0) + 2.0 * np.pi * (s - 0.3) / wind) / 0.7
                ),
                0.3,
                1.0,
            )[0]
            assert found == pytest.approx(expected, abs=0.06)
    assert added @ shares / added.sum() == pytest.approx(0.65, abs=0.03)


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_wire_is_beyond_its_beginning_and_as_heavy_as_told(family: str) -> None:
    drawn = draw_sealed(family)
    faults = draw_faults('added_mass/vine', drawn)
    specimen = make_specimen(drawn, faults, COARSE)
    assert 1e3 * specimen.added.sum() == pytest.approx(faults.added_mass)
    assert 0.25 < abs(faults.mass_wind) < 0.65
    middle = specimen.added @ specimen.shares / specimen.added.sum()
    assert 0.05 < middle - faults.added_mass_at < 0.65


def test_heat_goes_on_by_the_root_of_the_time() -> None:
    share, step, later = np.linspace(0.1, 1.0, 10), 1e-3, 1e-5
    # By the equation of heat: the square of the width goes with the time.
    width = 0.3
    one, here, other = (heated_share(share + way * step, width, 2) for way in (-1.0, 0.0, 1.0))
    grown = heated_share(share, float(np.sqrt(width**2 + later / 3.0)), 2) - here
    expected = 0.25 * later * (one - 2.0 * here + other) / step**2
    assert grown == pytest.approx(expected, abs=1e-4 * np.abs(expected).max() + 1e-12)
    assert np.abs(expected).max() > 1e-6
    assert heated_share(share, width, 3) == pytest.approx(heated_share(0.5 * share, width, 0))
    assert heated_share(np.zeros(1), width, 3)[0] == 1.0


@pytest.mark.parametrize('family', ['beam', 'tee'])
def test_a_body_is_softer_as_far_as_heat_has_come(family: str) -> None:
    drawn = draw_sealed(family)
    faults = draw_faults('stiffness_contrast/motor heat', drawn)
    heated, whole = (make_specimen(drawn, each, COARSE) for each in (faults, Faults()))
    share = whole.shares[whole.mesh.cells] @ whole.body.quadrature.values.T
    for pose in range(4):
        numbers = heated_on(heated, pose, faults).body.numbers
        for found, before in (
            (numbers.shear, whole.body.numbers.shear),
            (numbers.bulk, whole.body.numbers.bulk),
        ):
            softer = np.log(np.asarray(found / before))
            expected = faults.contrast * heated_share(share, faults.contrast_width, pose)
            assert softer == pytest.approx(expected, abs=1e-9)
        assert softer.min() < -0.3


def test_a_warm_body_rests_in_a_pose_as_one_that_is_so_from_the_first(setup: Setup) -> None:
    faults = draw_faults('stiffness_contrast/motor heat', setup)
    wider = Faults(
        contrast_mode='seeped',
        contrast=faults.contrast,
        contrast_width=faults.contrast_width * np.sqrt(3.0),
    )
    assert rest_of(setup, faults, 2) == pytest.approx(rest_of(setup, wider, 2), abs=1e-7)
    moved = rest_of(setup, faults, 2) - rest_of(setup, Faults(), 2)
    assert np.linalg.norm(moved, axis=1).max() > 0.003


def test_a_strap_gives_way_as_its_parts_do() -> None:
    by_turn, length, parts = 0.4, 0.05, 20000
    # Castigliano's theorem along it, from the clamp to the foot, of a strap as wide as 6 times
    # its thickness: of bending about the thin way 1, about the other 1/36, and of twist
    # (1 + nu) / 2 of that, by 3 over width and cubed thickness.
    part = (np.arange(parts) + 0.5) / parts
    places = -length * part[:, None] * _ALONG
    moments = np.eye(6)[:, None, 3:] - np.cross(places, np.eye(6)[:, None, :3])
    turned = 0.5 * np.pi * part
    thin = moments[..., 1] * np.cos(turned) + moments[..., 2] * np.sin(turned)
    thick = moments[..., 2] * np.cos(turned) - moments[..., 1] * np.sin(turned)
    twist = moments[..., 0]
    whole = thin @ thin.T + thick @ thick.T / 36.0 + 0.65 * twist @ twist.T
    found = strap_compliance(by_turn, length)
    assert found == pytest.approx(by_turn * whole / whole[4, 4], abs=1e-6 * by_turn)
    assert found[4, 4] == pytest.approx(by_turn)
    # What draws it down moves it aside as well.
    assert abs(found[1, 2]) > 0.2 * found[2, 2]


@pytest.mark.parametrize('pose', [0, 1])
def test_a_clamp_on_a_strap_rests_where_that_bears_the_body(
    setup: Setup, plain: Specimen, pose: int
) -> None:
    faults = draw_faults('compliant_clamp/twisted strap', setup)
    compliance = strap_compliance(faults.clamp_compliance, faults.clamp_length)
    check_rests_where_borne(setup, plain, faults, pose, compliance)


@pytest.fixture(scope='module')
def on_saddle(setup: Setup) -> tuple[Setup, Faults]:
    """A set-up whose body lies on a saddle in the first pose, and that."""
    drawn = draw_faults('contact_plane/saddle', setup)
    return lay_on_plane(setup, drawn, np.random.default_rng(1))


def test_a_saddle_lifts_a_body_that_lies_on_it(
    on_saddle: tuple[Setup, Faults], plain: Specimen
) -> None:
    laid, faults = on_saddle
    moves, dents = moves_and_outer_dents(laid, plain, faults, 0.6)
    assert 0.006 < moves[0] < 0.014
    assert moves[2] > 0.001
    assert moves[1] == moves[3] == 0.0
    assert 0.0 < dents[0] < 0.0005
    assert max(dents[1], dents[3]) < -0.005


_SEAT = Faults(
    contact_form='saddle',
    contact_ahead=0.01,
    contact_at=-0.02,
    contact_round=0.08,
    contact_slant=25.0,
    contact_height=0.03,
)


def test_a_saddle_rises_along_one_way_and_falls_along_the_other() -> None:
    angle, away = np.deg2rad(25.0), np.array([-0.03, 0.0, 0.01, 0.02])
    for turned, sign in ((0.0, 1.0), (0.5 * np.pi, -1.0), (0.25 * np.pi, 0.0)):
        way = np.array([np.cos(angle + turned), 0.0, np.sin(angle + turned)])
        points = np.array([0.01, 0.05, -0.02]) + away[:, None] * way
        # As high as a parabola of the radius 80 mm.
        expected = 0.05 - sign * away**2 / 0.16
        assert saddle_tops(points, _SEAT) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize('step', STEPS)
def test_a_saddle_pushes_by_its_energy(
    on_saddle: tuple[Setup, Faults], plain: Specimen, step: float
) -> None:
    laid, faults = on_saddle
    check_pushes(laid, plain, faults, step)
    # On all sides of it as well.
    view = draw_sealed('waist').observations[2]
    turn, shift = view.world_from_object[:3, :3], view.world_from_object[:3, 3]
    points = np.random.default_rng(5).uniform(-0.04, 0.04, (6, 3))
    dents = np.array([-0.002, 0.001, 0.002, 0.003, 0.004, 0.002])
    points[:, 1] += 0.03 - dents - saddle_tops(points, _SEAT)
    law = saddle(view, _SEAT, np.array([9.0, 5.0, 7.0, 3.0, 4.0, 6.0]) * 100.0)
    found = law((points - shift) @ turn)
    assert found.energy == pytest.approx(
        50.0 * float((np.array([0.0, 5.0, 7.0, 3.0, 4.0, 6.0]) * dents**2).sum())
    )
    stiff = check_derivatives(law, (points - shift) @ turn, step=step, share=1e-4)
    assert stiff.any(axis=1).tolist() == [False, True, True, True, True, True]


def test_air_comes_back_below_an_edge() -> None:
    faults = Faults(tilt_point=(0.3, 0.02, -0.1), tilt_width=0.015)
    heights = 0.02 + 0.015 * np.array([-9.0, -1.0, -0.2, 0.0, 0.2, 1.0, 9.0])
    places = np.column_stack([np.linspace(-1.0, 1.0, 7), heights, np.linspace(2.0, -3.0, 7)])
    found = eddy_share(places, np.array([0.6, 0.0, 0.8]), faults)
    slow, fast = ((np.exp(2.0 * q) - 1.0) / (np.exp(2.0 * q) + 1.0) for q in (0.2, 1.0))
    expected = [-1.0, -(fast**2), -(slow**2), 0.0, slow**2, fast**2, 1.0]
    assert found == pytest.approx(np.array(expected), abs=1e-6)


@pytest.mark.parametrize('pose', range(4))
def test_air_pushes_a_body_by_the_height_of_its_parts(
    setup: Setup, plain: Specimen, pose: int
) -> None:
    faults, view = draw_faults('gravity_tilt/eddy', setup), setup.observations[pose]
    blown, still = (load_in_pose(plain, setup, view, each).forces for each in (faults, Faults()))
    pushes = (blown - still) @ view.world_from_object[:3, :3].T
    pushes /= plain.body.masses[:, None]
    x, z = np.deg2rad(faults.gravity_tilt)
    tilt = float(np.hypot(x, z))
    whole = GRAVITY * np.sin(tilt) / tilt * np.array([z, 0.0, -x])
    sizes = pushes @ whole / (whole @ whole)
    assert pushes == pytest.approx(np.outer(sizes, whole), abs=1e-9)
    assert 0.2 < np.abs(sizes).max() <= 1.0
    places = plain.mesh.nodes @ view.world_from_object[:3, :3].T + view.world_from_object[:3, 3]
    speed = np.tanh((places[:, 1] - faults.tilt_point[1]) / faults.tilt_width)
    free = plain.shares > 0.0
    assert sizes[free] == pytest.approx((np.sign(speed) * speed**2)[free], abs=1e-9)
    assert not sizes[~free].any()


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_air_over_a_box_moves_a_tip_by_some_4_and_up_to_10_mm(family: str) -> None:
    drawn = draw_sealed(family)
    plain = make_specimen(drawn, Faults(), COARSE)
    # It blows no harder than with the weight.
    for size, least, most in ((1, 2.5, 6.0), (2, 5.0, 14.0)):
        faults = draw_faults('gravity_tilt/eddy', drawn, size)
        moves = tip_moves(drawn, plain, faults, plain.shares > 0.99)
        assert least < 1e3 * max(moves) < most


@pytest.mark.parametrize('at', [0.42, 0.5, 0.57])
def test_a_beam_over_a_rod_is_held_by_both_ends(at: float) -> None:
    # It turns and shifts neither end, and its moment changes evenly but at the rod.
    turned = quad(rod_moment, 0.0, 1.0, args=(at,), points=[at])[0]
    shifted = quad(lambda s: rod_moment(s, at) * (1.0 - s), 0.0, 1.0, points=[at])[0]
    assert [turned, shifted] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert rod_moment(at, at) == pytest.approx(1.0)
    for begin, end in ((0.0, at - 1e-9), (at, 1.0)):
        places = np.linspace(begin, end, 9)
        bends = np.diff([rod_moment(float(place), at) for place in places], 2)
        assert bends == pytest.approx(0.0, abs=1e-7)


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_body_over_a_rod_is_aside_amid_its_length_alone(family: str) -> None:
    drawn = draw_sealed(family)
    free = drawn.shape.length - drawn.shape.clamp
    ahead = np.linspace(0.0, 1.0, 201)
    for size, most in ((1, 0.004), (2, 0.010)):
        faults = draw_faults('rest_curvature/over a rod', drawn, size)
        line = np.outer(drawn.shape.clamp + free * ahead, _ALONG)
        bent = stress_free_nodes(line, drawn.shape, faults)
        aside = bent[:, 2] * np.sign(faults.rest_curvature[0])
        assert bent[:, 1] == pytest.approx(0.0, abs=1e-12)
        # A beam's cubic between its held end and the rod, and its tip no farther than as it is
        # drawn in.
        part = ahead / faults.curvature_at
        cubic = part**2 * (3.0 - 2.0 * part)
        inner = part < 1.0
        assert aside.max() == pytest.approx(most, rel=0.2)
        assert aside[inner] / aside.max() == pytest.approx(cubic[inner], abs=0.06)
        assert abs(aside[-1]) < 0.06 * most
        ends = np.outer(drawn.shape.length - np.array([1e-6, 0.0]), _ALONG)
        last = 1e6 * np.diff(stress_free_nodes(ends, drawn.shape, faults), axis=0)[0]
        assert last == pytest.approx(_ALONG, abs=1e-4)
