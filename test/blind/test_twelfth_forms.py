# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms and causes of the twelfth set do what their labels say."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from support.blind_derivatives import check_body_stiffness, check_derivatives
from support.blind_rests import COARSE, rest_of, tip_moves, turn_of

from benchmarks.blind.amplitudes import weight_moment
from benchmarks.blind.cloth import cloth_masses
from benchmarks.blind.contact import contact_laws
from benchmarks.blind.faults import Faults
from benchmarks.blind.forms import BY_KEY
from benchmarks.blind.hexahedra import mesh_hexahedra
from benchmarks.blind.laying import lay_on_plane
from benchmarks.blind.material import constants
from benchmarks.blind.network import reinforced
from benchmarks.blind.pulls import tether
from benchmarks.blind.rest_shape import true_shape
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import Setup
from benchmarks.blind.simulation import make_specimen, Specimen
from benchmarks.blind.twelfth_outside import TWELFTH_OUTSIDE

Depths = Callable[[Faults, int], np.ndarray]
BRAID = Faults(
    stiffening_form='braided', stiffening=0.7, stiffening_slant=30.0, stiffening_steep=40.0
)


def test_a_braid_adds_its_share_at_first_and_the_more_the_more_it_is_drawn() -> None:
    numbers = reinforced(constants(np.array(2e5), 0.48), np.array(2e5), BRAID)
    assert len(numbers.network) == 4
    pulls = []
    for strain in (1e-5, 0.1):
        drawn = np.diag([1.0 + strain, 1.0, 1.0])
        pulls.append(sum(each.stress(drawn)[0, 0] for each in numbers.network) / strain)
    assert pulls[0] == pytest.approx(0.7 * 2e5, rel=1e-3)
    assert pulls[1] > 2.0 * pulls[0]
    pressed = np.diag([0.95, 1.0, 1.0])
    assert not any(each.stress(pressed).any() for each in numbers.network)
    plain = constants(np.array(2e5), 0.48)
    assert reinforced(plain, np.array(2e5), replace(BRAID, stiffening=0.0)) == plain


def test_threads_of_a_braid_pull_by_their_energy() -> None:
    numbers = reinforced(constants(np.array(2e5), 0.48), np.array(2e5), BRAID)
    random = np.random.default_rng(1)
    F = np.eye(3) + random.uniform(-0.05, 0.08, (3, 3))
    move, h = random.standard_normal((3, 3)), 1e-6
    for threads in numbers.network:
        one, other = (threads.energy(F + way * h * move) for way in (1.0, -1.0))
        slope = float((threads.stress(F) * move).sum())
        assert (one - other) / (2.0 * h) == pytest.approx(slope, rel=1e-5, abs=1e-3)


def test_a_body_with_a_braid_is_stiff_by_the_slopes_of_its_forces(setup: Setup) -> None:
    specimen = make_specimen(setup, BRAID, COARSE)
    check_body_stiffness(specimen.body, specimen.mesh.nodes)


def test_a_patch_is_on_one_side_of_a_part_alone(setup: Setup) -> None:
    faults = Faults(
        contrast=1.2,
        contrast_mode='patched',
        contrast_at=0.05,
        contrast_until=0.5,
        contrast_side=-1.0,
    )
    patched, whole = (make_specimen(setup, each, 1.0) for each in (faults, Faults()))
    stiffer = np.log(np.asarray(patched.body.numbers.shear / whole.body.numbers.shear))
    values = whole.body.quadrature.values
    share = whole.shares[whole.mesh.cells] @ values.T
    across = whole.mesh.lattice[whole.mesh.cells][..., 1] @ values.T
    below = (share > 0.05) & (share < 0.5) & (across < 0.0)
    assert np.allclose(stiffer, np.where(below, 1.2, 0.0), rtol=0.0, atol=1e-12)
    assert 0.1 < below.mean() < 0.4


def test_a_wet_cloth_is_around_a_part_and_loses_weight_from_pose_to_pose(
    setup: Setup, plain: Specimen
) -> None:
    changes = BY_KEY['added_mass/drying'].draw(2, setup, np.random.default_rng(8))
    faults = Faults(**changes)
    inner, outer = faults.mass_stops
    shares, left = plain.shares, faults.mass_shares
    assert left[0] == 1.0
    assert np.all(np.diff(left) < 0.0)
    assert np.all(np.diff(left, n=2) > 0.0)
    for observation, part in zip(setup.observations, left, strict=True):
        added = cloth_masses(plain.body.masses, shares, setup, observation, faults)
        assert added.sum() == pytest.approx(1e-3 * part * faults.added_mass)
        assert not added[(shares <= inner) | (shares >= outer)].any()


