# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the twenty-eighth set that are of body, rig and air do what their labels say."""

import numpy as np
import pytest
from scipy.integrate import quad
from support.blind_contact import check_pushes, dents_of, lying
from support.blind_draws import draw_faults, draw_sealed, SEALED, STEPS
from support.blind_jaws import pitched_in_poses
from support.blind_rests import check_rests_where_borne, COARSE, rest_of

from benchmarks.blind.baking import baked_value
from benchmarks.blind.contact import contact_laws, highest_tops
from benchmarks.blind.draught import lee_share
from benchmarks.blind.faults import Faults
from benchmarks.blind.flexure import gooseneck_compliance
from benchmarks.blind.laying import lay_on_plane
from benchmarks.blind.loads import load_in_pose
from benchmarks.blind.mattress import bedded_lever, bedded_moment
from benchmarks.blind.pitching import eccentric_errors
from benchmarks.blind.rest_shape import stress_free_nodes
from benchmarks.blind.rotations import rotation
from benchmarks.blind.setups import GRAVITY, Observation, Setup
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.slinky import coil_places, slinky_masses
from benchmarks.blind.specimen import Specimen


@pytest.mark.parametrize('degrees', [-70.0, -25.0, 0.0, 40.0, 85.0])
def test_a_loose_spring_rests_where_its_energy_is_least(degrees: float) -> None:
    faults = Faults(added_mass_at=0.3, mass_coiled=0.4, mass_travel=0.13)
    world = np.eye(4)
    world[:3, :3] = rotation(np.deg2rad([0.0, 0.0, degrees])) @ rotation(np.array([0.4, 0.0, 0.0]))
    # A chain of as many springs as weights, in lengths of the free body and of its whole weight;
    # the end of one that hangs goes by half its weight over its stiffness.
    count, down = 240, -np.sin(np.deg2rad(degrees))
    stiff = count / (2.0 * 0.13)
    chain = stiff * (2.0 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1))
    chain[-1, -1] = stiff
    gone = np.linalg.solve(chain, np.full(count, down / count))
    inside = (np.arange(count) + 0.5) / count
    found = coil_places(Observation('level', world), faults)
    middles = (np.arange(len(found)) + 0.5) / len(found)
    expected = np.interp(middles, inside, 0.3 + 0.4 * inside + gone)
    assert found == pytest.approx(expected, abs=1e-3)
    assert (np.diff(found) > 0.0).all()


def test_a_loose_spring_loads_a_body_by_all_its_coils(setup: Setup, plain: Specimen) -> None:
    faults, middles = draw_faults('added_mass/slinky', setup), []
    for view in setup.observations:
        found = slinky_masses(plain.body.masses, plain.shares, setup, view, faults)
        assert 1e3 * float(found.sum()) == pytest.approx(faults.added_mass)
        middles.append(float(found @ plain.shares / found.sum()))
        assert middles[-1] == pytest.approx(coil_places(view, faults).mean(), abs=0.02)
        assert not found[plain.shares < faults.added_mass_at - 0.13].any()
    # Pitched, the tip points down, and upside down, up.
    assert middles[2] > middles[0] + 0.03 > middles[3] + 0.05


def test_heat_falls_from_both_ends_as_along_a_fin() -> None:
    at, width, step = 0.55, 0.2, 1e-3
    share = np.linspace(0.05, 0.95, 19)
    one, here, other = (baked_value(share + way * step, at, width) for way in (-1.0, 0.0, 1.0))
    # The air takes what goes with the heat over that of its own: v'' w^2 less v is the same.
    rest = width**2 * (one - 2.0 * here + other) / step**2 - here
    assert rest == pytest.approx(rest[0], rel=1e-4)
    assert rest[0] > 0.0
    ends = baked_value(np.array([0.0, 0.55, 1.0]), at, width)
    assert ends == pytest.approx([1.0, 0.0, (np.cosh(2.25) - 1.0) / (np.cosh(2.75) - 1.0)])
    assert not baked_value(share, at, 0.0).any()


