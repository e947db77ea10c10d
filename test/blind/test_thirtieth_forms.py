# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the thirtieth set that are of body, rig and air do what their labels say."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.spatial.transform import Rotation
from support.blind_contact import check_pushes, moves_and_dents
from support.blind_derivatives import check_derivatives
from support.blind_draws import draw_faults, draw_sealed, SEALED, STEPS
from support.blind_jaws import pitched_in_poses
from support.blind_rests import check_rests_where_borne, COARSE

from benchmarks.blind.draught import hollow_share
from benchmarks.blind.faults import Faults
from benchmarks.blind.flexure import hairpin_compliance
from benchmarks.blind.laying import lay_on_plane
from benchmarks.blind.loads import load_in_pose
from benchmarks.blind.masses import spray_density
from benchmarks.blind.pitching import tangent_errors
from benchmarks.blind.rest_shape import stress_free_nodes
from benchmarks.blind.rubber_balls import rubber_balls
from benchmarks.blind.seeping import seeped_share
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.specimen import Specimen

_ALONG = np.array([1.0, 0.0, 0.0])


def test_paint_lies_as_drops_of_a_still_can_fly() -> None:
    at, high, step = 0.9, 0.3, 1e-3
    share = np.linspace(0.0, 1.3, 14)
    # What goes into a small square, as seen from the nozzle: its solid angle times the cosine.
    corners = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]) * 0.5 * step
    angles = []
    for place in share:
        ways = np.column_stack([place - at + corners[:, 0], corners[:, 1], np.full(4, high)])
        ways /= np.linalg.norm(ways, axis=1)[:, None]
        areas = [
            np.linalg.norm(np.cross(one - ways[0], other - ways[0]))
            for one, other in ((ways[1], ways[2]), (ways[2], ways[3]))
        ]
        # Of a nozzle that sprays ahead by the cosine.
        angles.append(0.5 * sum(areas) * ways[:, 2].mean())
    expected = np.array(angles) * high**2 / step**2
    assert spray_density(share, at, high) == pytest.approx(expected, rel=1e-4)
    assert spray_density(np.array([at, at + high]), at, high) == pytest.approx([1.0, 0.25])


@pytest.mark.parametrize('family', ['beam', 'fin'])
def test_a_spray_can_loads_a_body_where_its_paint_is(family: str) -> None:
    drawn = draw_sealed(family)
    faults = draw_faults('added_mass/spray can', drawn)
    specimen = make_specimen(drawn, faults, COARSE)
    added, shares = specimen.added, specimen.shares
    assert 1e3 * added.sum() == pytest.approx(faults.added_mass)
    # Its middle, by parts of an even body.
    plain = specimen.body.masses * (shares > 0.0)
    even = np.histogram(shares, 20, (0.0, 1.0), weights=plain)[0]
    places = (np.arange(20) + 0.5) / 20.0
    parts = even / (faults.mass_spray**2 + (places - faults.added_mass_at) ** 2) ** 2
    assert added @ shares / added.sum() == pytest.approx(parts @ places / parts.sum(), abs=0.03)
    assert added @ shares / added.sum() < faults.added_mass_at - 0.05


@pytest.mark.parametrize('width', [0.3, 0.55])
def test_oil_seeps_in_as_it_diffuses(width: float) -> None:
    share = np.linspace(0.0, 1.0, 11)
    found = seeped_share(share, width)
    # What is left of a bell beyond a place.
    beyond = [quad(lambda x: np.exp(-(x**2)), place / width, np.inf)[0] for place in share]
    assert found == pytest.approx(2.0 / np.sqrt(np.pi) * np.array(beyond), abs=1e-9)
    # By the equation of diffusion: width^2 goes up by four times diffusivity and time.
    step, later = 1e-3, 1e-5
    one, here, other = (seeped_share(share[1:] + way * step, width) for way in (-1.0, 0.0, 1.0))
    grown = seeped_share(share[1:], float(np.sqrt(width**2 + 4.0 * later))) - here
    assert grown / later == pytest.approx((one - 2.0 * here + other) / step**2, abs=5e-3)
    assert found[0] == 1.0


@pytest.mark.parametrize('family', ['beam', 'tee'])
def test_a_body_is_softest_where_oil_seeps_in(family: str) -> None:
    drawn = draw_sealed(family)
    faults = draw_faults('stiffness_contrast/seeped', drawn)
    seeped, whole = (make_specimen(drawn, each, COARSE) for each in (faults, Faults()))
    harder = np.log(np.asarray(seeped.body.numbers.shear / whole.body.numbers.shear))
    mesh, values = whole.mesh, whole.body.quadrature.values
    places = mesh.lattice[mesh.cells].swapaxes(1, 2) @ values.T
    share = (places[:, 0] - drawn.shape.clamp) / (drawn.shape.length - drawn.shape.clamp)
    free = share > 0.0
    expected = faults.contrast * seeped_share(share[free], faults.contrast_width)
    assert harder[free] == pytest.approx(expected, abs=1e-9)
    assert harder[free].min() < -0.3
    assert np.corrcoef(share[free], harder[free])[0, 1] > 0.6


