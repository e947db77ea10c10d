# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms and causes of the fourteenth set do what their labels say."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from support.blind_derivatives import check_body_stiffness, check_derivatives
from support.blind_draws import draw_faults
from support.blind_rests import COARSE, lying, rest_of, tip_moves, turn_of

from benchmarks.blind.contact import contact_laws
from benchmarks.blind.faults import Faults
from benchmarks.blind.fibres import Fibres
from benchmarks.blind.fourteenth_outside import FOURTEENTH_OUTSIDE
from benchmarks.blind.jaws import pinched
from benchmarks.blind.laying import lay_on_plane, softer
from benchmarks.blind.observe import true_rendering
from benchmarks.blind.paint import tip_part
from benchmarks.blind.rest_shape import stress_free_nodes
from benchmarks.blind.rope import rope_force, rope_give
from benchmarks.blind.rotations import rotation
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.simulation import make_specimen, settle
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.veil import veiled
from benchmarks.blind.wear import strains, worn

KNIT = Faults(stiffening_form='knitted', stiffening=2.0)
Depths = Callable[[Faults, int], np.ndarray]


def test_loops_pull_by_their_energy_and_bear_nothing_at_first() -> None:
    loops = Fibres(np.array(3e4), np.array([1.0, 0.0, 0.0]), slack=True, knit=True)
    drawn = np.diag([1.07, 0.97, 0.97]) + np.random.default_rng(1).uniform(-0.02, 0.02, (3, 3))
    move, h = np.random.default_rng(2).standard_normal((3, 3)), 1e-6
    one, other = (loops.energy(drawn + way * h * move) for way in (1.0, -1.0))
    slope = float((loops.stress(drawn) * move).sum())
    assert slope != 0.0
    assert (one - other) / (2.0 * h) == pytest.approx(slope, rel=1e-5)
    assert not loops.stress(np.diag([0.95, 1.02, 1.02])).any()
    assert loops.energy(np.eye(3)) == 0.0


def test_a_knit_lies_near_the_surface_and_adds_its_share_where_it_is_drawn(setup: Setup) -> None:
    body = make_specimen(setup, KNIT, COARSE).body
    (loops,) = body.numbers.network
    mesh = make_specimen(setup, KNIT, COARSE).mesh
    points = mesh.lattice[mesh.cells].swapaxes(1, 2) @ body.quadrature.values.T
    half = 0.5 * np.array(setup.shape.section)[:, None]
    near = (np.abs(points[:, 1:]) / half).max(axis=1) > 0.6
    assert near.any()
    assert not near.all()
    assert np.array_equal(loops.stiffness > 0.0, near)
    # The energy's second derivative by a strain e, whose square grows by 2 e, where that is 0.1.
    assert 24.0 * loops.stiffness[near] * 0.1 == pytest.approx(2.0 * setup.youngs_modulus)
    check_body_stiffness(body, mesh.nodes)


def test_a_knitted_body_sags_less_than_a_bare_one(setup: Setup) -> None:
    soft = softer(setup, 0.3)
    tip = make_specimen(soft, KNIT, COARSE).shares > 0.99
    lifts = []
    for size in (1, 2):
        knitted = rest_of(soft, draw_faults('strain_stiffening/knitted', soft, size))
        lifts.append(float((knitted - rest_of(soft, Faults()))[tip, 2].mean()))
    assert 0.002 < lifts[0] < lifts[1] < 0.02


def test_a_tube_is_in_the_core_up_to_its_end(setup: Setup) -> None:
    faults = Faults(contrast=2.0, contrast_mode='cored', contrast_at=0.5)
    cored, whole = (make_specimen(setup, each, 1.0) for each in (faults, Faults()))
    harder = np.log(np.asarray(cored.body.numbers.shear / whole.body.numbers.shear))
    values, mesh = whole.body.quadrature.values, whole.mesh
    share = whole.shares[mesh.cells] @ values.T
    points = mesh.lattice[mesh.cells].swapaxes(1, 2) @ values.T
    width, height = setup.shape.section
    inside = (np.abs(points[:, 1]) < 0.25 * width) & (np.abs(points[:, 2]) < 0.25 * height)
    assert inside.any()
    assert np.allclose(harder, 2.0 * (inside & (share < 0.5)), rtol=0.0, atol=1e-9)


def test_a_tube_bears_a_part_of_a_bodys_sag(setup: Setup) -> None:
    free, lifts = make_specimen(setup, Faults()), []
    hanging = settle(free, setup, setup.observations[0], Faults())
    for size in (1, 2):
        faults = draw_faults('stiffness_contrast/cored', setup, size)
        # Coarse cells have no points in the core.
        found = settle(make_specimen(setup, faults), setup, setup.observations[0], faults)
        lifts.append(float((found - hanging)[free.shares > 0.99].mean(axis=0)[2]))
    assert 0.003 < lifts[0] < 0.008
    assert 0.006 < lifts[1] < 0.016


