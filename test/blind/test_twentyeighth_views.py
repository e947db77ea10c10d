# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the twenty-eighth set that change what is seen do what their labels say."""

import numpy as np
import pytest
from support.blind_draws import draw_faults, draw_sealed, SEALED
from support.blind_rests import COARSE
from support.blind_views import region_errors, spread_of_what_stays, with_and_without

from benchmarks.blind.faults import Faults
from benchmarks.blind.observe import jostled, true_camera
from benchmarks.blind.paint import FIXTURE, Paint, tip_part
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.setups import Setup
from benchmarks.blind.shifted_bar import shifted_share
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.surface import body_triangles


def test_a_shifted_bar_bends_like_a_beam_whose_ends_are_held_level(setup: Setup) -> None:
    faults = Faults(depth_spot=(20.0, -10.0), depth_slant=30.0, depth_width=120.0)
    column, row = round(setup.camera.cx) - 160, round(setup.camera.cy) - 160
    depth = np.full((320, 320, 9), 0.3)
    view = Rendering(column, row, depth, np.ones(depth.shape, dtype=np.int64), depth)
    found = shifted_share(view, setup, faults)
    assert found.shape == (320, 320, 1)
    # The cubic of a beam without load, by the heights and slopes of its two ends.
    ends = np.vander([-1.0, 1.0], 4, increasing=True)
    slopes = ends @ np.diag([1.0, 2.0, 3.0], k=1)
    cubic = np.linalg.solve(np.vstack([ends, slopes]), [-1.0, 1.0, 0.0, 0.0])
    spot = np.array([setup.camera.cx + 20.0, setup.camera.cy - 10.0])
    way, other = np.array([np.sqrt(0.75), 0.5]), np.array([-0.5, np.sqrt(0.75)])
    for part, aside in ((0.0, 30.0), (0.5, -40.0), (-0.5, 60.0), (0.9, 0.0), (-0.95, 5.0)):
        x, y = np.round(spot + 120.0 * part * way + aside * other - [column, row]).astype(int)
        expected = np.polynomial.polynomial.polyval(part, cubic)
        # What a pixel's place is off by, at the steepest.
        assert found[y, x, 0] == pytest.approx(expected, abs=0.75 * 1.5 / 120.0)
    # Beyond its ends it is as there, and it is 1 at most.
    assert np.ptp(found) == pytest.approx(2.0, abs=1e-3)


@pytest.mark.slow
def test_a_shifted_bar_errs_alike_in_all_poses_and_most_at_one_end(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    told: dict[tuple[int, int], float] = {}
    for size, most in ((1, 4.0), (2, 10.0)):
        faults, largest = draw_faults('depth_affine/shifted bar', setup, size), []
        told.clear()
        for pose in (0, 2):
            seen = with_and_without(plain, setup, faults, pose, rests[pose])
            spread_of_what_stays(seen, told)
            view, right, there = seen
            errors = 1e3 * (view.depth[there] - right.depth[there])
            largest.append(float(np.abs(errors[right.labels[there] != FIXTURE]).max()))
        assert max(largest) == pytest.approx(most, rel=0.25)


def test_hands_polish_a_body_by_a_bell(setup: Setup, plain: Specimen) -> None:
    painted = body_triangles(plain.mesh, plain.mesh.nodes, plain.shares, Paint(bell=(0.6, 0.2)))
    middles = painted.corners.mean(axis=1)
    share = (middles[:, 0] - setup.shape.clamp) / (setup.shape.length - setup.shape.clamp)
    parts, free = tip_part(painted.labels), share > 0.0
    expected = np.power(np.e, -25.0 * (share - 0.6) ** 2)
    # To the nearest twentieth, at the middle of a patch.
    assert parts[free] == pytest.approx(expected[free], abs=0.08)
    assert parts.max() == 1.0
    assert parts[free].min() < 0.1


@pytest.mark.slow
def test_what_was_polished_errs_most_where_it_is_held(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    faults = draw_faults('depth_bias_by_region/polished', setup)
    error = region_errors(plain, setup, faults, 2, rests[2])
    twentieths = 20.0 * error
    assert twentieths == pytest.approx(np.round(twentieths), abs=1e-6)
    assert error.max() == pytest.approx(1.0)
    assert len(np.unique(np.round(twentieths))) > 15
    assert abs(faults.region_bias) == pytest.approx(12.0, rel=0.16)


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_wedge_bends_all_rays_alike_whichever_way_it_is_turned(family: str) -> None:
    drawn = draw_sealed(family)
    plain = make_specimen(drawn, Faults(), COARSE)
    distance = float(np.linalg.norm(drawn.depth_from_world[:3, 3]))
    for size, most in ((1, 0.004), (2, 0.010)):
        faults, looks = draw_faults('camera_offset/wedge', drawn, size), []
        for pose in range(4):
            off = jostled(drawn, drawn.observations[pose], faults)
            found = true_camera(plain, drawn, off) @ np.linalg.inv(drawn.depth_from_world)
            # The lens stays where it is.
            assert found[:3, 3] == pytest.approx(0.0, abs=1e-12)
            looks.append(distance * found[:3, 2])
            # It does not roll what is seen, but by the square of a small angle.
            assert found[1, 0] == pytest.approx(found[0, 1], abs=1e-9)
        sides = np.array(looks)[:, :2]
        assert np.linalg.norm(sides, axis=1) == pytest.approx(most, rel=0.16)
        turned = np.diff(np.unwrap(np.arctan2(sides[:, 1], sides[:, 0])))
        assert (turned > 0.69).all()
        assert (turned < 2.21).all()
