# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms and causes of the seventh set do what their labels say."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from support.blind_rests import COARSE, rest_of

from benchmarks.blind.faults import Faults
from benchmarks.blind.forms import BY_KEY
from benchmarks.blind.hexahedra import mesh_hexahedra
from benchmarks.blind.laying import lay_on_plane
from benchmarks.blind.observe import true_rendering
from benchmarks.blind.paint import ROOT, TIP
from benchmarks.blind.rest_shape import stress_free_nodes
from benchmarks.blind.rotations import applied
from benchmarks.blind.rubber import draw_rubber
from benchmarks.blind.setups import Setup
from benchmarks.blind.seventh_outside import SEVENTH_OUTSIDE
from benchmarks.blind.simulation import make_specimen, Specimen

Depths = Callable[[Faults, int], np.ndarray]


def test_a_knocked_camera_is_right_before_and_off_after(depths: Depths) -> None:
    off = Faults(camera_shift=(0.0, 0.0, 4.0))
    for pose in (1, 2):
        knocked = depths(replace(off, camera_from=2), pose)
        assert np.array_equal(knocked, depths(off if pose == 2 else Faults(), pose))


def test_a_clamp_slips_by_the_weight_across_the_body(setup: Setup, plain: Specimen) -> None:
    held = plain.mesh.held
    for pose, observation in enumerate(setup.observations):
        found = rest_of(setup, Faults(clamp_by_load=True, clamp_shift=(0.0, 5.0, 0.0)), pose)
        shift = (found - plain.mesh.nodes)[held].mean(axis=0)
        along = observation.world_from_object[1, 0]
        expected = 0.005 * (np.sqrt(1.0 - along**2) - 0.7) / 0.3
        assert shift == pytest.approx([0.0, max(expected, 0.0), 0.0], abs=1e-9)


def test_a_one_sided_clamp_gives_way_as_a_plain_one_or_not_at_all(
    setup: Setup, plain: Specimen
) -> None:
    held = plain.mesh.held
    moves = []
    # In the first pose the body turns its clamp about y, in the last one the other way.
    for pose in (0, 3):
        found = rest_of(setup, Faults(clamp_form='one-sided', clamp_compliance=1.5), pose)
        moves.append(np.abs((found - plain.mesh.nodes)[held][:, 2]).max())
    assert moves[0] > 3.0 * moves[1]
    other = Faults(clamp_form='one-sided', clamp_compliance=1.5, clamp_way=(-1.0, 1.0))
    assert np.abs((rest_of(setup, other) - plain.mesh.nodes)[held][:, 2]).max() < 0.2 * moves[0]


def test_a_helix_leaves_its_first_plane(setup: Setup) -> None:
    mesh = mesh_hexahedra(setup.shape)
    middle = np.abs(mesh.lattice[:, 1:]).max(axis=1) < 1e-9
    spans = {}
    for form in ('arc', 'helix'):
        faults = Faults(rest_curvature=(3.0, -4.0), curvature_form=form)
        bent = stress_free_nodes(mesh.nodes, setup.shape, faults)[middle]
        spans[form] = np.linalg.svd(bent - bent.mean(axis=0), compute_uv=False)
        lengths = np.linalg.norm(
            np.diff(bent[np.argsort(mesh.lattice[middle, 0])], axis=0), axis=1
        )
        assert lengths.sum() == pytest.approx(setup.shape.length, rel=1e-3)
    assert spans['arc'][2] < 1e-9
    assert spans['helix'][2] > 0.0005


def test_a_mass_on_an_arm_has_its_weight_and_its_place(setup: Setup) -> None:
    faults = Faults(added_mass=3.0, added_mass_at=0.7, mass_form='arm', mass_arm=(12.0, -16.0))
    specimen = make_specimen(setup, faults, 1.0)
    assert specimen.added.sum() == pytest.approx(0.003, rel=1e-9)
    place = specimen.added @ specimen.mesh.nodes / 0.003
    assert place[1:] == pytest.approx([0.012, -0.016], abs=1e-6)
    assert specimen.added @ specimen.shares / 0.003 == pytest.approx(0.7, abs=0.03)


def test_three_pours_have_two_steps(setup: Setup) -> None:
    faults = Faults(contrast=1.0, contrast_mode='three pours')
    ratio = (
        make_specimen(setup, faults).body.numbers.shear
        / make_specimen(setup, Faults()).body.numbers.shear
    )
    found = set(np.round(np.log(np.asarray(ratio)).ravel(), 9))
    assert found == {-0.5, 0.1, 0.5}


def test_an_error_by_incidence_is_least_where_the_ray_meets_the_surface_straight(
    setup: Setup, plain: Specimen, rests: list[np.ndarray], depths: Depths
) -> None:
    clean = true_rendering(plain, setup, setup.observations[0], Faults(), rests[0])
    seen = np.isfinite(clean.depth)
    assert (clean.facing[~seen] == 1.0).all()
    error = depths(Faults(depth_bias=2.0, depth_form='incidence'), 0)[seen] - clean.depth[seen]
    expected = 0.002 / np.maximum(clean.facing[seen], 1.0 / 3.0)
    assert np.allclose(error, expected, atol=1e-12)
    assert 0.002 <= error.min() < 0.0025
    assert np.ptp(error) > 0.001


