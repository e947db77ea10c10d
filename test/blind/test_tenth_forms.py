# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms and causes of the tenth set do what their labels say."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from support.blind_derivatives import check_derivatives
from support.blind_rests import rest_of, tip_moves, turn_of

from benchmarks.blind.amplitudes import weight_moment
from benchmarks.blind.contact import contact_laws, lowered
from benchmarks.blind.faults import Faults
from benchmarks.blind.forms import BY_KEY
from benchmarks.blind.heights import by_height
from benchmarks.blind.hexahedra import mesh_hexahedra
from benchmarks.blind.laying import lay_on_plane
from benchmarks.blind.observe import true_rendering
from benchmarks.blind.paint import FIXTURE
from benchmarks.blind.pulls import turntable
from benchmarks.blind.rest_shape import stress_free_nodes
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import Setup
from benchmarks.blind.simulation import make_specimen, Specimen
from benchmarks.blind.tenth_outside import TENTH_OUTSIDE

Depths = Callable[[Faults, int], np.ndarray]


def _turn(before: np.ndarray, after: np.ndarray) -> float:
    """Return by how much points turned as a whole [rad]."""
    return float(np.linalg.norm(turn_of(before, after)))


def test_a_lens_that_is_focused_anew_scales_each_picture_by_its_own_share(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    shares = (0.5, -1.0, 0.0, 0.8)
    faults = Faults(focal_scale=0.08, center_shift=(6.0, -8.0), focus_shares=shares)
    for pose, share in enumerate(shares):
        steady = Faults(focal_scale=0.08 * share, center_shift=(6.0 * share, -8.0 * share))
        found, expected = (
            true_rendering(plain, setup, setup.observations[pose], each, rests[pose])
            for each in (faults, steady)
        )
        assert (found.column, found.row) == (expected.column, expected.row)
        assert np.array_equal(found.depth, expected.depth)


def test_focusing_anew_is_drawn_for_every_pose_and_reaches_the_whole(setup: Setup) -> None:
    changes = BY_KEY['camera_offset/refocused'].draw(2, setup, np.random.default_rng(8))
    shares = np.array(changes['focus_shares'])
    assert len(shares) == len(setup.observations)
    assert np.abs(shares).max() == 1.0
    assert np.ptp(shares) > 0.1


def test_a_dragged_jaw_shears_what_is_held_and_turns_what_is_free(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    found = rest_of(setup, Faults(clamp_drag=(0.06, -0.08)))
    held = plain.mesh.held
    nodes = plain.mesh.nodes[held]
    along = nodes[:, 1] * 0.06 - nodes[:, 2] * 0.08
    assert np.allclose(found[held, 0] - nodes[:, 0], along, rtol=0.0, atol=1e-12)
    assert np.allclose(found[held, 1:], nodes[:, 1:], rtol=0.0, atol=1e-12)
    # The tip is turned by what the sections at the mouth are.
    tip = plain.shares > 0.8
    assert _turn(rests[0][tip], found[tip]) == pytest.approx(0.1, rel=0.15)


def test_a_clamp_with_play_turns_easily_and_then_no_more(setup: Setup, plain: Specimen) -> None:
    _, usual = weight_moment(setup)
    easy = np.deg2rad(4.0) / (0.15 * usual)
    faults = Faults(clamp_form='play', clamp_play=4.0, clamp_compliance=easy)
    held = plain.mesh.held
    heavy = replace(setup, density=1.5 * setup.density, youngs_modulus=1.5 * setup.youngs_modulus)
    turns = [_turn(plain.mesh.nodes[held], rest_of(each, faults)[held]) for each in (setup, heavy)]
    # Half as much weight again, on a body as much stiffer, adds next to nothing.
    assert 0.9 * np.deg2rad(4.0) < turns[0] < turns[1] < np.deg2rad(4.0)
    light = replace(setup, density=0.02 * setup.density)
    assert _turn(plain.mesh.nodes[held], rest_of(light, faults)[held]) < 0.2 * np.deg2rad(4.0)


def test_a_mould_on_trestles_sags_between_them_and_bends_back_beyond(setup: Setup) -> None:
    mesh = mesh_hexahedra(setup.shape)
    bent, arc = (
        stress_free_nodes(
            mesh.nodes, setup.shape, Faults(curvature_form=form, rest_curvature=(0.0, 1.5))
        )
        for form in ('trestles', 'arc')
    )
    share = setup.shape.arc_share(mesh.lattice)
    tip = share > 0.999
    free = setup.shape.length - setup.shape.clamp
    moves = [(each - mesh.nodes)[tip, 1].mean() for each in (bent, arc)]
    assert moves[1] == pytest.approx(0.75 * free**2, rel=0.02)
    assert moves[0] == pytest.approx(moves[1], rel=0.02)
    # Near both ends it turns the other way than in the middle.
    places = np.unique(share[share > 0.0])
    middles = np.array([bent[np.abs(share - place) < 1e-9].mean(axis=0) for place in places])
    slopes = np.diff(middles[:, 1]) / np.diff(middles[:, 0])
    between = 0.5 * (places[1:] + places[:-1])
    rates = np.diff(slopes) / np.diff(between)
    at = places[1:-1]
    assert rates[np.abs(at - 0.5) < 0.1].min() > 0.0
    assert rates[at > 0.9].max() < 0.0


def test_what_a_lamp_cures_falls_by_the_square_of_the_distance(setup: Setup) -> None:
    lit, whole = (
        make_specimen(setup, each, 1.0)
        for each in (Faults(contrast=0.9, contrast_mode='lamp', contrast_at=0.2), Faults())
    )
    stiffer = np.log(np.asarray(lit.body.numbers.shear / whole.body.numbers.shear)).mean(axis=1)
    share = whole.shares[whole.mesh.cells].mean(axis=1)
    free = share > 0.05
    expected = 0.9 / (1.0 + ((share - 0.2) / 0.15) ** 2)
    assert stiffer[free] == pytest.approx(expected[free], abs=0.04)
    drawn = [
        BY_KEY['stiffness_contrast/lamp'].draw(2, setup, np.random.default_rng(seed))
        for seed in range(12)
    ]
    assert {np.sign(changes['contrast']) for changes in drawn} == {-1.0, 1.0}


def test_an_error_of_upper_rows_falls_to_a_third_over_a_quarter_of_the_image(
    setup: Setup, plain: Specimen, rests: list[np.ndarray], depths: Depths
) -> None:
    view = true_rendering(plain, setup, setup.observations[2], Faults(), rests[2])
    seen = np.isfinite(view.depth)
    wrong = depths(Faults(depth_bias=4.0, depth_form='upper rows'), 2)
    error = wrong[seen] - depths(Faults(), 2)[seen]
    rows = view.row + np.arange(view.depth.shape[0])[:, None, None] - setup.camera.cy
    share = np.exp(-rows / (0.25 * setup.camera.height))
    expected = 0.004 * np.broadcast_to(share, seen.shape)[seen]
    assert np.allclose(error, expected, rtol=0.0, atol=1e-12)
    assert np.ptp(error) > 0.001
    # The fixture is seen wrong as well.
    assert np.all(error[view.labels[seen] == FIXTURE] > 0.0)


@pytest.fixture(scope='module')
def on_a_step(setup: Setup) -> tuple[Setup, Faults]:
    """A set-up whose body lies on a block with a step in the first pose, and that step."""
    changes = BY_KEY['contact_plane/step'].draw(2, setup, np.random.default_rng(8))
    return lay_on_plane(setup, Faults(**changes), np.random.default_rng(1))


def test_a_block_with_a_step_bears_the_body_on_either_height(
    on_a_step: tuple[Setup, Faults], plain: Specimen
) -> None:
    laid, faults = on_a_step
    free = replace(faults, contact_height=None)
    found, hanging = rest_of(laid, faults), rest_of(laid, free)
    world = [applied(laid.observations[0].world_from_object, each) for each in (found, hanging)]
    assert faults.contact_height is not None
    floor = faults.contact_height - lowered(plain.shares, faults)
    assert -1e-4 < (world[0][:, 1] - floor).min() < 0.0
    assert 0.003 < (world[0] - world[1])[:, 1].max() < 0.02
    low = world[0][plain.shares > faults.contact_share, 1].min()
    assert low < faults.contact_height - 0.001, 'the outer part lies or hangs below the step'
    assert np.array_equal(rest_of(laid, faults, 1), rest_of(laid, free, 1))


def test_a_step_pushes_by_its_energy_and_not_at_the_root(
    on_a_step: tuple[Setup, Faults], plain: Specimen
) -> None:
    laid, faults = on_a_step
    deep = replace(faults, contact_height=1.0)
    (law,) = contact_laws(plain.areas, plain.shares, laid.observations[0], deep)
    check_derivatives(law, plain.mesh.nodes)
    pushes = np.linalg.norm(law(plain.mesh.nodes).gradient, axis=1)
    assert not pushes[plain.shares <= 0.45].any()
    assert pushes[(plain.shares > 0.45) & (plain.areas > 0.0)].min() > 0.0


def test_a_turntable_draws_each_part_by_its_energy_and_distance(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    side, masses, view = np.array([1.5, 0.0, -2.0]), plain.body.masses, setup.observations[2]
    law = turntable(masses, view, side, 0.2)
    check_derivatives(law, rests[2])
    forces = -law(rests[2]).gradient @ view.world_from_object[:3, :3].T
    away = applied(view.world_from_object, rests[2]) + 0.2 * side / 2.5
    expected = 2.5 / 0.2 * masses[:, None] * away * np.array([1.0, 0.0, 1.0])
    assert np.allclose(forces, expected, rtol=0.0, atol=1e-12)


def test_far_from_its_axis_a_turntable_is_a_steady_push(setup: Setup) -> None:
    far = Faults(tilt_form='turntable', gravity_tilt=(8.0, -5.0), tilt_radius=1e4)
    steady = Faults(tilt_form='side_force', gravity_tilt=(8.0, -5.0))
    near = replace(far, tilt_radius=0.2)
    rest = rest_of(setup, steady, 2)
    assert np.abs(rest_of(setup, far, 2) - rest).max() < 2e-6
    assert np.abs(rest_of(setup, near, 2) - rest).max() > 2e-4


def test_a_charged_screen_draws_by_its_energy_and_the_exponential_of_the_distance(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    view = setup.observations[2]
    faults = Faults(screen=0.3, screen_reach=0.07)
    (law,) = by_height(plain.mesh.lattice, plain.body.masses, plain.shares, view, faults)
    check_derivatives(law, rests[2])
    forces = -law(rests[2]).gradient @ view.world_from_object[:3, :3].T
    masses = plain.body.masses * (plain.shares > 0.0)
    behind = np.exp(-applied(view.world_from_object, rests[2])[:, 2] / 0.07)
    assert np.allclose(forces[:, :2], 0.0, rtol=0.0, atol=1e-12)
    assert np.allclose(forces[:, 2], -0.3 * masses / masses.sum() * behind, rtol=1e-9)


def test_a_charged_screen_moves_the_tip_by_some_5_and_10_mm(setup: Setup, plain: Specimen) -> None:
    moves = []
    for size in (1, 2):
        drawn = TENTH_OUTSIDE['screen'](size, setup, np.random.default_rng(8))
        moves.append(max(tip_moves(setup, plain, Faults(**drawn.changes), plain.shares > 0.99)))
    assert 0.003 < moves[0] < 0.009
    assert 0.006 < moves[1] < 0.018


def test_a_coarse_unit_leaves_the_nearest_of_its_steps(depths: Depths) -> None:
    clean, told = depths(Faults(), 1), depths(Faults(coarse=10.0), 1)
    seen = np.isfinite(clean)
    assert np.array_equal(np.isfinite(told), seen)
    assert np.allclose(told[seen] / 0.01, np.round(told[seen] / 0.01), rtol=0.0, atol=1e-9)
    assert 0.004 < np.abs(told[seen] - clean[seen]).max() < 0.005 + 1e-12


def test_causes_of_the_sensor_leave_the_body_where_it_is(setup: Setup) -> None:
    faults = Faults(**TENTH_OUTSIDE['coarse'](2, setup, np.random.default_rng(8)).changes)
    assert np.array_equal(rest_of(setup, faults), rest_of(setup, Faults()))