def test_a_body_from_a_rail_is_bent_most_there_and_its_tip_is_as_far_as_an_arcs(
    setup: Setup,
) -> None:
    shape = setup.shape
    ahead = np.linspace(0.0, 1.0, 121)
    nodes = np.zeros((121, 3))
    nodes[:, 0] = shape.clamp + ahead * (shape.length - shape.clamp)
    faults = Faults(rest_curvature=(0.0, 0.3), curvature_form='draped', curvature_at=0.4)
    draped = stress_free_nodes(nodes, shape, faults)
    arc = stress_free_nodes(nodes, shape, replace(faults, curvature_form='arc'))
    assert draped[-1, 1] == pytest.approx(arc[-1, 1], rel=0.02)
    steps = np.diff(draped, axis=0)
    turns = np.diff(np.arctan2(steps[:, 1], steps[:, 0]))
    parts = turns.reshape(-1)[:119]
    assert 0.3 < ahead[1:-1][parts.argmax()] < 0.5
    assert parts[:5].sum() < 0.1 * parts[46:51].sum()
    assert parts[-5:].sum() < 0.1 * parts[46:51].sum()


def test_jaws_keep_a_volume_and_press_it_out_more_on_one_side(
    setup: Setup, plain: Specimen
) -> None:
    faults = Faults(clamp_pinch=0.08, clamp_wedge=0.03)
    mesh, moved = plain.mesh, pinched(plain, faults).mesh.nodes
    assert pinched(plain, Faults()) is plain
    held, after = mesh.nodes[mesh.held], moved[mesh.held]
    assert np.array_equal(held[:, 1], after[:, 1])
    assert np.array_equal(after[held[:, 0] == 0.0, 0], held[held[:, 0] == 0.0, 0])
    inside = (held[:, 0] > 0.0) & (held[:, 2] != 0.0)
    longer = after[inside, 0] / held[inside, 0]
    thinner = after[inside, 2] / held[inside, 2]
    assert longer * thinner == pytest.approx(1.0)
    side = held[inside, 1] / held[:, 1].max()
    assert 1.0 - thinner == pytest.approx(0.08 + 0.03 * side)
    # What lies beyond starts where the mouth takes it, but for a bend of that.
    mouth = np.isclose(mesh.nodes[:, 0], setup.shape.clamp)
    fitted = np.polyfit(mesh.nodes[mouth, 1], moved[mouth, 0], 1)[0]
    beyond = moved[~np.isin(np.arange(len(moved)), mesh.held)]
    before = mesh.nodes[~np.isin(np.arange(len(moved)), mesh.held)]
    turn = turn_of(before, beyond)
    assert turn == pytest.approx([0.0, 0.0, -fitted], abs=2e-3)


def test_a_rope_pulls_by_the_length_of_its_halves(setup: Setup) -> None:
    faults = draw_faults('contact_plane/rope', setup)
    half, sunk = faults.contact_span, 0.004
    loose = half / (1.0 + faults.contact_drawn)
    stiffness = faults.contact_tension / (half - loose)

    def energy(depth: float) -> float:
        return stiffness * (float(np.hypot(half, depth)) - loose) ** 2

    slope = (energy(sunk + 1e-6) - energy(sunk - 1e-6)) / 2e-6
    force = float(rope_force(np.array(sunk), faults))
    assert force == pytest.approx(slope, rel=1e-6)
    assert rope_give(faults)(force) == pytest.approx(sunk, abs=1e-7)
    # It stiffens: twice as deep it bears more than twice as much.
    assert float(rope_force(np.array(2.0 * sunk), faults)) > 2.1 * force


@pytest.fixture(scope='module')
def on_a_rope(setup: Setup) -> tuple[Setup, Faults]:
    """A set-up whose body lies on a rope in the first pose, and that rope."""
    return lay_on_plane(setup, draw_faults('contact_plane/rope', setup), np.random.default_rng(1))


def test_a_rope_bears_a_body_and_sinks_by_its_force(
    on_a_rope: tuple[Setup, Faults], plain: Specimen
) -> None:
    laid, faults = on_a_rope
    assert faults.contact_height is not None
    for pose, touches in enumerate((True, False, True, False)):
        view = laid.observations[pose]
        up = view.world_from_object[1, :3]
        found, moved = lying(laid, plain, faults, pose)
        assert (0.002 < moved < 0.02) == touches
        # Of all depths to which it may sink, the one at which its halves bear the push.
        depths = np.linspace(0.0, 0.02, 2001)
        pushes = [
            -float((law(found).gradient @ up).sum())
            for depth in depths
            for law in contact_laws(
                plain.areas,
                plain.shares,
                view,
                replace(faults, contact_height=faults.contact_height - depth),
            )
        ]
        lacking = np.array(pushes) - rope_force(depths, faults)
        sunk = float(depths[np.abs(lacking).argmin()])
        assert (sunk > 0.0005) == touches
        (law,) = contact_laws(plain.areas, plain.shares, view, faults)
        check_derivatives(law, found - 0.003 * up)


