# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the twenty-seventh set that are of body, rig and air do what their labels say."""

from dataclasses import replace

import numpy as np
import pytest
from support.blind_contact import check_pushes, dents_of, moves_and_dents
from support.blind_derivatives import check_body_stiffness
from support.blind_draws import draw_faults, draw_sealed, SEALED, STEPS
from support.blind_jaws import pitched_in_poses
from support.blind_rests import COARSE, moved_by_what_stiffens, rest_of

from benchmarks.blind.contact import contact_laws, highest_tops
from benchmarks.blind.dosing import dosed_value
from benchmarks.blind.draught import louvre_share
from benchmarks.blind.faults import Faults
from benchmarks.blind.fibres import Fibres
from benchmarks.blind.laying import lay_on_plane
from benchmarks.blind.loads import load_in_pose
from benchmarks.blind.rotations import rotation
from benchmarks.blind.setups import GRAVITY, Observation, Setup
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.slider import slid_to, slider_masses
from benchmarks.blind.specimen import Specimen


@pytest.mark.parametrize('degrees', [-70.0, -25.0, 0.0, 40.0, 85.0])
def test_a_sliding_weight_rests_where_its_energy_is_least(degrees: float) -> None:
    faults = Faults(added_mass_at=0.55, mass_travel=0.3)
    world = np.eye(4)
    world[:3, :3] = rotation(np.deg2rad([0.0, 0.0, degrees])) @ rotation(np.array([0.4, 0.0, 0.0]))
    # Of its spring and its weight, in lengths of the free body, up to its outer stop.
    places = np.linspace(0.05, 0.97, 9201)
    up = np.sin(np.deg2rad(degrees))
    energy = 0.5 * (places - 0.55) ** 2 / 0.3 + up * places
    found = slid_to(Observation('level', world), faults)
    assert found == pytest.approx(places[energy.argmin()], abs=1e-4)


def test_a_sliding_weight_loads_a_body_where_it_is_in_each_pose(
    setup: Setup, plain: Specimen
) -> None:
    faults, middles = draw_faults('added_mass/sliding', setup), []
    for view in setup.observations:
        found = slider_masses(plain.body.masses, plain.shares, setup, view, faults)
        assert 1e3 * float(found.sum()) == pytest.approx(faults.added_mass)
        middles.append(float(found @ plain.shares / found.sum()))
        assert middles[-1] == pytest.approx(slid_to(view, faults), abs=0.03)
    # Pitched, the tip points down, and upside down, up.
    assert middles[2] > middles[0] + 0.08 > middles[3] + 0.12


def test_a_sliding_weight_is_as_heavy_as_one_that_is_fixed_there(setup: Setup) -> None:
    faults = draw_faults('added_mass/sliding', setup)
    tip = make_specimen(setup, Faults(), COARSE).shares > 0.99
    for pose in (0, 2):
        at = slid_to(setup.observations[pose], faults)
        fixed = replace(faults, mass_form='hat', added_mass_at=at)
        slid, held, bare = (rest_of(setup, each, pose)[tip] for each in (faults, fixed, Faults()))
        sunk = np.linalg.norm((held - bare).mean(axis=0))
        assert np.linalg.norm((slid - held).mean(axis=0)) < 0.05 * sunk


def test_a_pump_begins_anew_after_each_stroke() -> None:
    share = np.array([0.03, 0.05, 0.15, 0.449, 0.451, 0.65, 0.8499, 0.95])
    expected = [0.45, -0.5, -0.25, 0.4975, -0.4975, 0.0, 0.49975, -0.25]
    assert dosed_value(share, 0.05, 0.4) == pytest.approx(expected)


@pytest.mark.parametrize('family', ['beam', 'tee'])
def test_a_dosed_body_grows_harder_along_each_stroke(family: str) -> None:
    drawn = draw_sealed(family)
    faults = draw_faults('stiffness_contrast/dosed', drawn)
    dosed, whole = (make_specimen(drawn, each, COARSE) for each in (faults, Faults()))
    harder = np.log(np.asarray(dosed.body.numbers.shear / whole.body.numbers.shear))
    mesh, values = whole.mesh, whole.body.quadrature.values
    places = mesh.lattice[mesh.cells].swapaxes(1, 2) @ values.T
    share = (places[:, 0] - drawn.shape.clamp) / (drawn.shape.length - drawn.shape.clamp)
    begun = faults.contrast_at + faults.contrast_wave * np.arange(-1, 4)
    free = (share > 0.05) & (np.abs(share[..., None] - begun).min(axis=-1) > 0.03)
    # Of the last stroke that began before each place.
    last = np.where(share[..., None] > begun, begun, -np.inf).max(axis=-1)
    part = (share[free] - last[free]) / faults.contrast_wave
    assert harder[free] == pytest.approx(faults.contrast * (part - 0.5), abs=1e-9)
    assert faults.contrast > 0.3


