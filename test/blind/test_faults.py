# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Each fault does what its label says; amplitude 0 does nothing, bit for bit."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.blind.faults import Faults
from benchmarks.blind.observe import true_camera, true_rendering
from benchmarks.blind.rotations import applied, rotation
from benchmarks.blind.setups import draw_setup, Observation, Setup
from benchmarks.blind.simulation import make_specimen, settle, Specimen

COARSE = 0.5  # Faults are checked against statics, not against a converged shape.


@pytest.fixture(scope='module')
def setup() -> Setup:
    return draw_setup('beam', is_sealed=False, poses=4, random=np.random.default_rng(4))


@pytest.fixture(scope='module')
def clean(setup: Setup) -> np.ndarray:
    return _rest(setup, Faults())[1]


def _rest(setup: Setup, faults: Faults, pose: int = 0) -> tuple[Specimen, np.ndarray]:
    specimen = make_specimen(setup, faults, COARSE)
    return specimen, settle(specimen, setup, setup.observations[pose], faults)


def _weightless(setup: Setup) -> Setup:
    return replace(setup, density=1e-9)


@pytest.mark.parametrize(
    'nothing',
    [
        {'added_mass_at': 0.7},
        {'contact_height': -10.0, 'contact_normal': (0.1, 0.9, 0.0)},
        {'contrast_mode': 'linear'},
    ],
    ids=lambda changes: next(iter(changes)),
)
def test_amplitude_zero_is_clean_bit_for_bit(
    setup: Setup, clean: np.ndarray, nothing: dict[str, object]
) -> None:
    faults = Faults(**nothing)  # type: ignore[arg-type]
    specimen, rest = _rest(setup, faults)
    assert np.array_equal(rest, clean)
    views = [
        true_rendering(specimen, setup, setup.observations[0], each, rest).depth
        for each in (faults, Faults())
    ]
    assert np.array_equal(*views)


def test_tilted_gravity_is_a_turned_rig(setup: Setup) -> None:
    angles = (12.0, -7.0)
    _, tilted = _rest(setup, Faults(gravity_tilt=angles))
    turn = rotation(np.deg2rad([angles[0], 0.0, angles[1]]))
    pose = setup.observations[0].world_from_object.copy()
    pose[:3, :3] = turn.T @ pose[:3, :3]
    turned = replace(setup, observations=(Observation('turned', pose),))
    # The same forces: only rounding in the product of the rotations differs.
    assert np.abs(tilted - _rest(turned, Faults())[1]).max() < 1e-9


def test_added_mass_has_its_weight_and_place(setup: Setup) -> None:
    faults = Faults(added_mass=3.0, added_mass_at=0.7)
    specimen = make_specimen(setup, faults, 1.0)
    assert specimen.added.sum() == pytest.approx(0.003, rel=1e-12)
    # Spread over elements of some millimetres.
    assert specimen.added @ specimen.shares / 0.003 == pytest.approx(0.7, abs=0.03)


def test_clamp_offset_moves_a_weightless_body_as_a_whole(setup: Setup) -> None:
    faults = Faults(clamp_shift=(1.0, -2.0, 3.0), clamp_turn=(2.0, 5.0, -4.0))
    specimen, rest = _rest(_weightless(setup), faults)
    center = specimen.center
    turned = (specimen.mesh.nodes - center) @ rotation(np.deg2rad([2.0, 5.0, -4.0])).T
    assert np.abs(rest - (turned + center + [0.001, -0.002, 0.003])).max() < 1e-9


def test_compliant_clamp_turns_by_compliance_times_moment(setup: Setup) -> None:
    compliance = 1.5
    specimen, rest = _rest(setup, Faults(clamp_compliance=compliance))
    masses, held = specimen.body.masses, specimen.body.held
    gravity = setup.observations[0].world_from_object[:3, :3].T @ [0.0, -9.81, 0.0]
    # Everything that is not borne by the clamp is borne by nothing.
    moment = np.cross(rest - specimen.center, masses[:, None] * gravity).sum(axis=0)
    turned = rotation(compliance * moment)
    expected = (specimen.mesh.nodes[held] - specimen.center) @ turned.T + specimen.center
    assert np.linalg.norm(compliance * moment) > np.deg2rad(1.0)
    assert np.abs(rest[held] - expected).max() < 1e-6


