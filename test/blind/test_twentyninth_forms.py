# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the twenty-ninth set that are of body, rig and air do what their labels say."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.spatial.transform import Rotation
from support.blind_contact import check_pushes, moves_and_dents
from support.blind_derivatives import check_body_stiffness, check_derivatives
from support.blind_draws import draw_faults, draw_sealed, SEALED, STEPS
from support.blind_jaws import pitched_in_poses
from support.blind_rests import check_rests_where_borne, COARSE, tip_moves

from benchmarks.blind.draught import screened_share
from benchmarks.blind.faults import Faults
from benchmarks.blind.fibres import Fibres
from benchmarks.blind.flexure import coil_compliance
from benchmarks.blind.gel_pad import gel_pad
from benchmarks.blind.laying import lay_on_plane, softer
from benchmarks.blind.loads import load_in_pose
from benchmarks.blind.masses import turn_density
from benchmarks.blind.pitching import joint_errors
from benchmarks.blind.rest_shape import stress_free_nodes
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.surging import surged_value

_ALONG = np.array([1.0, 0.0, 0.0])


@pytest.mark.parametrize('closer', [0.2, 0.33])
def test_solder_is_wound_closer_and_closer(closer: float) -> None:
    share = np.linspace(0.0, 1.0, 11)
    found = turn_density(share, closer)
    # As many more by each step, and e times as many by the share that is told.
    assert found[1:] / found[:-1] == pytest.approx(found[1] / found[0])
    assert found[-1] == 1.0
    assert turn_density(np.array([1.0 - closer]), closer) == pytest.approx([1.0 / np.e])


@pytest.mark.parametrize('family', ['beam', 'fin'])
def test_solder_loads_a_body_where_its_turns_are(family: str) -> None:
    drawn = draw_sealed(family)
    faults = draw_faults('added_mass/solder', drawn)
    specimen = make_specimen(drawn, faults, COARSE)
    added, shares = specimen.added, specimen.shares
    assert 1e3 * added.sum() == pytest.approx(faults.added_mass)
    # Its middle, by parts of an even body: that of an exponential on 0 to 1.
    rate, plain = 1.0 / faults.mass_closer, specimen.body.masses * (shares > 0.0)
    even = np.histogram(shares, 20, (0.0, 1.0), weights=plain)[0]
    places = (np.arange(20) + 0.5) / 20.0
    parts = even * np.exp(rate * places)
    assert added @ shares / added.sum() == pytest.approx(parts @ places / parts.sum(), abs=0.03)


def test_a_pump_surges_less_and_less() -> None:
    wave, width, step = 0.7, 0.4, 1e-3
    share = np.linspace(0.05, 0.95, 19)
    one, here, other = (surged_value(share + way * step, wave, width) for way in (-1.0, 0.0, 1.0))
    # That of a spring and a damper: v'' + 2 v' / width + (1 / width^2 + rate^2) v is none.
    speed, force = (other - one) / (2.0 * step), (one - 2.0 * here + other) / step**2
    stiff = 1.0 / width**2 + (2.0 * np.pi / wave) ** 2
    assert force + 2.0 / width * speed + stiff * here == pytest.approx(0.0, abs=1e-3 * stiff)
    ends = surged_value(np.array([0.0, 0.175, 0.35, 0.7]), wave, width)
    assert ends == pytest.approx([1.0, 0.0, -np.exp(-0.875), np.exp(-1.75)], abs=1e-12)


@pytest.mark.parametrize('family', ['beam', 'tee'])
def test_a_surged_body_is_softest_where_the_pump_began(family: str) -> None:
    drawn = draw_sealed(family)
    faults = draw_faults('stiffness_contrast/surged', drawn)
    surged, whole = (make_specimen(drawn, each, COARSE) for each in (faults, Faults()))
    harder = np.log(np.asarray(surged.body.numbers.shear / whole.body.numbers.shear))
    mesh, values = whole.mesh, whole.body.quadrature.values
    places = mesh.lattice[mesh.cells].swapaxes(1, 2) @ values.T
    share = (places[:, 0] - drawn.shape.clamp) / (drawn.shape.length - drawn.shape.clamp)
    free = share > 0.0
    # As a complex exponential.
    rate = -1.0 / faults.contrast_width + 2j * np.pi / faults.contrast_wave
    expected = faults.contrast * np.exp(rate * share[free]).real
    assert harder[free] == pytest.approx(expected, abs=1e-9)
    assert faults.contrast < -0.3
    assert share[free][harder[free].argmin()] < 0.1


