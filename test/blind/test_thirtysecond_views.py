# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the thirty-second set that change what is seen do what their labels say."""

import numpy as np
import pytest
from support.blind_draws import draw_faults, draw_sealed, SEALED
from support.blind_rests import COARSE
from support.blind_views import region_errors, with_and_without

from benchmarks.blind.breath import dried_reach
from benchmarks.blind.faults import Faults
from benchmarks.blind.network import beside_middle, laid_along
from benchmarks.blind.observe import jostled, true_camera, true_rendering
from benchmarks.blind.paint import FIXTURE, Paint, ROOT, TIP
from benchmarks.blind.setups import Setup
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.speckle import speckled
from benchmarks.blind.surface import body_triangles
from benchmarks.blind.wiping import BLUR, wiped_share


def test_breath_loses_as_much_of_its_area_from_pose_to_pose() -> None:
    areas = np.pi * dried_reach(5, 6.0) ** 2
    assert areas[0] == pytest.approx(np.pi)
    assert np.diff(areas) == pytest.approx(-np.pi / 6.0)


@pytest.mark.parametrize(('size', 'most'), [(1, 4.0), (2, 10.0)])
def test_breath_errs_as_far_as_it_has_not_dried(
    setup: Setup, plain: Specimen, rests: list[np.ndarray], size: int, most: float
) -> None:
    faults, parts = draw_faults('depth_affine/breath', setup, size), []
    assert abs(faults.depth_bias) == pytest.approx(most, rel=0.16)
    assert (np.diff(faults.depth_places) < 0.0).all()
    for pose in range(4):
        view, right, there = with_and_without(plain, setup, faults, pose, rests[pose])
        rows, columns, _ = np.nonzero(there)
        ways = columns + right.column - setup.camera.cx - faults.depth_spot[0] + 0j
        ways += 1j * (rows + right.row - setup.camera.cy - faults.depth_spot[1])
        within = (faults.depth_places[pose] - np.abs(ways)) / BLUR
        errors = 1e3 * (view.depth[there] - right.depth[there])
        expected = faults.depth_bias / (1.0 + np.exp(-2.0 * np.clip(within, -300.0, 300.0)))
        assert errors == pytest.approx(expected, abs=1e-6)
        parts.append((within[right.labels[there] != FIXTURE] > 0.0).mean())
    assert parts[0] > 0.5
    assert 0.05 < parts[3] < parts[0]


def test_a_coat_flakes_off_the_more_the_nearer_it_is_to_the_clamp(setup: Setup) -> None:
    plain = make_specimen(setup, Faults())
    kept = []
    for seed in range(12):
        paint = Paint(0.1, flakes=(0.006, seed))
        painted = body_triangles(plain.mesh, plain.mesh.nodes, plain.shares, paint)
        assert set(painted.labels) <= {ROOT, TIP}
        kept.append(painted.labels == TIP)
    ahead = painted.corners.mean(axis=1)[:, 0] - setup.shape.clamp
    share = ahead / (setup.shape.length - setup.shape.clamp)
    assert not np.array(kept)[:, share < 0.09].any()
    # On the mean of many coats it is there evenly more often to the tip.
    for at in (0.3, 0.5, 0.7, 0.9):
        here = np.abs(share - at) < 0.05
        assert np.array(kept)[:, here].mean() == pytest.approx((at - 0.1) / 0.9, abs=0.1)


@pytest.mark.parametrize(('size', 'most'), [(1, 5.0), (2, 12.0)])
def test_what_flakes_errs_where_it_is_left(
    setup: Setup, plain: Specimen, rests: list[np.ndarray], size: int, most: float
) -> None:
    faults = draw_faults('depth_bias_by_region/flaking', setup, size)
    assert abs(faults.region_bias) == pytest.approx(most, rel=0.16)
    for pose in range(4):
        errors = region_errors(plain, setup, faults, pose, rests[pose])
        is_off = errors > 0.5
        assert errors == pytest.approx(is_off.astype(float), abs=1e-9)
        assert 0.2 < is_off.mean() < 0.75


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_post_leans_from_the_sun_which_goes_round_it(family: str) -> None:
    drawn = draw_sealed(family)
    plain, stored = make_specimen(drawn, Faults(), COARSE), drawn.depth_from_world
    standing = -stored[:3, :3].T @ stored[:3, 3]
    for size, most in ((1, 0.004), (2, 0.010)):
        faults, ways, seen = draw_faults('camera_offset/sunlit post', drawn, size), [], []
        for pose in range(4):
            off = jostled(drawn, drawn.observations[pose], faults)
            moved = np.linalg.inv(true_camera(plain, drawn, off)) @ stored
            skew = 0.5 * (moved[:3, :3] - moved[:3, :3].T)
            turn = np.array([skew[2, 1], skew[0, 2], skew[1, 0]])
            shift = moved[:3, :3] @ standing + moved[:3, 3] - standing
            # It leans to where it goes, and as an arc does: by half its turn times its height.
            assert abs(turn[1]) < 1e-5
            aside = np.cross(turn, [0.0, 1.0, 0.0])
            half = float(shift @ aside / (aside @ aside))
            assert 0.14 < half < 0.26
            assert shift == pytest.approx(half * aside, abs=2e-4)
            ways.append(turn)
            seen.append(float(np.linalg.norm(moved[:3, 3])))
        # It warms up less and less, and the sun goes on as far each time.
        sizes = np.linalg.norm(ways, axis=1)
        assert (np.diff(sizes) > 0.0).all()
        assert (np.diff(sizes, 2) < 1e-6).all()
        angles = np.unwrap([np.arctan2(way[2], way[0]) for way in ways])
        goes = np.rad2deg(np.diff(angles))
        assert goes == pytest.approx(goes.mean(), abs=0.6)
        assert 14.0 < abs(goes.mean()) < 36.0
        # What is at the world's origin, where bodies are.
        assert max(seen) == pytest.approx(most, rel=0.17)


def test_what_earlier_sets_share_with_this_one_is_as_it_was(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    # Dots are where a draw of their cube alone is low enough.
    points = np.random.default_rng(3).uniform(0.0, 0.05, (50, 3))
    x, y, z = np.floor(points / 0.007).astype(int).T
    drawn = np.random.default_rng(11).random((64, 64, 64))[x, y, z] < 0.6
    assert np.array_equal(speckled(points, 0.007, 0.6, 11), drawn)
    # A wiper reaches as far as its faults say.
    view = true_rendering(plain, setup, setup.observations[0], Faults(), rests[0])
    told = Faults(depth_form='wiped', depth_spot=(9.0, -7.0), depth_width=60.0)
    assert np.array_equal(
        wiped_share(view, setup, told),
        wiped_share(view, setup, Faults(depth_spot=(9.0, -7.0)), 60.0),
    )
    # Leads lie where they did.
    across = np.random.default_rng(5).uniform(-1.2, 1.2, (40, 2, 8))
    leads = Faults(stiffening_form='leads')
    assert np.array_equal(laid_along(across, leads), beside_middle(across))