def test_rest_curvature_is_the_arc_of_a_weightless_body(setup: Setup) -> None:
    curvature = (3.0, -4.0)
    specimen, rest = _rest(_weightless(setup), Faults(rest_curvature=curvature))
    length = setup.shape.length - setup.shape.clamp
    tip = specimen.mesh.lattice[:, 0] > setup.shape.length - 1e-9
    angle = 5.0 * length
    # Turned about (0, 3, -4) / 5: the centre line leaves x towards (0, -4, -3) / 5.
    side = np.array([0.0, -0.8, -0.6])
    expected = np.array([setup.shape.clamp + np.sin(angle) / 5.0, 0.0, 0.0])
    expected = expected + (1.0 - np.cos(angle)) / 5.0 * side
    middle = np.abs(specimen.mesh.lattice[:, 1:]).max(axis=1) < 1e-9
    assert np.abs(rest[tip & middle] - expected).max() < 1e-6


def test_swelling_lengthens_half_the_body(setup: Setup) -> None:
    specimen, rest = _rest(_weightless(setup), Faults(swelling=4.0))
    length = setup.shape.length - setup.shape.clamp
    tip = specimen.mesh.lattice[:, 0] > setup.shape.length - 1e-9
    growth = (rest - specimen.mesh.nodes)[tip, 0].mean()
    # Whole elements swell, and where they end the two halves hinder each other.
    assert growth == pytest.approx(0.5 * length * 0.04, rel=0.25)


def test_plane_bears_the_body_with_hardly_a_dent(setup: Setup, clean: np.ndarray) -> None:
    pose = setup.observations[0].world_from_object
    height = float(applied(pose, clean)[:, 1].min()) + 0.005
    _, rest = _rest(setup, Faults(contact_height=height))
    dent = height - float(applied(pose, rest)[:, 1].min())
    assert 0.0 < dent < 5e-5
    assert np.abs(rest - clean).max() > 0.004


def test_contrast_stiffens_the_named_end(setup: Setup, clean: np.ndarray) -> None:
    _, stiff_tip = _rest(setup, Faults(contrast=1.0))
    _, stiff_root = _rest(setup, Faults(contrast=-1.0))
    specimen = make_specimen(setup, Faults(), COARSE)
    sags = [np.abs(rest - specimen.mesh.nodes).max() for rest in (stiff_root, clean, stiff_tip)]
    # Bending happens at the root.
    assert sags[0] < sags[1] < sags[2]


def test_stiffening_bears_more(setup: Setup, clean: np.ndarray) -> None:
    specimen, rest = _rest(setup, Faults(yeoh_ratio=30.0))
    nodes = specimen.mesh.nodes
    assert np.abs(rest - nodes).max() < 0.99 * np.abs(clean - nodes).max()


def test_camera_that_stands_nearer_sees_less_depth(setup: Setup) -> None:
    specimen = make_specimen(setup, Faults(), COARSE)
    observation = setup.observations[0]
    shift, turn = (1.0, -2.0, 4.0), (3.0, -2.0, 5.0)
    nodes = applied(observation.world_from_object, specimen.mesh.nodes)
    stored = applied(setup.depth_from_world, nodes)
    true = applied(
        true_camera(specimen, setup, Faults(camera_shift=shift, camera_turn=turn)),
        nodes,
    )
    center = applied(setup.depth_from_world, 0.5 * (nodes.min(axis=0) + nodes.max(axis=0)))
    # From the true camera's frame back to the stored one's: turn about the centre, then shift.
    back = (true - center) @ rotation(np.deg2rad(turn)).T + center + 1e-3 * np.array(shift)
    assert np.abs(back - stored).max() < 1e-12
    nearer = applied(true_camera(specimen, setup, Faults(camera_shift=(0.0, 0.0, 4.0))), nodes)
    assert np.allclose(nearer[:, 2] - stored[:, 2], -0.004, atol=1e-12)


def test_depth_faults_change_depth_alone(setup: Setup, clean: np.ndarray) -> None:
    specimen = make_specimen(setup, Faults(), COARSE)
    observation = setup.observations[0]
    plain, affine, biased = (
        true_rendering(specimen, setup, observation, faults, clean)
        for faults in (
            Faults(),
            Faults(depth_scale=2.0, depth_bias=-3.0),
            Faults(region_bias=1.5),
        )
    )
    hit = np.isfinite(plain.depth)
    assert np.allclose(affine.depth[hit], 1.02 * plain.depth[hit] - 0.003, atol=1e-15)
    moved = biased.depth[hit] - plain.depth[hit]
    assert np.allclose(moved, 0.0015 * (plain.labels[hit] == 1), atol=1e-15)
    assert 0 < (plain.labels[hit] == 1).sum() < hit.sum()