def test_a_veil_mixes_depths_by_their_light() -> None:
    faults = Faults(depth_form='veil', depth_bias=-6.0, depth_veil=0.16)
    square = veiled(np.array([0.33]), np.array([1.0]), 0.33, faults)
    assert square == pytest.approx([-0.006])
    far, aslant = (
        float(veiled(np.array([depth]), np.array([facing]), 0.33, faults)[0])
        for depth, facing in ((0.36, 1.0), (0.33, 0.5))
    )
    # Twice the light of the veil over that of the pixel, whose sum is what is divided by.
    part = 0.006 / 0.17
    share = part / (1.0 - part)
    assert aslant == pytest.approx(-0.17 * share / (0.5 + share))
    assert far < -0.006
    assert not veiled(np.array([0.16]), np.array([0.7]), 0.33, faults).any()


def test_bands_of_tape_err_and_what_is_between_them_does_not(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    faults = draw_faults('depth_bias_by_region/banded', setup)
    whole = replace(faults, region_bands=(0.0, 0.0))
    covered = []
    for each in (faults, whole):
        view = true_rendering(plain, setup, setup.observations[0], each, rests[0])
        covered.append(tip_part(view.labels))
    banded, all_of_it = covered
    assert not banded[all_of_it == 0.0].any()
    assert banded.sum() / all_of_it.sum() == pytest.approx(faults.region_bands[1], abs=0.15)
    # Along the image's row of the body's middle there are two bands and more.
    columns = banded.max(axis=(0, 2))
    assert (np.diff(columns) != 0.0).sum() >= 3


def test_a_clamp_that_creeps_goes_a_part_of_its_way_in_every_pose(
    setup: Setup, plain: Specimen
) -> None:
    faults = draw_faults('compliant_clamp/creeping', setup)
    held, center = plain.mesh.held, plain.center
    before = np.zeros(3)
    for pose, view in enumerate(setup.observations):
        rest = rest_of(setup, faults, pose)
        weight = plain.body.masses[:, None] * (-GRAVITY * view.world_from_object[1, :3])
        # About a clamp's middle weight is all that turns a body; held nodes bear their own.
        moment = np.cross(rest - center, weight).sum(axis=0)
        turn = turn_of(plain.mesh.nodes[held], rest[held])
        whole = faults.clamp_compliance * moment
        assert turn == pytest.approx(before + faults.clamp_crept * (whole - before), abs=1e-3)
        before = turn


def test_rubber_is_worn_where_it_was_strained_and_nowhere_before_the_first_pose(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    fresh = worn(plain, lambda body, number: rests[number], 0, 0.4)
    assert fresh is plain
    once = worn(plain, lambda body, number: rests[number], 1, 0.4)
    left = np.asarray(once.body.numbers.shear / plain.body.numbers.shear)
    strained = strains(plain.body, rests[0])
    assert left == pytest.approx(0.6 + 0.4 * np.exp(-strained / 0.006))
    assert left.min() < 0.9
    # By the largest of all strains, not by how often.
    again = worn(plain, lambda body, number: rests[0], 3, 0.4)
    assert np.asarray(again.body.numbers.shear / once.body.numbers.shear) == pytest.approx(1.0)


def test_strains_are_those_of_a_pull_and_none_of_aturn_of(plain: Specimen) -> None:
    nodes = plain.mesh.nodes
    assert strains(plain.body, nodes @ rotation(np.array([0.3, -0.2, 0.5])).T) == pytest.approx(
        0.0, abs=1e-6
    )
    drawn = nodes * np.array([1.1, 1.1**-0.5, 1.1**-0.5])
    assert strains(plain.body, drawn) == pytest.approx(
        np.sqrt((1.1**2 + 2.0 / 1.1 - 3.0) / 3.0), rel=1e-6
    )


def test_a_worn_body_rests_at_first_as_a_new_one_and_sags_more_later(
    setup: Setup, plain: Specimen
) -> None:
    for size, least, most in ((1, 0.002, 0.009), (2, 0.004, 0.025)):
        cause = FOURTEENTH_OUTSIDE['worn'](size, setup, np.random.default_rng(8))
        moves = tip_moves(setup, plain, Faults(**cause.changes), plain.shares > 0.99)
        assert moves[0] < 1e-6
        assert least < moves[3] < most


def test_a_sensor_tells_no_depth_below_its_least(setup: Setup, depths: Depths) -> None:
    errors = []
    for size in (1, 2):
        cause = FOURTEENTH_OUTSIDE['clipped'](size, setup, np.random.default_rng(8))
        faults = Faults(**cause.changes)
        least, largest = faults.clipped_near + 1e-3 * faults.clipped, []
        for pose in range(4):
            clean, found = depths(Faults(), pose), depths(faults, pose)
            assert np.array_equal(found, np.maximum(clean, least))
            there = np.isfinite(clean)
            largest.append(float((found[there] - clean[there]).max()))
        errors.append(max(largest))
    assert 0.005 < errors[0] < errors[1] < 0.04