def test_putty_flows_on_the_way_the_weight_draws_and_stays(setup: Setup, plain: Specimen) -> None:
    changes = BY_KEY['clamp_offset/putty'].draw(2, setup, np.random.default_rng(8))
    steps = np.diff(np.array(changes['clamp_scatter']), axis=0, prepend=0.0)
    assert not steps[:, [0, 3]].any()
    held = plain.mesh.held
    nodes, sunk = plain.mesh.nodes[held], np.zeros(3)
    for pose, (step, one) in enumerate(zip(steps, setup.observations, strict=True)):
        down = -one.world_from_object[1, :3]
        # The tip is moved by the turn times its place along x, with the weight.
        tip = np.cross(step[3:], [1.0, 0.0, 0.0])
        across = np.array([0.0, down[1], down[2]])
        assert np.allclose(tip / np.linalg.norm(tip), across / np.linalg.norm(across), atol=1e-3)
        sunk = sunk + step[3:]
        found = turn_of(nodes, rest_of(setup, Faults(**changes), pose)[held])
        assert found == pytest.approx(np.deg2rad(sunk), abs=1e-4)


def test_a_preloaded_clamp_gives_way_by_what_goes_beyond_its_moment(
    setup: Setup, plain: Specimen
) -> None:
    _, usual = weight_moment(setup)
    faults = Faults(
        clamp_form='preloaded', clamp_compliance=0.05 / usual, clamp_preload=0.5 * usual
    )
    held = plain.mesh.held
    turns = []
    for factor in (0.35, 1.0, 2.0):
        # As much stiffer as it is heavier, so that it hangs the same way.
        stiff = factor * setup.youngs_modulus
        heavy = replace(setup, density=factor * setup.density, youngs_modulus=stiff)
        found = turn_of(plain.mesh.nodes[held], rest_of(heavy, faults)[held])
        turns.append(float(np.linalg.norm(found)))
    assert turns[0] < 1e-9
    moment = [turn / 0.05 + 0.5 for turn in turns[1:]]
    assert moment[1] == pytest.approx(2.0 * moment[0], rel=0.02)
    assert 1.0 < moment[0] < 1.4


def test_a_wrong_entry_errs_evenly_less_on_either_side_of_its_depth(depths: Depths) -> None:
    clean = depths(Faults(), 1)
    seen = np.isfinite(clean)
    middle = float(np.median(clean[seen]))
    faults = Faults(depth_form='entry', depth_bias=6.0, depth_entry=middle, depth_spacing=0.01)
    error = depths(faults, 1)[seen] - clean[seen]
    expected = 0.006 * np.maximum(1.0 - np.abs(clean[seen] - middle) / 0.01, 0.0)
    assert np.allclose(error, expected, rtol=0.0, atol=1e-12)
    assert error.max() > 0.0055
    assert error.min() == 0.0


def test_of_two_cameras_in_turn_one_is_off_in_every_other_pose(
    setup: Setup, depths: Depths
) -> None:
    drawn = [
        BY_KEY['camera_offset/in turn'].draw(2, setup, np.random.default_rng(seed))
        for seed in range(8)
    ]
    wrong = [np.array(changes['camera_scatter']).any(axis=1).tolist() for changes in drawn]
    assert {tuple(each) for each in wrong} == {
        (False, True, False, True),
        (True, False, True, False),
    }
    for pose, one in enumerate(drawn[0]['camera_scatter']):
        steady = Faults(camera_shift=one[:3], camera_turn=one[3:])
        assert np.array_equal(depths(Faults(**drawn[0]), pose), depths(steady, pose))


@pytest.fixture(scope='module')
def on_a_pan(setup: Setup) -> tuple[Setup, Faults]:
    """A set-up whose body lies on a balance in the first pose, and that balance."""
    changes = BY_KEY['contact_plane/pan'].draw(2, setup, np.random.default_rng(8))
    return lay_on_plane(setup, Faults(**changes), np.random.default_rng(1))