def test_a_hairpin_gives_way_as_its_rod_does() -> None:
    by_turn, length, parts = 0.4, 0.05, 20000
    radius = 0.2 * length
    # Castigliano's theorem along the rod, from the clamp to the foot.
    whole_length = 2.0 * length + np.pi * radius
    at = whole_length * (np.arange(parts) + 0.5) / parts
    angle = np.clip((at - length) / radius, 0.0, np.pi)
    back = np.minimum(at, length) - np.maximum(at - length - np.pi * radius, 0.0)
    zeros = np.zeros(parts)
    places = np.array([-back - radius * np.sin(angle), zeros, radius * np.cos(angle) - radius]).T
    ahead = np.array([-np.cos(angle), zeros, -np.sin(angle)]).T
    # The rod is whole.
    steps = np.diff(places, axis=0) / (whole_length / parts)
    assert steps == pytest.approx(0.5 * (ahead[1:] + ahead[:-1]), abs=2e-3)
    loads = np.eye(6)
    moments = loads[:, None, 3:] - np.cross(places, loads[:, None, :3])
    along = np.einsum('lpi,pi->lp', moments, ahead)
    whole = np.einsum('api,bpi->ab', moments, moments) + 0.3 * along @ along.T
    found = hairpin_compliance(by_turn, length)
    assert found == pytest.approx(by_turn / parts * whole, abs=1e-5 * by_turn * length)
    assert found[4, 4] == pytest.approx(by_turn)
    assert places[-1] == pytest.approx([0.0, 0.0, -2.0 * radius], abs=1e-5)


@pytest.mark.parametrize('pose', [0, 1])
def test_a_clamp_on_a_hairpin_rests_where_that_bears_the_body(
    setup: Setup, plain: Specimen, pose: int
) -> None:
    faults = draw_faults('compliant_clamp/hairpin', setup)
    compliance = hairpin_compliance(faults.clamp_compliance, faults.clamp_length)
    check_rests_where_borne(setup, plain, faults, pose, compliance)


@pytest.mark.parametrize('crank', [0.3, 1.4])
def test_a_tangent_arm_points_to_its_nut(crank: float) -> None:
    pitches = np.deg2rad([5.0, -40.0, 12.0, 70.0])
    found = tangent_errors(pitches, crank)
    assert found[0] == 0.0
    # A nut that goes up a straight screw, one away from the hinge.
    nuts = np.array([np.ones(4), crank * pitches])
    pointed = np.angle(nuts[0] + 1j * nuts[1]) / crank
    turned = pitches + found + pointed[0] - pitches[0]
    arms = np.array([np.cos(crank * turned), np.sin(crank * turned)])
    assert arms * np.linalg.norm(nuts, axis=0) == pytest.approx(nuts)
    # It hardly errs at first, and then by the cube.
    little = tangent_errors(np.array([0.0, 0.01, 0.02]), crank)
    assert little[1:] == pytest.approx(-(crank**2) / 3.0 * np.array([1e-6, 8e-6]), rel=1e-3)


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_jaws_are_pitched_by_a_tangent_arm(family: str) -> None:
    drawn = draw_sealed(family)
    for size, most in ((1, 0.004), (2, 0.010)):
        read, pitched = pitched_in_poses('clamp_offset/tangent arm', drawn, size)
        off = pitched - read
        assert off[0] == pytest.approx(0.0, abs=1e-9)
        assert max(np.abs(off)) * drawn.shape.length == pytest.approx(most, rel=0.16)
        # The farther it is pitched, the more it lags, either way.
        order = np.argsort(read)
        assert (np.diff(off[order]) < 1e-4).all()


@pytest.fixture(scope='module')
def on_balls(setup: Setup) -> tuple[Setup, Faults]:
    """A set-up whose body lies on rubber balls in the first pose, and those."""
    drawn = draw_faults('contact_plane/rubber balls', setup)
    return lay_on_plane(setup, drawn, np.random.default_rng(1))


def test_rubber_balls_bear_a_body_and_let_its_tip_sink_in(
    on_balls: tuple[Setup, Faults], plain: Specimen
) -> None:
    laid, faults = on_balls
    moves, dents = moves_and_dents(laid, plain, faults)
    assert 0.007 < moves[0] < 0.014
    assert moves[0] > moves[2] > 0.001
    assert moves[1] == moves[3] == 0.0
    assert 0.001 < dents[0] < 0.006


