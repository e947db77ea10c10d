# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the twenty-seventh set that change what is seen do what their labels say."""

import numpy as np
import pytest
from support.blind_draws import draw_faults, draw_sealed, SEALED
from support.blind_rests import COARSE
from support.blind_views import region_errors, with_and_without

from benchmarks.blind.faults import Faults
from benchmarks.blind.observe import jostled, true_camera
from benchmarks.blind.paint import FIXTURE, Paint, tip_part
from benchmarks.blind.rotations import rotation
from benchmarks.blind.setups import Setup
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.speckle import netted
from benchmarks.blind.surface import body_triangles


def test_both_halves_of_an_imager_err_by_their_own_circuits(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    faults = draw_faults('depth_affine/two taps', setup)
    assert abs(faults.depth_bias) == pytest.approx(10.0, rel=0.16)
    for pose in (0, 2):
        view, right, there = with_and_without(plain, setup, faults, pose, rests[pose])
        _, columns, _ = np.nonzero(there)
        is_right = columns + right.column > setup.camera.cx + faults.depth_spot[0]
        errors = 1e3 * (view.depth[there] - right.depth[there])
        assert errors[is_right] == pytest.approx(faults.depth_bias, abs=1e-9)
        assert errors[~is_right] == pytest.approx(-faults.depth_back * faults.depth_bias, abs=1e-9)
        is_body = right.labels[there] != FIXTURE
        # A body is seen on both.
        assert 0.1 < is_right[is_body].mean() < 0.9


def test_a_net_has_threads_either_way_and_meshes_between() -> None:
    apart, cover = 0.02, 0.25
    # By the way from a knot to either side of both kinds of threads, across the other one's mesh.
    starts = np.array([0.001, 0.0049, 0.0051, 0.019])
    one, other = np.append(starts, np.full(4, 0.013)), np.append(np.full(4, 0.013), starts)
    places = np.column_stack([0.5 * (one + other), np.full(8, 7.0), 0.5 * (one - other)])
    one = netted(places, 1, apart, cover)
    assert one.tolist() == 2 * [True, True, False, False]
    # The other side has the same by the other place across.
    assert np.array_equal(netted(places[:, [0, 2, 1]], 2, apart, cover), one)
    places = np.random.default_rng(4).uniform(-1.0, 1.0, (40000, 3))
    for axis in range(3):
        covered = float(netted(places, axis, apart, cover).mean())
        assert covered == pytest.approx(1.0 - 0.75**2, abs=0.01)
    # As far on as its knots are apart it is the same.
    on = places + np.array([3 * apart, 0.0, 0.0])
    assert (netted(on, 1, apart, cover) == netted(places, 1, apart, cover)).mean() > 0.9999


def test_a_net_is_on_the_outer_part_of_a_body_alone(setup: Setup, plain: Specimen) -> None:
    painted = body_triangles(
        plain.mesh, plain.mesh.nodes, plain.shares, Paint(0.25, net=(0.016, 0.35))
    )
    middles = painted.corners.mean(axis=1)
    outer = (middles[:, 0] - setup.shape.clamp) / (setup.shape.length - setup.shape.clamp) > 0.25
    parts = tip_part(painted.labels)
    assert not parts[~outer].any()
    assert set(np.unique(parts)) == {0.0, 1.0}
    assert 0.45 < parts[outer].mean() < 0.7


def test_what_a_net_is_on_errs_below_its_threads_alone(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    faults = draw_faults('depth_bias_by_region/netted', setup)
    error = region_errors(plain, setup, faults, 2, rests[2])
    assert np.minimum(np.abs(error), np.abs(error - 1.0)).max() < 1e-6
    assert 0.25 < error.mean() < 0.7
    assert abs(faults.region_bias) == pytest.approx(12.0, rel=0.16)


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_mirror_turns_a_view_as_two_reflections_do(family: str) -> None:
    drawn = draw_sealed(family)
    faults = draw_faults('camera_offset/mirror', drawn)
    plain = make_specimen(drawn, Faults(), COARSE)
    assert faults.camera_foot is not None
    hinge, places = np.array(faults.camera_foot), np.random.default_rng(5).normal(size=(5, 3))
    angles = []
    for pose in range(4):
        turn = np.deg2rad(faults.camera_scatter[pose][3:])
        off = jostled(drawn, drawn.observations[pose], faults)
        found = true_camera(plain, drawn, off) @ np.linalg.inv(drawn.depth_from_world)
        # In the mirror as it was set, and back in one that was turned by half as much.
        seen = places
        for normal in (rotation(0.5 * turn)[:, 2], np.array([0.0, 0.0, 1.0])):
            seen = seen - 2.0 * np.outer((seen - hinge) @ normal, normal)
        assert places @ found[:3, :3].T + found[:3, 3] == pytest.approx(seen, abs=1e-12)
        assert turn[2] == 0.0
        angles.append(float(np.linalg.norm(turn)))
    # It creeps less and less.
    assert (np.diff(angles) > 0.0).all()
    assert (np.diff(angles, n=2) < 0.0).all()
    # What it turns lies behind the mirror, where the camera looks.
    way = np.linalg.norm(drawn.depth_from_world[:3, 3]) - hinge[2]
    assert angles[-1] * way == pytest.approx(0.010, rel=0.16)
