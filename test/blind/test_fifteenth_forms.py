# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms and causes of the fifteenth set do what their labels say."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from support.blind_derivatives import check_derivatives
from support.blind_draws import draw_faults
from support.blind_rests import (
    clamp_motion_and_load,
    COARSE,
    lying,
    rest_of,
    tip_moves,
    tip_rises,
    turn_of,
)
from support.blind_views import with_and_without

from benchmarks.blind.contact import contact_laws
from benchmarks.blind.draught import stream_share
from benchmarks.blind.faults import Faults
from benchmarks.blind.fifteenth_outside import FIFTEENTH_OUTSIDE
from benchmarks.blind.flexure import flexure_compliance, post_compliance
from benchmarks.blind.knob import KNOB, knob_tops
from benchmarks.blind.laying import lay_on_plane, softer
from benchmarks.blind.magnetism import magnetic_forces
from benchmarks.blind.masses import film_thickness
from benchmarks.blind.material import constants, respond, stiffened
from benchmarks.blind.moduli import plug_share
from benchmarks.blind.renderer import on_tilted
from benchmarks.blind.rest_shape import stress_free_nodes, true_shape
from benchmarks.blind.rotations import rotation
from benchmarks.blind.setups import Setup
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.specimen import Specimen

UPRIGHT = np.array([0.0, 0.0, 1.0])


@pytest.mark.parametrize('pull', [1.02, 1.1, 1.5])
def test_hart_smiths_energy_is_the_integral_of_its_exponential(pull: float) -> None:
    plain = constants(np.array(1e5), 0.48)
    F = np.diag([pull, pull**-0.5, pull**-0.5])
    strain, mu, k = float((F**2).sum()) - 3.0, 0.75 * float(plain.shear), 80.0
    stiff = respond(F, stiffened(plain, 'hart_smith', k)).energy - respond(F, plain).energy
    whole = quad(lambda i: np.exp(k * i**2), 0.0, strain)[0]
    # Up to an exponent of 50 it is that, and grows evenly beyond.
    most = np.sqrt(50.0 / k)
    within = quad(lambda i: np.exp(k * i**2), 0.0, min(strain, most))[0]
    expected = within + np.exp(50.0) * max(strain - most, 0.0) - strain
    assert stiff == pytest.approx(0.5 * mu * expected, rel=1e-8)
    assert (within == whole) == (strain < most)


def test_hart_smiths_law_stiffens_nothing_that_is_pressed_from_all_sides() -> None:
    plain, F = constants(np.array(1e5), 0.48), 0.98 * np.eye(3)
    found, law = respond(F, stiffened(plain, 'hart_smith', 80.0)), respond(F, plain)
    assert found.energy == pytest.approx(law.energy)
    assert found.along == pytest.approx(law.along)


def test_a_body_of_hart_smiths_rubber_sags_less(setup: Setup) -> None:
    soft = softer(setup, 0.3)
    drawn = [draw_faults('strain_stiffening/hart_smith', soft, size) for size in (1, 2)]
    lifts = tip_rises(soft, drawn)
    assert 0.002 < lifts[0] < lifts[1] < 0.01


def test_a_plug_fills_the_section_at_the_clamp_and_comes_to_a_point() -> None:
    outward = np.linspace(0.0, 0.85, 18)
    assert plug_share(np.zeros(18), outward, 0.8) == pytest.approx(1.0)
    assert not plug_share(np.full(18, 0.81), outward, 0.8).any()
    # Halfway its border lies halfway out, and half of it is there.
    halfway = plug_share(np.full(3, 0.4), np.array([0.35, 0.5, 0.65]), 0.8)
    assert halfway == pytest.approx([1.0, 0.5, 0.0])


