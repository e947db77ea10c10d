# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms and causes of the eleventh set do what their labels say."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from support.blind_derivatives import check_body_stiffness, check_derivatives
from support.blind_rests import rest_of

from benchmarks.blind.contact import contact_laws
from benchmarks.blind.eleventh_outside import ELEVENTH_OUTSIDE
from benchmarks.blind.faults import Faults
from benchmarks.blind.forms import BY_KEY
from benchmarks.blind.groove import groove_tops
from benchmarks.blind.hexahedra import mesh_hexahedra
from benchmarks.blind.laying import lay_on_plane
from benchmarks.blind.loose import ring_masses, ring_place
from benchmarks.blind.material import constants, softened
from benchmarks.blind.network import AXES, reinforced
from benchmarks.blind.observe import jostled, true_rendering
from benchmarks.blind.paint import FIXTURE, ROOT
from benchmarks.blind.rest_shape import stress_free_nodes, true_shape
from benchmarks.blind.rotations import applied, rotation
from benchmarks.blind.setups import Setup
from benchmarks.blind.simulation import make_specimen, Specimen

Depths = Callable[[Faults, int], np.ndarray]
STIFF = Faults(stiffening_form='recruited', stiffening=3.0, stiffening_from=0.02)


def test_a_network_is_alike_in_all_directions_and_stiffens_by_its_share() -> None:
    fourth = np.einsum('ni,nj,nk,nl->ijkl', AXES, AXES, AXES, AXES)
    one = np.eye(3)
    alike = sum(
        np.einsum(term, one, one) for term in ('ij,kl->ijkl', 'ik,jl->ijkl', 'il,jk->ijkl')
    )
    assert np.allclose(fourth, len(AXES) / 15.0 * alike, rtol=0.0, atol=1e-12)
    plain = constants(np.array(2e5), 0.48)
    numbers = reinforced(plain, np.array(2e5), replace(STIFF, stiffening_from=1e-9))
    # Drawn in one direction alone, straight fibres resist by their share of E.
    drawn = np.diag([1.0 + 1e-5, 1.0, 1.0])
    stress = sum(each.stress(drawn)[0, 0] for each in numbers.network)
    assert stress == pytest.approx(3.0 * 2e5 * 1e-5, rel=1e-3)
    pressed = np.diag([1.0 - 1e-2, 1.0 - 1e-2, 1.0 - 1e-2])
    assert not any(each.stress(pressed).any() for each in numbers.network)
    assert reinforced(plain, np.array(2e5), replace(STIFF, stiffening=0.0)) == plain


def test_fibres_in_waves_do_nothing_at_rest_and_pull_by_their_energy() -> None:
    numbers = reinforced(constants(np.array(2e5), 0.48), np.array(2e5), STIFF)
    slight = np.diag([1.0 + 1e-6, 1.0, 1.0])
    assert sum(abs(each.stress(slight)[0, 0]) for each in numbers.network) < 1e-3 * 2e5 * 1e-6
    random = np.random.default_rng(1)
    F = np.eye(3) + random.uniform(-0.05, 0.08, (3, 3))
    move, h = random.standard_normal((3, 3)), 1e-6
    for fibres in numbers.network:
        one, other = (fibres.energy(F + way * h * move) for way in (1.0, -1.0))
        slope = float((fibres.stress(F) * move).sum())
        assert (one - other) / (2.0 * h) == pytest.approx(slope, rel=1e-5, abs=1e-3)
    halved = softened(numbers, 0.5).network
    assert [each.stiffness for each in halved] == [
        0.5 * each.stiffness for each in numbers.network
    ]


def test_a_body_with_a_network_is_stiff_by_the_slopes_of_its_forces(setup: Setup) -> None:
    specimen = make_specimen(setup, STIFF, 0.5)
    check_body_stiffness(specimen.body, specimen.mesh.nodes)


def test_a_network_stiffens_a_body_the_more_it_bends(setup: Setup, plain: Specimen) -> None:
    tip = plain.shares > 0.99
    ratios = []
    for factor in (1.0, 0.3):
        soft = replace(setup, youngs_modulus=factor * setup.youngs_modulus)
        sags = [
            np.linalg.norm((rest_of(soft, faults) - plain.mesh.nodes)[tip].mean(axis=0))
            for faults in (STIFF, Faults())
        ]
        ratios.append(sags[0] / sags[1])
    assert ratios[1] < ratios[0] < 0.99
    assert ratios[1] < 0.9