def test_an_oblique_border_is_farther_out_where_y_is_positive(
    setup: Setup, plain: Specimen
) -> None:
    observation, shape, camera = setup.observations[1], setup.shape, setup.camera
    faults = Faults(region_bias=1.0, region_slant=0.2)
    oblique, clean = (
        true_rendering(plain, setup, observation, each, plain.mesh.nodes)
        for each in (faults, Faults())
    )
    is_body = (clean.labels == ROOT) | (clean.labels == TIP)
    rows, columns, _ = np.nonzero(is_body)
    z = clean.depth[is_body]
    x = (columns + clean.column - camera.cx) / camera.fx * z
    y = (rows + clean.row - camera.cy) / camera.fy * z
    from_camera = np.linalg.inv(setup.depth_from_world @ observation.world_from_object)
    places = applied(from_camera, np.stack([x, y, z], axis=-1))
    border = 0.5 + 0.2 * np.clip(places[:, 1] / (0.5 * shape.section[0]), -1.0, 1.0)
    beyond = shape.arc_share(places) - border
    is_sure = np.abs(beyond) > 0.05
    assert np.ptp(border) > 0.1
    assert np.array_equal((oblique.labels[is_body] == TIP)[is_sure], (beyond > 0.0)[is_sure])


def test_a_stop_of_the_rig_lifts_the_body_in_its_own_frame(setup: Setup) -> None:
    changes = BY_KEY['contact_plane/rig'].draw(2, setup, np.random.default_rng(8))
    laid, faults = lay_on_plane(setup, Faults(**changes), np.random.default_rng(1))
    assert laid.observations == setup.observations
    normal, free = np.array(faults.contact_normal), replace(faults, contact_height=None)
    lifted = []
    for pose in range(4):
        found, before = (rest_of(laid, each, pose) for each in (faults, free))
        assert faults.contact_height is not None
        assert (found @ normal).min() > faults.contact_height - 1e-4
        lifted.append(1e3 * np.abs(found - before).max())
    assert lifted[0] > 0.7 * changes['contact_height']
    assert lifted[3] < 1e-6, 'it hangs the other way'


def test_a_push_on_the_middle_leaves_the_rest_alone(setup: Setup) -> None:
    specimen = make_specimen(setup, Faults(), COARSE)
    for pose in (0, 1):
        tilted, pushed = (
            rest_of(setup, Faults(gravity_tilt=(0.5, -0.4), tilt_form=form), pose)
            for form in ('tilt', 'middle_push')
        )
        clean = rest_of(setup, Faults(), pose)
        free = specimen.shares > 0.0
        one, other = (tilted - clean)[free].ravel(), (pushed - clean)[free].ravel()
        assert 0.9 < one @ other / (np.linalg.norm(one) * np.linalg.norm(other)) < 1.0 - 1e-6


@pytest.mark.parametrize('name', ['hollow', 'jet', 'warming'])
def test_a_cause_outside_moves_the_body(setup: Setup, rests: list[np.ndarray], name: str) -> None:
    faults = Faults(**SEVENTH_OUTSIDE[name](2, setup, np.random.default_rng(8)).changes)
    moves = [np.abs(rest_of(setup, faults, pose) - rests[pose]).max() for pose in range(4)]
    assert 0.002 < max(moves) < 0.03
    # What warms up has not yet when it is first seen.
    assert (moves[0] < 1e-9) == (name == 'warming')


def test_stripes_go_with_the_column(setup: Setup, depths: Depths) -> None:
    faults = Faults(stripes=3.0, stripes_period=40.0, stripes_phase=0.3)
    clean = depths(Faults(), 1)
    seen = np.isfinite(clean)
    error = depths(faults, 1)[seen] - clean[seen]
    assert np.ptp(error) > 0.004
    columns = np.nonzero(seen)[1]
    for column in np.unique(columns)[::20]:
        assert np.ptp(error[columns == column]) < 1e-12
    assert set(np.round(error[columns == 20], 9)) == set(np.round(error[columns == 60], 9))


def test_a_cavity_takes_mass_and_stiffness_from_the_upper_half(setup: Setup) -> None:
    faults = Faults(hollow=0.3, hollow_at=0.3)
    hollow, whole = (make_specimen(setup, each, 1.0) for each in (faults, Faults()))
    softer = np.asarray(hollow.body.numbers.shear / whole.body.numbers.shear) < 0.5
    assert softer.any()
    assert hollow.heights[softer].min() > 0.0
    lost = 1.0 - hollow.body.masses.sum() / whole.body.masses.sum()
    volumes = whole.body.quadrature.volumes
    assert lost == pytest.approx(volumes[softer].sum() / volumes.sum(), rel=1e-9)
    nodes = hollow.shares[hollow.body.cells[softer.any(axis=1)]]
    assert 0.05 < nodes.min() < nodes.max() < 0.55


@pytest.mark.parametrize('law', ['plain', 'fibres', 'mooney'])
def test_a_warm_body_of_any_law_rests_as_a_softer_one(setup: Setup, law: str) -> None:
    rubber = draw_rubber(law, np.random.default_rng(3))
    world = replace(setup, rubber=rubber)
    soft = replace(world, youngs_modulus=world.youngs_modulus * np.exp(-0.4))
    warm = rest_of(world, Faults(warming=0.4), 3)
    assert np.abs(warm - rest_of(soft, Faults(), 3)).max() < 1e-8