@pytest.mark.parametrize('family', ['beam', 'tee'])
def test_a_baked_body_is_softest_at_its_ends(family: str) -> None:
    drawn = draw_sealed(family)
    faults = draw_faults('stiffness_contrast/baked', drawn)
    baked, whole = (make_specimen(drawn, each, COARSE) for each in (faults, Faults()))
    harder = np.log(np.asarray(baked.body.numbers.shear / whole.body.numbers.shear))
    mesh, values = whole.mesh, whole.body.quadrature.values
    places = mesh.lattice[mesh.cells].swapaxes(1, 2) @ values.T
    share = (places[:, 0] - drawn.shape.clamp) / (drawn.shape.length - drawn.shape.clamp)
    free = share > 0.0
    far = np.abs(share[free] - faults.contrast_at) / faults.contrast_width
    most = max(faults.contrast_at, 1.0 - faults.contrast_at) / faults.contrast_width
    # By half an angle: cosh 2 x - 1 is 2 sinh^2 x.
    expected = faults.contrast * (np.sinh(0.5 * far) / np.sinh(0.5 * most)) ** 2
    assert harder[free] == pytest.approx(expected, abs=1e-9)
    assert faults.contrast < -0.3


def test_a_gooseneck_gives_way_as_a_quarter_ring() -> None:
    by_turn, radius = 0.4, 0.05
    found = gooseneck_compliance(by_turn, radius)
    assert found == pytest.approx(found.T, abs=1e-12)
    assert np.linalg.eigvalsh(found).min() > -1e-12
    # Timoshenko's thin rings: by the cube of the radius over the bending stiffness.
    cube = by_turn * radius**2 / (0.5 * np.pi)
    upright, along = 0.25 * np.pi, 0.75 * np.pi - 2.0
    assert found[2, 2] == pytest.approx(upright * cube)
    assert found[0, 0] == pytest.approx(along * cube)
    # Across its plane it bends, and twists by 1 + nu as much.
    assert found[1, 1] == pytest.approx((upright + 1.3 * along) * cube)
    assert found[4, 4] == pytest.approx(by_turn)
    assert np.diag(found)[[3, 5]] == pytest.approx(1.15 * by_turn)


def test_a_gooseneck_bears_by_its_energy() -> None:
    by_turn, radius = 0.7, 0.04
    loads = np.array([[1.0, -0.4, 0.7, 0.02, 0.05, -0.03], [-0.3, 0.8, 0.5, -0.04, 0.01, 0.06]])

    def carried(angle: float) -> float:
        """Return how two loads bend and twist a place of the ring, by an angle [1/(N m)]."""
        place = radius * np.array([-np.sin(angle), 0.0, np.cos(angle) - 1.0])
        moments = loads[:, 3:] - np.cross(place, loads[:, :3])
        along = moments @ [np.cos(angle), 0.0, np.sin(angle)]
        return float(by_turn / (0.5 * np.pi) * (moments[0] @ moments[1] + 0.3 * along.prod()))

    work = float(loads[0] @ gooseneck_compliance(by_turn, radius) @ loads[1])
    assert work == pytest.approx(quad(carried, 0.0, 0.5 * np.pi)[0], rel=1e-9)


@pytest.mark.parametrize('pose', [0, 1])
def test_a_clamp_on_a_gooseneck_rests_where_that_bears_the_body(
    setup: Setup, plain: Specimen, pose: int
) -> None:
    faults = draw_faults('compliant_clamp/gooseneck', setup)
    compliance = gooseneck_compliance(faults.clamp_compliance, faults.clamp_length)
    check_rests_where_borne(setup, plain, faults, pose, compliance)


@pytest.mark.parametrize('phase', [0.7, -1.2])
def test_a_dial_errs_by_where_its_disc_turns(phase: float) -> None:
    read, off = np.deg2rad([12.0, -40.0, 0.0, 75.0]), 1e-4
    # A mark on the disc's rim, seen from the axis, which lies a little beside its middle.
    turned = read + phase
    seen = np.arctan2(np.sin(turned), np.cos(turned) + off) - turned
    found = eccentric_errors(read, phase)
    assert found[0] == 0.0
    assert -off * found == pytest.approx(seen - seen[0], abs=2.0 * off**2)


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_jaws_with_an_eccentric_dial_are_pitched_by_the_sine(family: str) -> None:
    drawn = draw_sealed(family)
    for size, most in ((1, 0.004), (2, 0.010)):
        read, pitched = pitched_in_poses('clamp_offset/eccentric', drawn, size)
        off = pitched - read
        assert off[0] == pytest.approx(0.0, abs=1e-9)
        assert max(np.abs(off)) * drawn.shape.length == pytest.approx(most, rel=0.16)
        # One sine and one constant say all of it.
        basis = np.column_stack([np.sin(read), np.cos(read), np.ones(4)])
        amounts = np.linalg.lstsq(basis, off, rcond=None)[0]
        assert basis @ amounts == pytest.approx(off, abs=5e-6)
        phase = np.arctan2(amounts[1], amounts[0])
        assert 0.7 < abs((phase + 0.5 * np.pi) % np.pi - 0.5 * np.pi) < 1.1


