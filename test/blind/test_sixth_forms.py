# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms and causes of the sixth set do what their labels say."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from support.blind_rests import COARSE, rest_of

from benchmarks.blind.faults import Faults
from benchmarks.blind.hexahedra import mesh_hexahedra
from benchmarks.blind.observe import true_camera, true_rendering
from benchmarks.blind.paint import BETWEEN, PARTS, ROOT, TIP, tip_part
from benchmarks.blind.rest_shape import stress_free_nodes
from benchmarks.blind.setups import Setup
from benchmarks.blind.simulation import make_specimen, Specimen

BEND = (3.0, 4.0)
Depths = Callable[[Faults, int], np.ndarray]


@pytest.fixture(scope='module')
def depths(setup: Setup, plain: Specimen, rests: list[np.ndarray]) -> Depths:
    """What a camera reads at the samples that see something [m]."""

    def seen(faults: Faults, pose: int) -> np.ndarray:
        found = true_rendering(plain, setup, setup.observations[pose], faults, rests[pose]).depth
        return found[np.isfinite(found)]

    return seen


def _turns(setup: Setup, form: str) -> list[float]:
    """Return by how much thirds and halves of a body are bent when nothing pulls on it [rad]."""
    mesh = mesh_hexahedra(setup.shape)
    nodes = stress_free_nodes(
        mesh.nodes, setup.shape, Faults(rest_curvature=BEND, curvature_form=form)
    )
    free = setup.shape.length - setup.shape.clamp
    ahead = []
    for share in (0.02, 0.31, 0.5, 0.69, 0.98):
        near = np.abs(setup.shape.arc_share(mesh.lattice) - share)
        section = near < near.min() + 1e-9
        x = mesh.lattice[section][:, 1:]
        ways = np.column_stack([np.ones(len(x)), x])
        sides = np.linalg.lstsq(ways, nodes[section], rcond=None)[0][1:]
        ahead.append(np.cross(sides[0], sides[1]))
    axis = np.array([0.0, *BEND]) / np.linalg.norm(BEND)
    signed = [
        float(np.arcsin(np.clip(axis @ np.cross(one, other), -1.0, 1.0)))
        for one, other in pairwise(ahead)
    ]
    return [turn / (np.linalg.norm(BEND) * free) for turn in signed]


def test_an_s_bends_its_halves_in_opposite_ways(setup: Setup) -> None:
    turns = _turns(setup, 'S')
    # Twice as much in each half.
    assert turns[0] + turns[1] == pytest.approx(1.0, abs=0.12)
    assert turns[2] + turns[3] == pytest.approx(-1.0, abs=0.12)


def test_a_bent_middle_leaves_both_ends_straight(setup: Setup) -> None:
    turns = _turns(setup, 'middle')
    assert turns[1] + turns[2] == pytest.approx(1.0, abs=0.12)
    assert abs(turns[0]) < 0.1
    assert abs(turns[3]) < 0.1


def test_two_masses_hang_on_opposite_sides(setup: Setup) -> None:
    faults = Faults(added_mass=3.0, added_mass_at=0.8, mass_form='opposite')
    specimen = make_specimen(setup, faults, 1.0)
    assert specimen.added.sum() == pytest.approx(0.003, rel=1e-12)
    side = specimen.mesh.nodes[:, 1]
    outer = specimen.shares > 0.6
    assert specimen.added[outer] @ side[outer] > 0.0
    assert specimen.added[~outer] @ side[~outer] < 0.0
    assert 0.3 < specimen.added[outer].sum() / 0.003 < 0.7


def test_a_clamp_at_a_corner_lets_its_middle_move(setup: Setup) -> None:
    held = make_specimen(setup, Faults(), COARSE).mesh.held
    before = rest_of(setup, Faults())[held]
    moves = {
        form: (rest_of(setup, Faults(clamp_form=form, clamp_compliance=1.5))[held] - before)
        for form in ('turn', 'about a corner')
    }
    middle = {form: np.linalg.norm(move.mean(axis=0)) for form, move in moves.items()}
    assert middle['about a corner'] > 3.0 * middle['turn']
    lever = moves['about a corner'] - moves['about a corner'].mean(axis=0)
    assert np.linalg.norm(lever) > 0.1 * np.linalg.norm(moves['about a corner'])


def test_a_clamp_is_somewhere_else_in_each_pose(setup: Setup) -> None:
    scatter = tuple((0.1 * pose, 0.0, -0.2 * pose, 0.0, 0.0, 0.3 * pose) for pose in range(4))
    faults = Faults(clamp_shift=(1.0, 2.0, 3.0), clamp_scatter=scatter)
    specimen = make_specimen(setup, faults, COARSE)
    for pose in range(4):
        moved = rest_of(setup, faults, pose)[specimen.mesh.held]
        shift = moved.mean(axis=0) - specimen.mesh.nodes[specimen.mesh.held].mean(axis=0)
        expected = 1e-3 * np.array([1.0 + 0.1 * pose, 2.0, 3.0 - 0.2 * pose])
        assert np.allclose(shift, expected, atol=1e-5)


