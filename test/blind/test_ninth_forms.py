# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the ninth set do what their labels say."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from support.blind_rests import COARSE, rest_of

from benchmarks.blind.faults import Faults
from benchmarks.blind.flexure import flexure_compliance
from benchmarks.blind.forms import BY_KEY
from benchmarks.blind.heights import by_height
from benchmarks.blind.hexahedra import mesh_hexahedra
from benchmarks.blind.laying import lay_on_plane
from benchmarks.blind.observe import true_rendering
from benchmarks.blind.paint import TIP
from benchmarks.blind.renderer import Camera
from benchmarks.blind.rest_shape import stress_free_nodes
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import Setup
from benchmarks.blind.simulation import make_specimen, Specimen

Depths = Callable[[Faults, int], np.ndarray]
CAMERA = Camera(640, 480, 600.0, 620.0, 321.0, 238.0)


def test_a_lens_element_beside_the_axis_moves_what_browns_formula_says() -> None:
    one, two, barrel = 0.03, -0.05, -0.2
    bent = replace(CAMERA, tangential=(one, two), radial=barrel)
    x, y = 0.12, -0.07
    squares = x**2 + y**2
    column = x * (1.0 + barrel * squares) + 2.0 * one * x * y + two * (squares + 2.0 * x**2)
    row = y * (1.0 + barrel * squares) + one * (squares + 2.0 * y**2) + 2.0 * two * x * y
    found = bent.project(np.array([0.3 * x, 0.3 * y, 0.3]))
    assert found == pytest.approx([600.0 * column + 321.0, 620.0 * row + 238.0], rel=1e-12)
    plain = replace(bent, tangential=(0.0, 0.0))
    assert np.abs(found - plain.project(np.array([x, y, 1.0]))).min() > 0.2


def test_a_decentred_lens_moves_its_middle_and_distorts_the_same_way(setup: Setup) -> None:
    changes = BY_KEY['camera_offset/decentred'].draw(2, setup, np.random.default_rng(8))
    middle, (one, two) = np.array(changes['center_shift']), changes['tangential']
    # What distorts the columns by x^2 is the second coefficient.
    along = middle / np.linalg.norm(middle)
    assert np.array([two, one]) @ along == pytest.approx(np.hypot(one, two), rel=1e-3)
    assert changes['radial_distortion'] < 0.0