@pytest.fixture(scope='module')
def on_a_tent(setup: Setup) -> tuple[Setup, Faults]:
    """A set-up whose body lies on a tent in the first pose, and that tent."""
    return lay_on_plane(setup, draw_faults('contact_plane/tent', setup), np.random.default_rng(1))


def test_a_tent_lifts_a_body_in_two_poses(
    on_a_tent: tuple[Setup, Faults], plain: Specimen
) -> None:
    laid, faults = on_a_tent
    rests, moves = zip(*(lying(laid, plain, faults, pose) for pose in range(4)), strict=True)
    assert 0.008 < moves[0] < 0.015
    assert moves[2] > 0.001
    assert moves[1] == moves[3] == 0.0
    # It is hard.
    for pose in (0, 2):
        assert 0.0 < dents_of(laid, faults, rests[pose], pose).max() < 5e-5


def test_a_tent_falls_to_both_sides_of_a_level_ridge() -> None:
    faults = Faults(
        contact_form='tent',
        contact_ahead=0.02,
        contact_at=-0.01,
        contact_steep=0.4,
        contact_round=0.015,
        contact_slant=30.0,
    )
    way, ridge = np.array([np.sqrt(0.75), 0.0, 0.5]), np.array([-0.5, 0.0, np.sqrt(0.75)])
    ways, along = np.array([0.0, 0.008, -0.008, 0.5, -2.0]), np.array([0.3, 0.0, 0.1, -2.0, 0.7])
    places = np.array([0.02, 0.3, -0.01]) + np.outer(ways, way) + np.outer(along, ridge)
    # A ridge of 15 mm, whose hyperbola's half axes are 6 mm and 2.4 mm.
    lower = highest_tops(places, faults) - 0.3
    assert lower[0] == pytest.approx(0.0, abs=1e-12)
    assert lower[1:3] == pytest.approx(0.4 * 0.010 - 0.0024)
    assert ((lower + 0.0024) / 0.0024) ** 2 - (ways / 0.006) ** 2 == pytest.approx(1.0)
    near = highest_tops(places[:1] + 1e-4 * way, faults) - 0.3
    assert near == pytest.approx(0.5 * 1e-8 / 0.015, rel=1e-3)


@pytest.mark.parametrize('step', STEPS)
def test_a_tent_pushes_by_its_energy(
    on_a_tent: tuple[Setup, Faults], plain: Specimen, step: float
) -> None:
    laid, faults = on_a_tent
    check_pushes(laid, plain, faults, step)


def test_a_tent_pushes_across_its_roof(on_a_tent: tuple[Setup, Faults], plain: Specimen) -> None:
    laid, faults = on_a_tent
    view = laid.observations[0]
    (law,) = contact_laws(plain.areas, plain.shares, view, faults)
    pushes = -law(rest_of(laid, faults)).gradient @ view.world_from_object[:3, :3].T
    angle = np.deg2rad(faults.contact_slant)
    assert pushes[:, 1].max() > 0.0
    along_ridge = np.array([-np.sin(angle), 0.0, np.cos(angle)])
    assert pushes @ along_ridge == pytest.approx(0.0, abs=1e-9 * pushes.max())
    across = np.abs(pushes @ [np.cos(angle), 0.0, np.sin(angle)])
    assert (across <= faults.contact_steep * pushes[:, 1] + 1e-12).all()