def test_a_pan_sinks_by_the_whole_force_on_it(
    on_a_pan: tuple[Setup, Faults], plain: Specimen
) -> None:
    laid, faults = on_a_pan
    free = replace(faults, contact_height=None)
    view, found = laid.observations[0], rest_of(laid, faults)
    world = [applied(view.world_from_object, each) for each in (found, rest_of(laid, free))]
    assert faults.contact_height is not None
    sunk = faults.contact_height - float(world[0][:, 1].min())
    assert 0.002 < sunk < 0.015
    assert 0.004 < (world[0] - world[1])[:, 1].max() < 0.02
    # What the body lies on, at rest, is what its clamp does not bear.
    lower = replace(faults, contact_height=faults.contact_height - sunk + 1e-5)
    (law,) = contact_laws(plain.areas, plain.shares, view, lower)
    inner = plain.body.evaluate(found, with_stiffness=False).gradient
    free_nodes = np.setdiff1d(np.arange(len(found)), plain.mesh.held)
    weight = 9.81 * plain.body.masses[free_nodes].sum()
    pushed = (inner[free_nodes] @ view.world_from_object[1, :3]).sum() + weight
    assert faults.contact_give * pushed == pytest.approx(sunk, rel=0.02)
    check_derivatives(law, found)
    assert np.allclose(rest_of(laid, faults, 1), rest_of(laid, free, 1), rtol=0.0, atol=1e-9)


def test_lines_from_a_post_pull_by_their_energy_once_they_are_taut(
    plain: Specimen, rests: list[np.ndarray]
) -> None:
    post = np.array([0.024, 0.0, 0.06])
    long = np.linalg.norm(plain.mesh.nodes - post, axis=1)
    stiffness = np.linspace(1.0, 2.0, len(long))
    # A little shorter: what is held is at the very end of its slack otherwise.
    slack = long - 1e-4
    law = tether(post, stiffness, slack)
    check_derivatives(law, rests[0])
    pulls = np.linalg.norm(law(rests[0]).gradient, axis=1)
    longer = np.maximum(np.linalg.norm(rests[0] - post, axis=1) - slack, 0.0)
    assert np.allclose(pulls, stiffness * longer, rtol=0.0, atol=1e-12)
    law = tether(post, stiffness, long)
    assert not law(plain.mesh.nodes).gradient.any()


def test_lines_bear_a_body_that_sags_away_from_their_post(setup: Setup, plain: Specimen) -> None:
    tip = plain.shares > 0.99
    for size, least, most in ((1, 0.0025, 0.009), (2, 0.005, 0.015)):
        faults = Faults(**TWELFTH_OUTSIDE['guy'](size, setup, np.random.default_rng(8)).changes)
        moves = tip_moves(setup, plain, faults, tip)
        assert least < moves[0] < most
        assert moves[3] < 0.3 * moves[0], 'where it hangs towards the post they are slack'


def test_a_body_that_was_drawn_is_longer_beyond_the_clamp_at_its_volume(setup: Setup) -> None:
    whole, longer = (
        mesh_hexahedra(true_shape(setup.shape, each)) for each in (Faults(), Faults(drawn=0.08))
    )
    free = setup.shape.length - setup.shape.clamp
    assert longer.nodes[:, 0].max() - whole.nodes[:, 0].max() == pytest.approx(0.08 * free)
    share = true_shape(setup.shape, Faults(drawn=0.08)).arc_share(longer.lattice)
    thin = np.ptp(longer.nodes[share > 0.999, 1:], axis=0) / np.ptp(whole.nodes[:, 1:], axis=0)
    assert thin == pytest.approx(1.08**-0.5)
    mass, usual = (
        make_specimen(setup, each, COARSE).body.masses.sum()
        for each in (Faults(drawn=0.08), Faults())
    )
    assert mass == pytest.approx(usual, rel=0.01)
    assert true_shape(setup.shape, Faults()) == setup.shape


def test_a_body_that_was_drawn_reaches_some_5_and_10_mm_elsewhere(
    setup: Setup, plain: Specimen
) -> None:
    for size, least, most in ((1, 0.003, 0.009), (2, 0.006, 0.016)):
        drawn = TWELFTH_OUTSIDE['drawn'](size, setup, np.random.default_rng(8))
        faults = Faults(**drawn.changes)
        at_tip = make_specimen(setup, faults, COARSE).shares > 0.99
        assert least < max(tip_moves(setup, plain, faults, at_tip)) < most