def test_a_plugged_root_is_softer_within_the_cone_alone(setup: Setup) -> None:
    faults = Faults(contrast=-1.5, contrast_mode='plugged', contrast_at=0.7)
    plugged, whole = (make_specimen(setup, each, 1.0) for each in (faults, Faults()))
    softer_by = np.log(np.asarray(plugged.body.numbers.shear / whole.body.numbers.shear))
    values, mesh = whole.body.quadrature.values, whole.mesh
    share = whole.shares[mesh.cells] @ values.T
    points = mesh.lattice[mesh.cells].swapaxes(1, 2) @ values.T
    half = 0.5 * np.array(setup.shape.section)[:, None]
    outward = (np.abs(points[:, 1:]) / half).max(axis=1)
    assert softer_by == pytest.approx(-1.5 * plug_share(share, outward, 0.7))
    assert softer_by.min() == pytest.approx(-1.5)
    assert not softer_by[share > 0.7].any()


def test_a_film_drains_by_the_root_of_the_way_and_lies_on_the_surface(setup: Setup) -> None:
    assert film_thickness(np.array([-0.1, 0.0, 0.25, 1.0])) == pytest.approx([0.0, 0.0, 0.5, 1.0])
    specimen = make_specimen(setup, Faults(mass_form='drained', added_mass=6.0))
    assert specimen.added.sum() == pytest.approx(6e-3)
    # The mean place of what goes with the root of it is 3/5.
    middle = float(specimen.added @ specimen.shares) / 6e-3
    assert middle == pytest.approx(0.6, abs=0.01)
    width, height = setup.shape.section
    outward = np.abs(specimen.mesh.lattice[:, 1:]) / (0.5 * np.array([width, height]))
    # As far out as is asked, however the nodes share it.
    spread_out = np.average(outward.max(axis=1), weights=np.maximum(specimen.added, 0.0))
    assert spread_out > np.average(outward.max(axis=1), weights=specimen.body.masses)


@pytest.mark.parametrize(
    ('found', 'ahead', 'twist'),
    [
        (flexure_compliance(0.3, 0.02), np.array([1.0, 0.0, 0.0]), 0.3),
        (post_compliance(0.3, 0.02), UPRIGHT, 0.39),
    ],
)
def test_the_end_of_a_beam_gives_way_as_all_its_slices_do(
    found: np.ndarray, ahead: np.ndarray, twist: float
) -> None:
    length, count = 0.02, 2000
    along = np.outer(ahead, ahead)
    per_slice = (0.3 * (np.eye(3) - along) + twist * along) / count
    whole = np.zeros((6, 6))
    for number in range(count):
        # From a slice to the end: a force there has this arm, and a turn of it this lever.
        arm = (1.0 - (number + 0.5) / count) * length * ahead
        cross = np.cross(arm, np.eye(3)).T
        carried = np.concatenate([cross.T, np.eye(3)])
        whole += carried @ per_slice @ carried.T
    assert np.allclose(found, whole, rtol=0.0, atol=1e-6 * np.abs(whole).max())
    assert np.array_equal(found, found.T)


@pytest.mark.parametrize('pose', range(4))
def test_a_clamp_on_a_post_rests_where_that_bears_the_body(
    setup: Setup, plain: Specimen, pose: int
) -> None:
    faults = draw_faults('compliant_clamp/post', setup)
    motion, load = clamp_motion_and_load(setup, plain, faults, pose)
    compliance = post_compliance(faults.clamp_compliance, faults.clamp_length)
    expected = compliance @ load
    assert motion[:3] == pytest.approx(expected[:3], abs=2e-5)
    assert motion[3:] == pytest.approx(expected[3:], abs=2e-3)


def test_a_screw_works_loose_by_a_factor_from_pose_to_pose(setup: Setup, plain: Specimen) -> None:
    faults = draw_faults('clamp_offset/loosening', setup)
    held, growth = plain.mesh.held, faults.clamp_growth
    for pose, steps in enumerate((0.0, 1.0, 1.0 + growth, 1.0 + growth + growth**2)):
        turn = turn_of(plain.mesh.nodes[held], rest_of(setup, faults, pose)[held])
        share = steps / (1.0 + growth + growth**2)
        assert turn == pytest.approx(share * np.deg2rad(faults.clamp_turn), abs=1e-4)


@pytest.fixture(scope='module')
def on_a_knob(setup: Setup) -> tuple[Setup, Faults]:
    """A set-up whose body lies on the end of a screw in the first pose, and that screw."""
    return lay_on_plane(setup, draw_faults('contact_plane/knob', setup), np.random.default_rng(1))