def test_a_slanted_border_is_farther_out_on_the_upper_side(setup: Setup) -> None:
    faults = Faults(contrast=1.2, contrast_mode='slanted', contrast_at=0.4, contrast_slant=0.17)
    slanted, whole = (make_specimen(setup, each, 1.0) for each in (faults, Faults()))
    stiffer = np.log(np.asarray(slanted.body.numbers.shear / whole.body.numbers.shear))
    values = whole.body.quadrature.values
    share = whole.shares[whole.mesh.cells] @ values.T
    expected = np.where(share > 0.4 + 0.17 * whole.heights, 0.6, -0.6)
    assert np.allclose(stiffer, expected, rtol=0.0, atol=1e-12)
    border = np.abs(share - 0.4) < 0.05
    assert set(np.sign(stiffer[border & (whole.heights > 0.3)])) == {-1.0}
    assert set(np.sign(stiffer[border & (whole.heights < -0.3)])) == {1.0}


def test_a_loose_ring_slides_out_where_a_body_hangs_and_in_where_it_rises(
    setup: Setup, plain: Specimen
) -> None:
    faults = Faults(mass_form='loose', added_mass=8.0, added_mass_at=0.6, mass_stops=(0.2, 0.75))
    places = [ring_place(setup, one, faults) for one in setup.observations]
    assert places == [0.6, 0.6, 0.75, 0.2]
    masses, shares = plain.body.masses, plain.shares
    for observation, place in zip(setup.observations, places, strict=True):
        added = ring_masses(masses, shares, setup, observation, faults)
        assert added.sum() == pytest.approx(0.008)
        assert added @ shares / added.sum() == pytest.approx(place, abs=0.02)


def test_gloss_errs_by_the_cosine_to_its_power_on_the_outer_part_alone(
    setup: Setup, plain: Specimen, rests: list[np.ndarray], depths: Depths
) -> None:
    view = true_rendering(plain, setup, setup.observations[1], Faults(), rests[1])
    seen = np.isfinite(view.depth)
    wrong = depths(Faults(region_bias=6.0, region_gloss=3.0), 1)
    error = (wrong[seen] - view.depth[seen]) / 0.006
    inner = np.isin(view.labels[seen], (ROOT, FIXTURE))
    assert not error[inner].any()
    expected = view.facing[seen][~inner] ** 3
    assert np.allclose(error[~inner], expected, rtol=0.0, atol=1e-9)
    assert np.ptp(expected) > 0.1


def test_a_tripod_walks_from_pose_to_pose_on_its_floor(setup: Setup) -> None:
    changes = BY_KEY['camera_offset/jostled'].draw(2, setup, np.random.default_rng(8))
    walked = np.array(changes['camera_scatter'])
    assert walked.shape == (len(setup.observations), 6)
    assert not walked[:, [1, 3, 5]].any()
    steps = np.diff(walked, axis=0, prepend=0.0)
    assert np.all(np.linalg.norm(steps[:, :3], axis=1) > 3.0)
    faults = Faults(camera_shift=(1.0, 2.0, 3.0), **changes)
    last = jostled(setup, setup.observations[-1], faults)
    assert np.allclose(last.camera_shift, np.array([1.0, 2.0, 3.0]) + walked[-1, :3])
    assert np.allclose(last.camera_turn, walked[-1, 3:])


def test_a_jostled_camera_is_a_wrong_one_in_each_pose(setup: Setup, depths: Depths) -> None:
    changes = BY_KEY['camera_offset/jostled'].draw(2, setup, np.random.default_rng(8))
    for pose, one in enumerate(changes['camera_scatter']):
        steady = Faults(camera_shift=one[:3], camera_turn=one[3:])
        assert np.array_equal(depths(Faults(**changes), pose), depths(steady, pose))


def test_a_coil_bends_more_towards_the_tip_which_moves_as_an_arcs(setup: Setup) -> None:
    mesh = mesh_hexahedra(setup.shape)
    bent = stress_free_nodes(
        mesh.nodes, setup.shape, Faults(curvature_form='coiled', rest_curvature=(0.0, 1.5))
    )
    share = setup.shape.arc_share(mesh.lattice)
    free = setup.shape.length - setup.shape.clamp
    move = (bent - mesh.nodes)[share > 0.999, 1].mean()
    assert move == pytest.approx(0.75 * free**2, rel=0.02)
    places = np.unique(share[share > 0.0])
    middles = np.array([bent[np.abs(share - place) < 1e-9].mean(axis=0) for place in places])
    slopes = np.arctan(np.diff(middles[:, 1]) / np.diff(middles[:, 0]))
    between = 0.5 * (places[1:] + places[:-1])
    rates = np.diff(slopes) / np.diff(between)
    at = places[1:-1]
    assert rates[at > 0.85].mean() > 2.0 * rates[at < 0.2].mean() > 0.0