@pytest.mark.parametrize('step', STEPS)
def test_a_foam_strip_presses_by_its_energy(step: float) -> None:
    strip = Fibres(np.array(3e4), np.array([1.0, 0.0, 0.0]), pressed=True, steep=90.0)
    pressed = np.diag([0.94, 1.02, 1.03]) + np.random.default_rng(1).uniform(-0.02, 0.02, (3, 3))
    move = np.random.default_rng(2).standard_normal((3, 3))
    one, other = (strip.energy(pressed + way * step * move) for way in (1.0, -1.0))
    slope = float((strip.stress(pressed) * move).sum())
    assert slope != 0.0
    assert (one - other) / (2.0 * step) == pytest.approx(slope, rel=1e-5)
    # It does not pull, and at first it goes with the square.
    assert not strip.stress(np.diag([1.05, 1.0, 1.0])).any()
    shorter = np.array([1e-4, 0.1])
    energies = [strip.energy(np.diag([np.sqrt(1.0 - each), 1.0, 1.0])) for each in shorter]
    over = np.array(energies) / (3e4 * shorter**2)
    assert over == pytest.approx([1.0, np.expm1(0.9) / 0.9], rel=1e-6)


@pytest.mark.parametrize('step', [1e-7, 1e-8, 1e-9])
def test_a_body_with_a_foam_strip_resists_as_its_forces_change(setup: Setup, step: float) -> None:
    faults = Faults(stiffening_form='foam strip', stiffening=2.0, stiffening_steep=60.0)
    specimen = make_specimen(setup, faults, COARSE)
    # Shorter by a tenth, where the check draws it longer.
    check_body_stiffness(specimen.body, specimen.mesh.nodes * [0.87, 1.05, 1.05], step=step)


def test_a_foam_strip_lies_along_the_lower_side() -> None:
    drawn = draw_sealed('waist')
    faults = draw_faults('strain_stiffening/foam strip', drawn)
    specimen = make_specimen(drawn, faults)
    (found,) = specimen.body.numbers.network
    there = np.broadcast_to(found.stiffness, specimen.heights.shape) > 0.0
    # Of the lowest row of points, and of no other.
    assert np.array_equal(there, specimen.heights < np.unique(specimen.heights)[0] + 0.05)
    assert found.stiffness[there] == pytest.approx(
        faults.stiffening * drawn.youngs_modulus / 8.0, rel=1e-6
    )
    assert found.pressed
    assert found.steep > 10.0


@pytest.mark.slow
@pytest.mark.parametrize('family', ['arch', 'waist', 'fin', 'tee'])
def test_a_foam_strip_holds_a_body_where_it_bends_down_and_not_upside_down(family: str) -> None:
    moves = moved_by_what_stiffens('strain_stiffening/foam strip', family)
    assert 0.0025 < moves[0] < 0.007
    assert 0.006 < moves[1] < 0.016


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_worn_worm_lags_behind_the_way_in_which_it_turned_last(family: str) -> None:
    drawn = draw_sealed(family)
    for size, most in ((1, 0.004), (2, 0.010)):
        stated, pitched = pitched_in_poses('clamp_offset/backlash', drawn, size)
        lost = stated - pitched
        assert np.abs(lost) == pytest.approx(abs(lost[0]), rel=1e-3)
        assert np.array_equal(np.sign(lost[1:]), np.sign(np.diff(stated)))
        assert lost[2] < 0.0 < lost[3]
        assert abs(lost[0]) * drawn.shape.length == pytest.approx(most, rel=0.16)


def test_a_body_in_jaws_with_backlash_is_held_where_they_are(
    setup: Setup, plain: Specimen
) -> None:
    faults = draw_faults('clamp_offset/backlash', setup)
    nodes = plain.mesh.nodes[plain.mesh.held]
    for pose in (2, 3):
        found = rest_of(setup, faults, pose)[plain.mesh.held]
        turned = nodes @ rotation(np.deg2rad(faults.clamp_scatter[pose][3:])).T
        assert found == pytest.approx(turned, abs=1e-6)