def test_a_changing_tilt_is_its_mean_of_all_poses(setup: Setup) -> None:
    shares = []
    for pose in range(4):
        clean = rest_of(setup, Faults(), pose)
        moves = [
            np.abs(rest_of(setup, Faults(gravity_tilt=(0.5, -0.4), tilt_form=form), pose) - clean)
            for form in ('changing', 'tilt')
        ]
        shares.append(moves[0].max() / moves[1].max())
    assert shares == pytest.approx([0.55, 0.85, 1.15, 1.45], rel=0.02)


def test_a_camera_drifts_from_pose_to_pose(setup: Setup, plain: Specimen, depths: Depths) -> None:
    faults = Faults(camera_drifts=True, camera_shift=(0.0, 0.0, 4.0))
    last = true_camera(plain, setup, faults, 1.0)
    assert last[2, 3] - setup.depth_from_world[2, 3] == pytest.approx(-0.004)
    for pose in (0, 3):
        found = [np.median(depths(each, pose)) for each in (faults, Faults())]
        assert found[1] - found[0] == pytest.approx(0.001 * (1 + pose), abs=2e-4)


def test_an_error_by_temperature_rises_and_falls_while_its_scale_grows(
    depths: Depths,
) -> None:
    for pose in (0, 1, 3):
        clean = depths(Faults(), pose)
        bias, scale = (
            depths(Faults(depth_form='temperature', **{key: 2.0}), pose) - clean
            for key in ('depth_bias', 'depth_scale')
        )
        expected = 0.002 * np.sin(np.pi * (pose + 0.5) / 4)
        assert np.allclose(bias, expected, atol=1e-12)
        assert np.allclose(scale, 0.02 * clean * pose / 3.0, atol=1e-12)


def test_a_wiggle_goes_with_the_sine_of_the_depth(depths: Depths) -> None:
    clean = depths(Faults(), 1)
    wiggle = Faults(wiggle=3.0, wiggle_period=50.0, wiggle_phase=0.4)
    found = depths(wiggle, 1) - clean
    assert np.allclose(found, 0.003 * np.sin(2.0 * np.pi * clean / 0.05 + 0.4), atol=1e-12)
    assert np.ptp(found) > 0.001


def test_a_gradual_step_comes_up_over_its_ramp(depths: Depths) -> None:
    clean = depths(Faults(), 0)
    sharp, ramp = (
        depths(Faults(region_bias=4.0, region_ramp=width), 0) - clean for width in (0.0, 0.15)
    )
    assert set(np.round(1e3 * sharp, 6)) == {0.0, 4.0}
    between = (ramp > 1e-4) & (ramp < 0.004 - 1e-4)
    assert 0.02 < between.mean() < 0.2
    assert len(set(np.round(1e3 * ramp[between], 6))) >= 3
    assert (np.abs(ramp - sharp) <= 0.0021).all()
    labels = np.array([-1, ROOT, TIP, BETWEEN + 5, BETWEEN + PARTS - 1])
    assert tip_part(labels).tolist() == [0.0, 0.0, 1.0, 0.25, 0.95]


def test_heat_bends_away_from_the_side_that_grows_and_differs_by_pose(setup: Setup) -> None:
    moves = []
    for pose in (0, 1):
        faults = Faults(heat=1.0, heat_shares=(1.0, 0.5, 0.3, 0.3))
        moves.append(rest_of(setup, faults, pose) - rest_of(setup, Faults(), pose))
    shares = make_specimen(setup, Faults(), COARSE).shares
    tips = [move[shares > 0.99].mean(axis=0) for move in moves]
    free = setup.shape.length - setup.shape.clamp
    # A strain of 1 % over the height is a curvature.
    expected = 0.01 / setup.shape.section[1] * free**2 / 2.0
    assert tips[0][2] == pytest.approx(-expected, rel=0.3)
    assert tips[1][2] == pytest.approx(0.5 * tips[0][2], rel=0.3)


def test_a_cone_and_a_torn_body_are_what_they_say(setup: Setup, plain: Specimen) -> None:
    cone = make_specimen(setup, Faults(cone=0.1), COARSE)
    tip = plain.shares > 0.99
    found = np.ptp(cone.mesh.nodes[tip], axis=0)[1:]
    assert found == pytest.approx(0.9 * np.ptp(plain.mesh.nodes[tip], axis=0)[1:])
    torn = make_specimen(setup, Faults(torn=0.4, torn_at=0.25), 1.0)
    whole = make_specimen(setup, Faults(), 1.0)
    softer = np.asarray(torn.body.numbers.shear / whole.body.numbers.shear)
    assert set(np.round(softer.ravel(), 9)) == {1.0, round(float(np.exp(-3.0)), 9)}
    points = softer < 0.5
    assert torn.heights[points].min() > 0.2
    nodes = torn.shares[torn.body.cells[points.any(axis=1)]]
    assert nodes.min() > 0.05
    assert nodes.max() < 0.45


def test_a_spot_is_stiffer_by_its_contrast_alone(setup: Setup) -> None:
    faults = Faults(contrast=0.8, contrast_mode='spot')
    spot, whole = (make_specimen(setup, each, 1.0) for each in (faults, Faults()))
    ratio = np.log(np.asarray(spot.body.numbers.shear / whole.body.numbers.shear))
    assert set(np.round(ratio.ravel(), 9)) == {0.0, 0.8}
    volumes = whole.body.quadrature.volumes
    free = volumes.sum() * (1.0 - setup.shape.clamp / setup.shape.length)
    assert volumes[ratio > 0.4].sum() / free == pytest.approx(0.2, abs=0.06)