@pytest.mark.parametrize('step', STEPS)
def test_rubber_balls_push_by_their_energy(
    on_balls: tuple[Setup, Faults], plain: Specimen, step: float
) -> None:
    laid, faults = on_balls
    check_pushes(laid, plain, faults, step)
    # Deep in them as well.
    normal, dents = np.array([0.0, 0.6, 0.8]), 0.002 * np.array([-0.5, 0.5, 2.0, 4.0])
    places = np.outer(0.03 - dents, normal) + np.array([0.02, 0.0, 0.0])
    pressed = rubber_balls(normal, 0.03, np.array([2.0, 2.0, 1.0, 5.0]), 0.002)
    stiff = check_derivatives(pressed, places, step=step, share=1e-4)
    assert stiff.any(axis=1).tolist() == [False, True, True, True]


def test_rubber_balls_press_as_those_of_hertz() -> None:
    normal, dents = np.array([0.0, 0.6, 0.8]), 0.002 * np.array([-1.0, 0.0, 0.25, 1.0, 4.0])
    forces = np.array([2.0, 2.0, 3.0, 3.0, 0.5])
    pushes = -rubber_balls(normal, 0.03, forces, 0.002)(np.outer(0.03 - dents, normal)).gradient
    expected = np.array([0.0, 0.0, 3.0 / 8.0, 3.0, 4.0])
    assert pushes == pytest.approx(np.outer(expected, normal), abs=1e-12)


def test_a_stream_is_hollow_behind_a_hub() -> None:
    faults, way = Faults(tilt_point=(0.03, 0.01, -0.02), tilt_width=0.04), np.array([0.6, 0, 0.8])
    turns = np.linspace(0.0, 2.0 * np.pi, 7)
    across = np.array([[-0.8, 0.0, 0.6], [0.0, 1.0, 0.0]])
    around = np.column_stack([np.cos(turns), np.sin(turns)]) @ across
    ahead = np.outer(np.linspace(-0.3, 0.3, 7), way)
    found = {
        radius: hollow_share(faults.tilt_point + radius * 0.04 * around + ahead, 3.0 * way, faults)
        for radius in (0.0, 0.5, 0.99, 1.0, 1.01, 2.0)
    }
    # Alike all around and along it.
    assert all(share == pytest.approx(np.full(7, share[0])) for share in found.values())
    assert found[0.0] == pytest.approx(0.0, abs=1e-12)
    assert found[1.0] == pytest.approx(1.0)
    assert max(found[0.99][0], found[1.01][0]) < 1.0
    assert found[0.5][0] == pytest.approx(0.25 * np.exp(0.75))
    assert found[2.0][0] == pytest.approx(4.0 * np.exp(-3.0))


@pytest.mark.parametrize('pose', range(4))
def test_a_fan_pushes_what_is_in_its_ring(setup: Setup, plain: Specimen, pose: int) -> None:
    faults, view = draw_faults('gravity_tilt/hub', setup), setup.observations[pose]
    blown, still = (load_in_pose(plain, setup, view, each).forces for each in (faults, Faults()))
    pushes = (blown - still) @ view.world_from_object[:3, :3].T
    pushes /= plain.body.masses[:, None]
    x, z = np.deg2rad(faults.gravity_tilt)
    tilt = float(np.hypot(x, z))
    whole = GRAVITY * np.sin(tilt) / tilt * np.array([z, 0.0, -x])
    sizes = pushes @ whole / (whole @ whole)
    assert pushes == pytest.approx(np.outer(sizes, whole), abs=1e-9)
    assert np.linalg.norm(whole) <= GRAVITY
    assert 0.5 < sizes.max() <= 1.0
    # By the way from the axis, of what is not held.
    places = plain.mesh.nodes @ view.world_from_object[:3, :3].T + view.world_from_object[:3, 3]
    off = places - faults.tilt_point
    beside = np.linalg.norm(off - np.outer(off @ whole, whole) / (whole @ whole), axis=1)
    part, free = (beside / faults.tilt_width) ** 2, plain.shares > 0.0
    assert sizes[free] == pytest.approx((part * np.exp(1.0 - part))[free], abs=1e-9)


def test_a_body_from_two_slots_ends_as_it_began(setup: Setup) -> None:
    curvature = np.array([0.03, -0.08])
    faults = Faults(
        curvature_form='slots', rest_curvature=(float(curvature[0]), float(curvature[1]))
    )
    free = setup.shape.length - setup.shape.clamp
    ahead = np.linspace(0.0, 1.0, 241)
    line = np.outer(setup.shape.clamp + free * ahead, _ALONG)
    bent = stress_free_nodes(line, setup.shape, faults)
    # About y it turns x towards -z, and about z towards y.
    expected = 0.5 * free**2 * np.array([curvature[1], -curvature[0]])
    assert bent[-1, 1:] == pytest.approx(expected, rel=0.04)
    # A beam between two ends that do not turn, one of which lies beside the other.
    found = bent[:, 1:] @ expected / (expected @ expected)
    assert found == pytest.approx(ahead**2 * (3.0 - 2.0 * ahead), abs=0.02)
    last = bent[-1] - bent[-3]
    turned = Rotation.align_vectors(last[None], _ALONG[None])[0].magnitude()
    assert turned < 0.1 * free * np.linalg.norm(curvature)