@pytest.fixture(scope='module')
def in_a_groove(setup: Setup) -> tuple[Setup, Faults]:
    """A set-up whose body lies in a groove in the first pose, and that groove."""
    changes = BY_KEY['contact_plane/vee'].draw(2, setup, np.random.default_rng(8))
    return lay_on_plane(setup, Faults(**changes), np.random.default_rng(1))


def test_a_groove_bears_the_body_on_its_flanks(in_a_groove: tuple[Setup, Faults]) -> None:
    laid, faults = in_a_groove
    free = replace(faults, contact_height=None)
    found, hanging = rest_of(laid, faults), rest_of(laid, free)
    world = [applied(laid.observations[0].world_from_object, each) for each in (found, hanging)]
    assert faults.contact_height is not None
    lowest = groove_tops(world[0], faults.contact_at).min()
    assert -1e-4 < lowest - faults.contact_height < 0.0
    assert 0.004 < (world[0] - world[1])[:, 1].max() < 0.02
    assert np.array_equal(rest_of(laid, faults, 1), rest_of(laid, free, 1))


def test_a_groove_pushes_by_its_energy_from_both_flanks(
    in_a_groove: tuple[Setup, Faults], plain: Specimen
) -> None:
    laid, faults = in_a_groove
    deep = replace(faults, contact_height=1.0)
    (law,) = contact_laws(plain.areas, plain.shares, laid.observations[0], deep)
    check_derivatives(law, plain.mesh.nodes)
    matrix = laid.observations[0].world_from_object
    bottom = applied(np.linalg.inv(matrix), np.array([[0.0, 1.0, faults.contact_at]]))
    lower = np.tile(bottom - 0.01 * matrix[1, :3], (len(plain.areas), 1))
    pushes = -law(lower).gradient[plain.areas > 0.0] @ matrix[:3, :3].T
    assert np.all(pushes[:, 1] > 0.0)
    assert np.allclose(pushes[:, [0, 2]], 0.0, rtol=0.0, atol=1e-9 * pushes[:, 1].max())


def test_a_tilt_on_castors_turns_from_pose_to_pose(setup: Setup) -> None:
    faults = Faults(tilt_form='castors', gravity_tilt=(8.0, -5.0), tilt_turn=40.0)
    for pose in (0, 2):
        x, _, z = rotation(np.array([0.0, np.deg2rad(40.0 * pose), 0.0])) @ [8.0, 0.0, -5.0]
        steady = Faults(gravity_tilt=(float(x), float(z)))
        apart = rest_of(setup, faults, pose) - rest_of(setup, steady, pose)
        assert np.abs(apart).max() < 1e-7


def test_a_racked_body_is_shifted_over_its_height_beyond_the_clamp(setup: Setup) -> None:
    racked = mesh_hexahedra(true_shape(setup.shape, Faults(racked=0.3)))
    whole = mesh_hexahedra(setup.shape)
    apart = racked.nodes - whole.nodes
    assert not apart[:, [0, 2]].any()
    assert not apart[whole.held].any()
    outer = setup.shape.arc_share(whole.lattice) > 0.15
    assert np.allclose(apart[outer, 1], 0.3 * whole.nodes[outer, 2], rtol=0.0, atol=1e-12)


def test_depths_jump_beyond_one_alone(depths: Depths) -> None:
    clean = depths(Faults(), 1)
    seen = np.isfinite(clean)
    begin = float(np.median(clean[seen]))
    error = depths(Faults(jump=7.0, jump_from=begin), 1)[seen] - clean[seen]
    expected = np.where(clean[seen] > begin, 0.007, 0.0)
    assert np.allclose(error, expected, rtol=0.0, atol=1e-12)


def test_a_jump_is_amid_the_body_in_some_pose(setup: Setup, depths: Depths) -> None:
    for seed in range(6):
        drawn = ELEVENTH_OUTSIDE['jump'](2, setup, np.random.default_rng(seed))
        beyond = [
            float(np.mean(clean[np.isfinite(clean)] > drawn.changes['jump_from']))
            for clean in (depths(Faults(), pose) for pose in range(4))
        ]
        assert any(0.05 < share < 0.95 for share in beyond)


def test_causes_of_the_sensor_leave_the_body_where_it_is(setup: Setup) -> None:
    faults = Faults(**ELEVENTH_OUTSIDE['jump'](2, setup, np.random.default_rng(8)).changes)
    assert np.array_equal(rest_of(setup, faults), rest_of(setup, Faults()))