@pytest.mark.parametrize('step', STEPS)
@pytest.mark.parametrize('stretch', [1.02, 1.05, 1.07])
def test_a_curly_cord_pulls_by_its_energy(stretch: float, step: float) -> None:
    cord = Fibres(np.array(3e4), _ALONG, slack=True, limit=0.12)
    # The last is beyond the share of its limit up to which it is followed.
    drawn = np.diag([stretch, 0.98, 0.97]) + np.random.default_rng(1).uniform(
        -0.004, 0.004, (3, 3)
    )
    move = np.random.default_rng(2).standard_normal((3, 3))
    ends = [drawn + way * step * move for way in (1.0, -1.0)]
    one, other = (cord.energy(end) for end in ends)
    slope = float((cord.stress(drawn) * move).sum())
    assert slope > 0.0
    assert (one - other) / (2.0 * step) == pytest.approx(slope, rel=1e-4)


def test_a_curly_cord_goes_straight_and_no_further() -> None:
    cord = Fibres(np.array(3e4), _ALONG, slack=True, limit=0.12)
    growth = np.array([0.001, 0.06, 0.11])
    stretches = [np.diag([np.sqrt(1.0 + each), 1.0, 1.0]) for each in growth]
    over = np.array([float(cord.energy(each)) for each in stretches]) / (3e4 * growth**2)
    # By its series: 1 + p^2 / 2 + p^4 / 3 and so on.
    powers = (growth[:, None] / 0.12) ** (2 * np.arange(400))
    assert over == pytest.approx(powers @ (1.0 / np.arange(1, 401)))
    pulls = [float(cord.stress(each)[0, 0]) for each in stretches]
    longer = np.sqrt(1.0 + growth)
    assert pulls == pytest.approx(2.0 * 3e4 * longer * 2.0 * growth / (1.0 - powers[:, 1]))
    assert not cord.stress(np.diag([0.95, 1.0, 1.0])).any()
    # Far beyond it a line search is told a finite energy, and a large one.
    far = [float(cord.energy(np.diag([each, 1.0, 1.0]))) for each in (1.1, 1.3, 2.0)]
    assert np.isfinite(far).all()
    assert far[0] > 3e4 * 0.12**2
    assert (np.diff(far) > 0.0).all()


@pytest.mark.parametrize('step', [1e-7, 1e-8, 1e-9])
def test_a_body_with_cords_resists_as_its_forces_change(setup: Setup, step: float) -> None:
    faults = Faults(stiffening_form='corded', stiffening=2.0, stiffening_from=0.35)
    specimen = make_specimen(setup, faults, COARSE)
    check_body_stiffness(specimen.body, specimen.mesh.nodes * [1.03, 0.98, 0.98], step=step)


def test_cords_lie_along_the_upper_and_the_lower_side() -> None:
    drawn = draw_sealed('waist')
    faults = draw_faults('strain_stiffening/corded', drawn)
    specimen = make_specimen(drawn, faults, COARSE)
    (found,) = specimen.body.numbers.network
    there = np.broadcast_to(found.stiffness, specimen.heights.shape) > 0.0
    # Of the lowest and the highest row of points, and of no other.
    rows = np.unique(np.round(specimen.heights, 6))
    ends = (specimen.heights < rows[0] + 0.05) | (specimen.heights > rows[-1] - 0.05)
    assert np.array_equal(there, ends)
    expected = faults.stiffening * drawn.youngs_modulus / 8.0
    assert found.stiffness[there] == pytest.approx(expected, rel=1e-6)
    assert found.slack
    assert found.limit == faults.stiffening_from


@pytest.mark.slow
@pytest.mark.parametrize('family', SEALED)
def test_cords_hold_a_body_whichever_way_up_it_is(family: str) -> None:
    drawn = draw_sealed(family)
    soft = softer(drawn, 0.3)
    plain = make_specimen(soft, Faults(), COARSE)
    for size, least, most in ((1, 2.5, 7.5), (2, 6.0, 16.0)):
        faults = draw_faults('strain_stiffening/corded', drawn, size)
        moves = 1e3 * np.array(tip_moves(soft, plain, faults, plain.shares > 0.99))
        assert least < moves[0] < most
        assert least < moves[3] < most