def test_a_knob_bears_a_body_by_its_outer_part_and_not_upside_down(
    on_a_knob: tuple[Setup, Faults], plain: Specimen
) -> None:
    laid, faults = on_a_knob
    assert faults.contact_height is not None
    (law,) = contact_laws(plain.areas, plain.shares, laid.observations[0], faults)
    middle = np.array([faults.contact_ahead, faults.contact_at, faults.contact_height - KNOB])
    moves, pushed = [], np.zeros(len(plain.shares), dtype=bool)
    for pose in range(4):
        found, move = lying(laid, plain, faults, pose)
        moves.append(move)
        pushed |= np.linalg.norm(law(found).gradient, axis=1) > 0.0
        # Nodes are outside the ball, but for what it sinks in.
        assert np.linalg.norm(found - middle, axis=1).min() > KNOB - 2e-4
    assert 0.007 < moves[0] < 0.013
    assert moves[0] == max(moves)
    assert moves[3] == 0.0
    assert pushed.any()
    assert np.abs(plain.shares[pushed] - faults.contact_share).max() < 0.2


def test_a_knob_presses_by_its_energy(on_a_knob: tuple[Setup, Faults], plain: Specimen) -> None:
    laid, faults = on_a_knob
    rest = rest_of(laid, faults)
    assert knob_tops(rest, faults).min() == pytest.approx(faults.contact_height, abs=1e-4)
    (law,) = contact_laws(plain.areas, plain.shares, laid.observations[0], faults)
    dented = rest - 0.003 * UPRIGHT
    assert law(dented).energy > law(rest).energy > 0.0
    check_derivatives(law, dented)