def test_a_post_shelters_what_is_behind_it() -> None:
    faults, way = Faults(tilt_point=(0.03, 0.01, -0.02), tilt_width=0.03), np.array([0.6, 0, 0.8])
    aside = np.array([0.8, 0.0, -0.6])
    steps = np.array([0.0, 1.0, -1.0, 0.5, -2.0, 9.0])
    along = np.outer([0.0, 0.3, -0.2, 0.1, 0.0, 1.0], way)
    up = np.outer([0.2, 0.0, -0.1, 0.4, 0.0, -1.0], [0.0, 1.0, 0.0])
    places = np.array(faults.tilt_point) + 0.03 * steps[:, None] * aside + along + up
    expected = [0.0, 0.632121, 0.632121, 0.221199, 0.981684, 1.0]
    assert lee_share(places, 3.0 * way, faults) == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize('pose', range(4))
def test_a_draught_pushes_what_is_not_behind_a_post(
    setup: Setup, plain: Specimen, pose: int
) -> None:
    faults, view = draw_faults('gravity_tilt/lee', setup), setup.observations[pose]
    blown, still = (load_in_pose(plain, setup, view, each).forces for each in (faults, Faults()))
    pushes = (blown - still) @ view.world_from_object[:3, :3].T
    pushes /= plain.body.masses[:, None]
    x, z = np.deg2rad(faults.gravity_tilt)
    tilt = float(np.hypot(x, z))
    whole = GRAVITY * np.sin(tilt) / tilt * np.array([z, 0.0, -x])
    places = plain.mesh.nodes @ view.world_from_object[:3, :3].T + view.world_from_object[:3, 3]
    # As a complex number, the level way across that of the air.
    level = (places - faults.tilt_point)[:, [0, 2]] @ [1.0, 1j]
    across = (level / (whole[0] + 1j * whole[2])).imag * np.linalg.norm(whole)
    felt = -np.expm1(-((across / faults.tilt_width) ** 2)) * (plain.shares > 0.0)
    assert pushes == pytest.approx(felt[:, None] * whole, abs=1e-9)
    assert np.linalg.norm(whole) <= GRAVITY
    assert felt[plain.shares > 0.0].min() < 0.2
    assert felt.max() > 0.9


@pytest.mark.parametrize('width', [0.15, 0.2, 0.25])
def test_a_holder_on_a_mattress_bends_a_body_as_a_beam_on_springs(width: float) -> None:
    lever, _ = quad(lambda share: (1.0 - share) * bedded_moment(share, width), 0.0, 1.0)
    assert bedded_lever(width) == pytest.approx(lever, rel=1e-9)
    # M'''' = -4 M / w^4: pressed back by how far it sank, which its curvature goes with.
    shares, step = np.linspace(0.1, 0.9, 9), 4e-3
    table = np.array([[bedded_moment(s + k * step, width) for s in shares] for k in range(-2, 3)])
    fourth = np.array([1.0, -4.0, 6.0, -4.0, 1.0]) @ table / step**4
    assert fourth == pytest.approx(-4.0 / width**4 * table[2], abs=4e-3 / width**4)
    # It bears no moment at its end, where the force acts.
    assert bedded_moment(0.0, width) == 0.0


@pytest.mark.parametrize('width', [0.16, 0.24])
def test_a_bedded_bodys_tip_is_as_far_off_as_that_of_an_arc(setup: Setup, width: float) -> None:
    curvature = np.array([0.03, -0.08])
    faults = Faults(
        curvature_form='mattress',
        rest_curvature=(float(curvature[0]), float(curvature[1])),
        curvature_bed=width,
    )
    free = setup.shape.length - setup.shape.clamp
    ahead = setup.shape.clamp + free * np.array([0.02, 0.5, 0.98, 1.0])
    line = stress_free_nodes(np.outer(ahead, [1.0, 0.0, 0.0]), setup.shape, faults)
    # About y it turns x towards -z, and about z towards y.
    expected = 0.5 * free**2 * np.array([curvature[1], -curvature[0]])
    assert line[3, 1:] == pytest.approx(expected, rel=0.04)
    # What is far from the holder is straight.
    inner, outer = line[2] - line[1], line[3] - line[2]
    turned = np.linalg.norm(np.cross(inner, outer))
    turned /= np.linalg.norm(inner) * np.linalg.norm(outer)
    assert turned < 0.1 * np.linalg.norm(curvature) * free