def test_a_coil_spring_gives_way_as_its_wire_does() -> None:
    by_turn, height, coils = 0.4, 0.05, 300
    # Castigliano's theorem along the wire, of very many coils.
    angles = 2.0 * np.pi * (np.arange(24 * coils) + 0.5) / 24
    radius, rise = 0.25 * height, height / (2.0 * np.pi * coils)
    zeros = np.zeros(len(angles))
    places = np.array([radius * np.cos(angles), radius * np.sin(angles), -rise * angles]).T
    ahead = np.array([-radius * np.sin(angles), radius * np.cos(angles), zeros - rise]).T
    ahead /= np.linalg.norm(ahead, axis=1)[:, None]
    loads = np.eye(6)
    moments = loads[:, None, 3:] - np.cross(places, loads[:, None, :3])
    along = np.einsum('lpi,pi->lp', moments, ahead)
    whole = np.einsum('api,bpi->ab', moments, moments) + 0.3 * along @ along.T
    found = coil_compliance(by_turn, height)
    assert found == pytest.approx(by_turn / whole[4, 4] * whole, abs=2e-3 * by_turn * height)
    assert found[4, 4] == pytest.approx(by_turn)
    assert found[5, 5] == pytest.approx(by_turn / 1.15)
    # Timoshenko's: by a force along it, 1 + nu times the square of the radius.
    assert found[2, 2] == pytest.approx(1.3 / 1.15 * by_turn * radius**2)


@pytest.mark.parametrize('pose', [0, 1])
def test_a_clamp_on_a_coil_spring_rests_where_that_bears_the_body(
    setup: Setup, plain: Specimen, pose: int
) -> None:
    faults = draw_faults('compliant_clamp/coil spring', setup)
    compliance = coil_compliance(faults.clamp_compliance, faults.clamp_length)
    check_rests_where_borne(setup, plain, faults, pose, compliance)


@pytest.mark.parametrize(('phase', 'bent'), [(0.3, 0.5), (-1.2, 0.9)])
def test_a_universal_joint_keeps_its_pins_at_right_angles(phase: float, bent: float) -> None:
    pitches = np.deg2rad([5.0, -40.0, 12.0, 70.0])
    found = joint_errors(pitches, phase, bent)
    assert found[0] == 0.0
    # One pin goes round with the driving shaft, along x; the other one with what is bent off it.
    one = np.array([np.zeros(4), np.cos(pitches + phase), np.sin(pitches + phase)])
    first = np.arctan2(np.sin(pitches[0] + phase), np.cos(bent) * np.cos(pitches[0] + phase))
    turned = first + pitches - pitches[0] + found
    aslant = Rotation.from_rotvec([0.0, 0.0, bent]).as_matrix()
    other = aslant @ np.array([np.zeros(4), -np.sin(turned), np.cos(turned)])
    assert (one * other).sum(axis=0) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_jaws_are_pitched_through_a_universal_joint(family: str) -> None:
    drawn = draw_sealed(family)
    for size, most in ((1, 0.004), (2, 0.010)):
        read, pitched = pitched_in_poses('clamp_offset/universal joint', drawn, size)
        off = pitched - read
        assert off[0] == pytest.approx(0.0, abs=1e-9)
        assert max(np.abs(off)) * drawn.shape.length == pytest.approx(most, rel=0.16)
        # By as good as a sine of twice the angle, up from the first pose and down from it.
        basis = np.column_stack([np.sin(2.0 * read), np.cos(2.0 * read), np.ones(4)])
        amounts = np.linalg.lstsq(basis, off, rcond=None)[0]
        assert basis @ amounts == pytest.approx(off, abs=0.1 * np.abs(off).max())
        assert off[2] * off[3] < 0.0


@pytest.fixture(scope='module')
def on_gel(setup: Setup) -> tuple[Setup, Faults]:
    """A set-up whose body lies on a pad of gel in the first pose, and that pad."""
    drawn = draw_faults('contact_plane/gel pad', setup)
    return lay_on_plane(setup, drawn, np.random.default_rng(1))


def test_gel_bears_a_body_and_lets_its_tip_sink_in(
    on_gel: tuple[Setup, Faults], plain: Specimen
) -> None:
    laid, faults = on_gel
    moves, dents = moves_and_dents(laid, plain, faults)
    assert 0.007 < moves[0] < 0.013
    assert moves[0] > moves[2] > 0.001
    assert moves[1] == moves[3] == 0.0
    assert 0.001 < dents[0] < 0.006


@pytest.mark.parametrize('step', STEPS)
def test_gel_pushes_by_its_energy(
    on_gel: tuple[Setup, Faults], plain: Specimen, step: float
) -> None:
    laid, faults = on_gel
    check_pushes(laid, plain, faults, step)
    # Deep in it as well.
    normal, dents = np.array([0.0, 0.6, 0.8]), 0.002 * np.array([-0.5, 0.5, 2.0, 4.0])
    places = np.outer(0.03 - dents, normal) + np.array([0.02, 0.0, 0.0])
    pressed = gel_pad(normal, 0.03, np.array([2.0, 2.0, 1.0, 5.0]), 0.002)
    stiff = check_derivatives(pressed, places, step=step, share=1e-4)
    assert stiff.any(axis=1).tolist() == [False, True, True, True]