def test_a_body_that_slid_out_is_held_by_less_and_hangs_lower(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    out, shifted = Faults(clamp_slid=8.0), Faults(clamp_shift=(8.0, 0.0, 0.0))
    specimen = make_specimen(setup, out, COARSE)
    clamp = setup.shape.clamp
    assert specimen.mesh.nodes[specimen.mesh.held, 0].max() == pytest.approx(clamp - 0.008)
    assert specimen.body.masses.sum() == pytest.approx(plain.body.masses.sum(), rel=1e-9)
    found = rest_of(setup, out)
    moved = found[specimen.mesh.held] - specimen.mesh.nodes[specimen.mesh.held]
    assert np.allclose(moved, [0.008, 0.0, 0.0], atol=1e-12)
    up = setup.observations[0].world_from_object[1, :3]
    sags = [
        -float((where[body.shares > 0.99] - body.mesh.nodes[body.shares > 0.99]).mean(axis=0) @ up)
        for where, body in (
            (rests[0], plain),
            (rest_of(setup, shifted), plain),
            (found, specimen),
        )
    ]
    # By the fourth power of the free length; what is shifted alone hangs as before.
    free = setup.shape.length - clamp
    assert sags[2] - sags[1] > 0.002
    assert sags[1] == pytest.approx(sags[0], rel=0.1)
    assert sags[2] / sags[0] == pytest.approx((1.0 + 0.008 / free) ** 4, rel=0.1)


def test_a_flexure_gives_way_as_a_slender_beam_does() -> None:
    by_turn, length = 2.0, 0.03
    whole = flexure_compliance(by_turn, length)
    assert np.allclose(whole, whole.T, rtol=0.0, atol=1e-15)
    assert np.linalg.eigvalsh(whole).min() > -1e-12
    # The turn of each slice by the moment there, and where that takes the end.
    force, moment = np.array([0.3, -0.5, 0.8]), np.array([0.01, 0.02, -0.03])
    count = 2000
    turn, shift = np.zeros(3), np.zeros(3)
    for place in (np.arange(count) + 0.5) / count * length:
        arm = np.array([length - place, 0.0, 0.0])
        change = by_turn / count * (moment + np.cross(arm, force))
        turn, shift = turn + change, shift + np.cross(change, arm)
    assert whole @ np.concatenate([force, moment]) == pytest.approx(
        np.concatenate([shift, turn]), rel=1e-5
    )


def test_a_clamp_on_a_flexure_goes_where_force_and_moment_take_it(
    setup: Setup, plain: Specimen
) -> None:
    faults = Faults(clamp_form='flexure', clamp_compliance=1.0, clamp_length=0.04)
    found = rest_of(setup, faults)
    held, center = plain.mesh.held, plain.center
    before, after = plain.mesh.nodes[held], found[held]
    shift = after.mean(axis=0) - before.mean(axis=0)
    turned = np.linalg.svd((before - before.mean(axis=0)).T @ (after - after.mean(axis=0)))
    matrix = (turned[0] @ turned[2]).T
    skew = 0.5 * (matrix - matrix.T)
    turn = np.array([skew[2, 1], skew[0, 2], skew[1, 0]])
    turn *= np.arcsin(np.linalg.norm(turn)) / np.linalg.norm(turn)
    # All that the flexure bears is the weight, at where the body's mass came to be.
    masses = plain.body.masses
    weight = -9.81 * masses.sum() * setup.observations[0].world_from_object[1, :3]
    moved = shift + (np.eye(3) - matrix) @ (before.mean(axis=0) - center)
    arm = masses @ found / masses.sum() - center - moved
    bears = np.concatenate([weight, np.cross(arm, weight)])
    expected = flexure_compliance(1.0, 0.04) @ bears
    assert np.concatenate([moved, turn]) == pytest.approx(expected, rel=2e-3, abs=2e-6)
    assert np.linalg.norm(moved) > 5e-4


def test_a_kink_turns_all_that_lies_beyond_it_by_as_much_as_an_arc(setup: Setup) -> None:
    mesh = mesh_hexahedra(setup.shape)
    faults = Faults(curvature_form='kink', rest_curvature=(1.2, -1.6), curvature_at=0.4)
    bent = stress_free_nodes(mesh.nodes, setup.shape, faults)
    share = setup.shape.arc_share(mesh.lattice)
    inner, outer = share < 0.349, share > 0.451
    assert np.allclose(bent[inner], mesh.nodes[inner], rtol=0.0, atol=1e-15)
    steps = np.column_stack([np.ones(outer.sum()), mesh.nodes[outer]])
    fit, left = np.linalg.lstsq(steps, bent[outer], rcond=None)[:2]
    assert np.sqrt(left.max()) < 1e-9, 'it stays straight there'
    free = setup.shape.length - setup.shape.clamp
    angle = np.arccos(np.clip(0.5 * (np.trace(fit[1:]) - 1.0), -1.0, 1.0))
    assert angle == pytest.approx(2.0 * free, rel=1e-6)


def test_what_comes_from_the_clamp_falls_to_a_third_over_a_fifth(setup: Setup) -> None:
    changed, whole = (
        make_specimen(setup, each, 1.0)
        for each in (Faults(contrast=0.9, contrast_mode='decaying'), Faults())
    )
    softer = -np.log(np.asarray(changed.body.numbers.shear / whole.body.numbers.shear))
    share = whole.shares[whole.mesh.cells].mean(axis=1)
    means = softer.mean(axis=1)
    near, far = np.abs(share - 0.2) < 0.05, share > 0.95
    assert means[near] == pytest.approx(0.9 * np.exp(-5.0 * share[near]), rel=0.03)
    assert means[far].max() < 0.01
    stiffer = BY_KEY['stiffness_contrast/decaying']
    drawn = [stiffer.draw(2, setup, np.random.default_rng(seed)) for seed in range(12)]
    assert {np.sign(changes['contrast']) for changes in drawn} == {-1.0, 1.0}


def test_a_trailing_cable_weighs_what_hangs_of_it(setup: Setup, plain: Specimen) -> None:
    at, view = 0.6, setup.observations[0]
    around = np.abs(plain.shares - at) < 0.06
    side = around & (plain.mesh.lattice[:, 1] > 0.0)
    lengths = []
    for table in (-0.1, -0.2):
        cable = Faults(
            mass_form='trailing',
            added_mass=3.0,
            added_mass_at=at,
            mass_drop=0.08,
            mass_table=table,
        )
        trailing = rest_of(setup, cable)
        high = applied(view.world_from_object, trailing[side])[:, 1].mean() - table
        # A dead load of that weight at the same side brings it there as well.
        grams = 3.0 * high / 0.08
        heavy = rest_of(setup, Faults(mass_form='hat', added_mass=grams, added_mass_at=at))
        along = [
            (rest - plain.mesh.nodes)[plain.shares > 0.99].mean(axis=0)
            for rest in (trailing, heavy)
        ]
        up = view.world_from_object[1, :3]
        assert along[0] @ up == pytest.approx(along[1] @ up, rel=0.03)
        # It hangs from one side.
        (law,) = by_height(plain.mesh.lattice, plain.body.masses, plain.shares, view, cable)
        drawn = law(trailing).gradient @ view.world_from_object[1, :3]
        assert drawn.sum() == pytest.approx(9.81e-3 * grams, rel=0.02)
        assert plain.mesh.lattice[drawn > 0.0, 1].min() > 0.0
        lengths.append(high)
    assert lengths[1] - lengths[0] == pytest.approx(0.1, abs=0.02)


def test_an_error_of_what_little_light_returns_is_its_logarithm(
    setup: Setup, plain: Specimen, rests: list[np.ndarray], depths: Depths
) -> None:
    distance = float(np.linalg.norm(setup.depth_from_world[:3, 3]))
    view = true_rendering(plain, setup, setup.observations[1], Faults(), rests[1])
    seen = np.isfinite(view.depth)
    error = depths(Faults(depth_bias=3.0, depth_form='walk'), 1)[seen] - view.depth[seen]
    facing = np.maximum(view.facing[seen], 1.0 / 3.0)
    expected = 1.0 + 2.0 * np.log(view.depth[seen] / distance) - np.log(facing)
    assert np.allclose(error, 0.003 * expected, rtol=0.0, atol=1e-12)
    assert np.ptp(error) > 0.001
    assert error.min() > 0.0


def test_what_is_sprayed_from_above_is_seen_on_the_upper_half_alone(
    setup: Setup, plain: Specimen, rests: list[np.ndarray], depths: Depths
) -> None:
    half, whole = Faults(region_bias=5.0, region_above=True), Faults(region_bias=5.0)
    shares = []
    for pose in range(4):
        observation = setup.observations[pose]
        view = true_rendering(plain, setup, observation, whole, rests[pose])
        tip, clean = view.labels == TIP, depths(Faults(), pose)
        error = depths(half, pose)[tip] - clean[tip]
        assert np.all((np.abs(error) < 1e-12) | (np.abs(error - 0.005) < 1e-12))
        others = np.isfinite(clean) & ~tip
        assert np.array_equal(depths(half, pose)[others], clean[others])
        shares.append(float((error > 0.001).mean()))
    # A side that stands upright is half of it; one that lies flat is all of it or not at all.
    assert 0.35 < shares[0] < 0.75
    assert not 0.3 < shares[1] < 0.7


def test_a_roll_of_foam_lifts_what_lies_over_it_and_yields(setup: Setup) -> None:
    changes = BY_KEY['contact_plane/roll'].draw(2, setup, np.random.default_rng(8))
    laid, faults = lay_on_plane(setup, Faults(**changes), np.random.default_rng(1))
    free = replace(faults, contact_height=None)
    found, hanging = rest_of(laid, faults), rest_of(laid, free)
    world = [applied(laid.observations[0].world_from_object, each) for each in (found, hanging)]
    assert faults.contact_height is not None
    dents = np.hypot(
        world[0][:, 0] - faults.contact_at, world[0][:, 1] - faults.contact_height + 0.018
    )
    assert 0.0005 < 0.018 - dents.min() < 0.006
    assert (world[0] - world[1])[:, 1].max() > 0.004
    assert world[0][:, 1].min() < faults.contact_height - 0.001, 'the tip hangs beyond it'
    assert np.array_equal(rest_of(laid, faults, 1), rest_of(laid, free, 1))


def test_a_thread_draws_its_place_with_one_steady_force(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    faults = Faults(tilt_form='thread', gravity_tilt=(8.0, -5.0), tilt_at=0.6)
    away = {}
    for pose in (0, 1):
        turn = setup.observations[pose].world_from_object[:3, :3]
        found = rest_of(setup, faults, pose)
        near = np.abs(plain.shares - 0.6) < 0.05
        moved = turn @ (found - rests[pose])[near].mean(axis=0)
        away[pose] = moved
        # What the clamp bears beside the weight: the force, steady in the world.
        pull = plain.body.evaluate(found, with_stiffness=False).gradient
        bears = turn @ pull[plain.body.held].sum(axis=0)
        free = plain.body.masses[plain.shares > 0.0].sum()
        held = plain.body.masses[plain.body.held].sum()
        weight = np.array([0.0, 9.81 * (plain.body.masses.sum() - held), 0.0])
        angle = np.deg2rad(np.hypot(8.0, 5.0))
        sideways = 9.81 * free * np.sin(angle) * np.array([-5.0, 0.0, -8.0]) / np.hypot(8.0, 5.0)
        assert bears - weight == pytest.approx(-sideways, rel=1e-3, abs=1e-5)
    alike = away[0] @ away[1] / (np.linalg.norm(away[0]) * np.linalg.norm(away[1]))
    assert alike > 0.95, 'it is drawn the same way in both'