@pytest.fixture(scope='module')
def on_a_sheet(setup: Setup) -> tuple[Setup, Faults]:
    """A set-up whose body lies on a corrugated sheet in the first pose, and that sheet."""
    return lay_on_plane(
        setup, draw_faults('contact_plane/corrugated', setup), np.random.default_rng(1)
    )


def test_a_corrugated_sheet_lifts_a_body_in_two_poses(
    on_a_sheet: tuple[Setup, Faults], plain: Specimen
) -> None:
    laid, faults = on_a_sheet
    moves, _ = moves_and_dents(laid, plain, faults)
    assert 0.008 < moves[0] < 0.015
    assert moves[2] > 0.001
    assert moves[1] == moves[3] == 0.0
    # It is hard.
    for pose in (0, 2):
        assert 0.0 < dents_of(laid, faults, rest_of(laid, faults, pose), pose).max() < 5e-5


def test_a_sheet_has_crests_across_one_way_and_is_level_along_the_other() -> None:
    faults = Faults(
        contact_form='corrugated',
        contact_ahead=0.02,
        contact_at=-0.01,
        contact_wave=0.05,
        contact_trough=0.012,
        contact_slant=30.0,
    )
    way, level = np.array([np.sqrt(0.75), 0.0, 0.5]), np.array([-0.5, 0.0, np.sqrt(0.75)])
    ways, asides = np.array([0.0, 0.25, 0.5, 0.75, 1.0, -1.5]), np.array([0.3, 0, 0.1, -2, 0, 0.7])
    places = np.array([0.02, 0.3, -0.01]) + np.outer(0.05 * ways, way) + np.outer(asides, level)
    lower = 0.012 * np.array([0.0, 0.5, 1.0, 0.5, 0.0, 1.0])
    assert highest_tops(places, faults) == pytest.approx(0.3 + lower)


@pytest.mark.parametrize('step', STEPS)
def test_a_sheet_pushes_by_its_energy(
    on_a_sheet: tuple[Setup, Faults], plain: Specimen, step: float
) -> None:
    laid, faults = on_a_sheet
    check_pushes(laid, plain, faults, step)


def test_a_sheet_pushes_across_its_slope(
    on_a_sheet: tuple[Setup, Faults], plain: Specimen
) -> None:
    laid, faults = on_a_sheet
    view = laid.observations[0]
    (law,) = contact_laws(plain.areas, plain.shares, view, faults)
    pushes = -law(rest_of(laid, faults)).gradient @ view.world_from_object[:3, :3].T
    angle = np.deg2rad(faults.contact_slant)
    along_crests = np.array([-np.sin(angle), 0.0, np.cos(angle)])
    assert pushes[:, 1].max() > 0.0
    assert pushes @ along_crests == pytest.approx(0.0, abs=1e-9 * pushes.max())
    # As steep as its waves at most.
    steepest = np.pi * faults.contact_trough / faults.contact_wave
    assert (np.hypot(pushes[:, 0], pushes[:, 2]) <= steepest * pushes[:, 1] + 1e-12).all()


def test_a_grille_lets_air_through_amid_its_slats() -> None:
    faults, way = Faults(tilt_point=(0.03, 0.01, -0.02), tilt_wave=0.08), np.array([0.6, 0.0, 0.8])
    aside = np.array([0.8, 0.0, -0.6])
    steps = np.array([0.0, 0.5, 0.25, 1.0, -0.5, -0.125])
    along = np.outer([0.0, 0.3, -0.2, 0.1, 0.0, 1.0], way)
    up = np.outer([0.2, 0.0, -0.1, 0.4, 0.0, -1.0], [0.0, 1.0, 0.0])
    places = np.array(faults.tilt_point) + 0.08 * steps[:, None] * aside + along + up
    expected = [1.0, 0.0, 0.5, 1.0, 0.0, 0.5 + 0.5 * np.sqrt(0.5)]
    assert louvre_share(places, 3.0 * way, faults) == pytest.approx(expected)


@pytest.mark.parametrize('pose', range(4))
def test_a_grille_pushes_what_is_behind_its_gaps(setup: Setup, plain: Specimen, pose: int) -> None:
    faults, view = draw_faults('gravity_tilt/louvred', setup), setup.observations[pose]
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
    felt = 0.5 * (1.0 + np.cos(2.0 * np.pi * across / faults.tilt_wave)) * (plain.shares > 0.0)
    assert pushes == pytest.approx(felt[:, None] * whole, abs=1e-9)
    assert np.linalg.norm(whole) <= GRAVITY
    assert felt[plain.shares > 0.0].min() < 0.2
    assert felt.max() > 0.9