def test_gel_hardens_by_the_cube_of_its_dent() -> None:
    normal, dents = np.array([0.0, 0.6, 0.8]), 0.002 * np.array([-1.0, 0.0, 0.1, 1.0, 3.0])
    forces = np.array([2.0, 2.0, 3.0, 3.0, 0.5])
    pushes = -gel_pad(normal, 0.03, forces, 0.002)(np.outer(0.03 - dents, normal)).gradient
    expected = np.array([0.0, 0.0, 3.0 * 0.101, 6.0, 15.0])
    assert pushes == pytest.approx(np.outer(expected, normal))


def test_a_screen_shelters_what_is_behind_it() -> None:
    faults, way = Faults(tilt_point=(0.03, 0.01, -0.02), tilt_width=0.02), np.array([0.6, 0, 0.8])
    # To the right of who goes with the air, above whom is the world's y.
    aside = np.array([-0.8, 0.0, 0.6])
    steps = np.array([0.0, 1.0, -1.0, 0.5, -3.0, 9.0])
    along = np.outer([0.0, 0.3, -0.2, 0.1, 0.0, 1.0], way)
    up = np.outer([0.2, 0.0, -0.1, 0.4, 0.0, -1.0], [0.0, 1.0, 0.0])
    places = np.array(faults.tilt_point) + 0.02 * steps[:, None] * aside + along + up
    # The speed by an integral over all that mixed.
    speeds = [quad(lambda x: np.exp(-(x**2)), -9.0, each)[0] / np.sqrt(np.pi) for each in steps]
    found = screened_share(places, 3.0 * way, faults)
    assert found == pytest.approx(np.square(speeds), abs=1e-9)
    assert found[0] == pytest.approx(0.25)
    # Behind the other edge it is the other way about.
    other = Faults(tilt_point=faults.tilt_point, tilt_width=-0.02)
    assert np.sqrt(found) + np.sqrt(screened_share(places, way, other)) == pytest.approx(1.0)


@pytest.mark.parametrize('pose', range(4))
def test_a_draught_pushes_what_stands_out_past_a_screen(
    setup: Setup, plain: Specimen, pose: int
) -> None:
    faults, view = draw_faults('gravity_tilt/screened', setup), setup.observations[pose]
    blown, still = (load_in_pose(plain, setup, view, each).forces for each in (faults, Faults()))
    pushes = (blown - still) @ view.world_from_object[:3, :3].T
    pushes /= plain.body.masses[:, None]
    x, z = np.deg2rad(faults.gravity_tilt)
    tilt = float(np.hypot(x, z))
    whole = GRAVITY * np.sin(tilt) / tilt * np.array([z, 0.0, -x])
    sizes = pushes @ whole / (whole @ whole)
    assert pushes == pytest.approx(np.outer(sizes, whole), abs=1e-9)
    assert np.linalg.norm(whole) <= GRAVITY
    # All of it at the tip, and as good as none at the root.
    assert sizes[plain.shares > 0.99].min() > 0.7
    assert sizes[(plain.shares > 0.0) & (plain.shares < 0.1)].max() < 0.05
    assert not sizes[plain.shares == 0.0].any()


@pytest.mark.parametrize(('inner', 'outer'), [(0.25, 0.85), (0.4, 0.7)])
def test_a_body_below_two_feet_is_bent_as_by_its_moments(
    setup: Setup, inner: float, outer: float
) -> None:
    curvature = np.array([0.03, -0.08])
    faults = Faults(
        curvature_form='four-point',
        rest_curvature=(float(curvature[0]), float(curvature[1])),
        curvature_at=inner,
        curvature_again=outer,
    )
    free = setup.shape.length - setup.shape.clamp
    ahead = np.linspace(0.0, 1.0, 241)
    line = np.outer(setup.shape.clamp + free * ahead, _ALONG)
    bent = stress_free_nodes(line, setup.shape, faults)
    # About y it turns x towards -z, and about z towards y.
    expected = 0.5 * free**2 * np.array([curvature[1], -curvature[0]])
    assert bent[-1, 1:] == pytest.approx(expected, rel=0.04)
    # Turned by the sum of the moments, and off by that of the turns.
    share = np.interp(ahead, [0.0, inner, outer, 1.0], [0.0, 1.0, 1.0, 0.0])
    slope = np.concatenate([[0.0], np.cumsum(0.5 * (share[1:] + share[:-1]))]) / 240.0
    way = np.concatenate([[0.0], np.cumsum(0.5 * (slope[1:] + slope[:-1]))]) / 240.0
    found = bent[:, 1:] @ expected / (expected @ expected)
    assert found == pytest.approx(way / way[-1], abs=0.02)