def test_a_stereo_pair_errs_by_the_square_of_the_depth_and_evenly_over_rows(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    faults = draw_faults('depth_affine/toed', setup)
    distance = float(np.linalg.norm(setup.depth_from_world[:3, 3]))
    for pose in (0, 3):
        view, right, there = with_and_without(plain, setup, faults, pose, rests[pose])
        rows = (right.row + np.arange(right.depth.shape[0]) - setup.camera.cy) / 240.0
        by_row = np.broadcast_to(1.0 + faults.depth_roll * rows[:, None, None], there.shape)
        expected = 1e-3 * faults.depth_bias * by_row * (right.depth / distance) ** 2
        assert view.depth[there] - right.depth[there] == pytest.approx(expected[there], abs=1e-9)
        assert 0.004 < np.abs(expected[there]).max() < 0.025


def test_rays_meet_a_tilted_imager_where_its_plane_is() -> None:
    x, y = np.random.default_rng(3).uniform(-0.3, 0.3, (2, 50))
    one, other = on_tilted(x, y, (0.2, -0.15))
    # In space: from where the axis meets the imager along its own two sides.
    sides = rotation(np.array([0.2, 0.0, 0.0])) @ rotation(np.array([0.0, -0.15, 0.0]))
    met = UPRIGHT + one[:, None] * sides[:, 0] + other[:, None] * sides[:, 1]
    assert met[:, :2] / met[:, 2:] == pytest.approx(np.stack([x, y], axis=1))
    level = on_tilted(x, y, (0.0, 0.0))
    assert np.stack(level) == pytest.approx(np.stack([x, y]))


def test_a_tilted_imager_moves_what_is_seen_of_the_axis_nowhere_by_itself(setup: Setup) -> None:
    faults = draw_faults('camera_offset/tilted imager', setup)
    right = setup.camera
    tilted = replace(right, tilt=faults.imager_tilt)
    points = np.array([[0.0, 0.0, 0.33], [0.06, 0.03, 0.33], [-0.06, -0.03, 0.33]])
    moves = np.linalg.norm(tilted.project(points) - right.project(points), axis=1)
    assert moves[0] < 1e-9
    assert moves[1:].max() > 1.0


def test_a_draught_falls_beside_its_axis_and_not_along_it() -> None:
    faults = Faults(tilt_point=(0.01, 0.02, 0.03), tilt_width=0.06)
    way = np.array([0.3, 0.0, 1.0])
    on_axis = np.array(faults.tilt_point) + np.array([-0.2, 0.0, 0.1])[:, None] * way
    assert stream_share(on_axis, way, faults) == pytest.approx(1.0)
    beside = on_axis + 0.06 * np.array([0.0, 1.0, 0.0])
    assert stream_share(beside, way, faults) == pytest.approx(np.exp(-1.0))
    assert stream_share(beside + 0.5 * way, 2.0 * way, faults) == pytest.approx(np.exp(-1.0))


def test_a_draught_blows_less_where_a_body_is_out_of_it(setup: Setup) -> None:
    faults = draw_faults('gravity_tilt/draught', setup)
    tip = make_specimen(setup, Faults(), COARSE).shares > 0.99
    x, y, z = faults.tilt_point
    moves = []
    for up in (0.0, 0.05, 0.2):
        found = rest_of(setup, replace(faults, tilt_point=(x, y + up, z)))
        moves.append(float(np.linalg.norm((found - rest_of(setup, Faults()))[tip].mean(axis=0))))
    assert moves[0] > moves[1] > moves[2]
    assert moves[2] < 1e-4


def test_a_buckled_body_is_bent_most_in_the_middle_and_its_tip_is_as_far_as_an_arcs(
    setup: Setup,
) -> None:
    shape = setup.shape
    nodes = np.zeros((121, 3))
    nodes[:, 0] = np.linspace(shape.clamp, shape.length, 121)
    faults = Faults(rest_curvature=(0.0, 0.3), curvature_form='buckled')
    buckled = stress_free_nodes(nodes, shape, faults)
    arc = stress_free_nodes(nodes, shape, replace(faults, curvature_form='arc'))
    assert buckled[-1, 1] == pytest.approx(arc[-1, 1], rel=0.02)
    steps = np.diff(buckled, axis=0)
    turns = np.diff(np.arctan2(steps[:, 1], steps[:, 0]))
    # Of one sine: as much in the middle third as in both others together.
    whole, middle = turns.sum(), turns[39:79].sum()
    assert middle / whole == pytest.approx(0.5, abs=0.03)
    assert whole == pytest.approx(0.3 * (shape.length - shape.clamp), rel=0.02)


def test_a_field_pulls_on_nodes_by_its_energy_and_on_the_whole_by_none(
    plain: Specimen, rests: list[np.ndarray]
) -> None:
    field, body = np.array([30.0, -50.0, 20.0]), plain.body
    forces = magnetic_forces(body, field)

    def energy(positions: np.ndarray) -> float:
        F = np.swapaxes(positions[body.cells], 1, 2)[:, None] @ body.quadrature.gradients
        return -float((body.quadrature.volumes[..., None] * F[..., 0] * field).sum())

    move, h = np.random.default_rng(4).standard_normal(rests[0].shape), 1e-5
    slope = (energy(rests[0] + h * move) - energy(rests[0] - h * move)) / (2.0 * h)
    assert slope == pytest.approx(-float((forces * move).sum()), rel=1e-6)
    assert forces.sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-9)


@pytest.mark.parametrize('cause', sorted(FIFTEENTH_OUTSIDE))
def test_a_cause_outside_moves_a_tip_by_some_4_and_10_mm(
    setup: Setup, plain: Specimen, cause: str
) -> None:
    for size, least, most in ((1, 2.5, 6.0), (2, 7.0, 15.0)):
        drawn = FIFTEENTH_OUTSIDE[cause](size, setup, np.random.default_rng(8))
        moves = tip_moves(setup, plain, Faults(**drawn.changes), plain.shares > 0.99)
        assert least < 1e3 * max(moves) < most


def test_a_neck_is_thinnest_in_its_middle_and_nowhere_else_thinner(setup: Setup) -> None:
    shape = true_shape(setup.shape, Faults(necked=0.3, necked_at=0.2))
    shares = np.array([0.0, 0.05, 0.125, 0.2, 0.35, 1.0])
    places = np.stack(
        [shape.clamp + shares * (shape.length - shape.clamp), 0.01 + 0.0 * shares, 0.0 * shares],
        axis=1,
    )
    thinner = 1.0 - shape.place(places)[:, 1] / 0.01
    assert thinner == pytest.approx([0.0, 0.0, 0.15, 0.3, 0.0, 0.0])
