# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the twenty-ninth set that change what is seen do what their labels say."""

import numpy as np
import pytest
from support.blind_draws import draw_faults, draw_sealed, SEALED
from support.blind_rests import COARSE
from support.blind_views import region_errors

from benchmarks.blind.faults import Faults
from benchmarks.blind.observe import jostled, true_camera
from benchmarks.blind.paint import Paint, ROOT, TIP
from benchmarks.blind.setups import Setup
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.surface import body_triangles


def test_a_sleeve_is_cut_to_a_tongue_on_each_side(setup: Setup) -> None:
    plain = make_specimen(setup, Faults())
    paint = Paint(0.2, tongue=0.9)
    painted = body_triangles(plain.mesh, plain.mesh.nodes, plain.shares, paint)
    corners, shape = painted.corners, setup.shape
    middles, half = corners.mean(axis=1), 0.5 * np.array(shape.section)
    share = (middles[:, 0] - shape.clamp) / (shape.length - shape.clamp)
    areas = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    outward = np.abs(middles[:, 1:]) / half
    for axis in (0, 1):
        on_side = (outward[:, axis] > 0.999) & (share > 0.0)
        # Of a triangle and what is beyond it.
        is_tip = painted.labels[on_side] == TIP
        covered = (areas[on_side] * is_tip).sum() / areas[on_side].sum()
        assert covered == pytest.approx(0.5 * 0.7 + 0.1, abs=0.03)
        there = share[on_side]
        assert not is_tip[there < 0.2].any()
        assert is_tip[there > 0.9].all()
        # Narrower where it is nearer to the clamp.
        inside = outward[on_side, 1 - axis] < (there - 0.2) / 0.7
        assert np.array_equal(is_tip, inside)
    end = middles[:, 0] > shape.length - 1e-9
    assert set(painted.labels[end]) == {TIP}
    assert set(painted.labels) == {ROOT, TIP}


@pytest.mark.slow
@pytest.mark.parametrize(('size', 'most'), [(1, 5.0), (2, 12.0)])
def test_what_is_on_tongues_errs(
    setup: Setup, plain: Specimen, rests: list[np.ndarray], size: int, most: float
) -> None:
    faults = draw_faults('depth_bias_by_region/tongues', setup, size)
    error = region_errors(plain, setup, faults, 0, rests[0])
    assert error[error > 0.5] == pytest.approx(1.0, abs=1e-6)
    assert error[error < 0.5] == pytest.approx(0.0, abs=1e-6)
    assert 0.3 < error.mean() < 0.7
    assert abs(faults.region_bias) == pytest.approx(most, rel=0.16)


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_camera_on_a_cord_turns_about_the_upright_through_it(family: str) -> None:
    drawn = draw_sealed(family)
    plain = make_specimen(drawn, Faults(), COARSE)
    distance, stored = float(np.linalg.norm(drawn.depth_from_world[:3, 3])), drawn.depth_from_world
    for size, most in ((1, 0.004), (2, 0.010)):
        faults, angles = draw_faults('camera_offset/twisting', drawn, size), []
        for pose in range(4):
            off = jostled(drawn, drawn.observations[pose], faults)
            found = true_camera(plain, drawn, off)
            # It stays where it is, and what is upright stays so.
            before, after = (-each[:3, :3].T @ each[:3, 3] for each in (stored, found))
            assert after == pytest.approx(before, abs=1e-9)
            assert found[:3, 1] == pytest.approx(stored[:3, 1], abs=2e-6)
            ahead, now = stored[2, :3], found[2, :3]
            angles.append(np.arctan2(np.cross(ahead, now)[1], ahead[[0, 2]] @ now[[0, 2]]))
        assert distance * np.abs(angles).max() == pytest.approx(most, rel=0.16)
        # A damped swing goes on by itself: of three, the third by the two before it.
        shares = np.array(angles) / np.abs(angles).max()
        before = np.column_stack([shares[1:3], shares[:2]])
        on, back = np.linalg.solve(before, shares[2:])
        assert np.exp(-0.6) - 0.02 < -back < np.exp(-0.2) + 0.02
        rate = np.arccos(on / (2.0 * np.sqrt(-back)))
        assert 1.45 < rate < 2.55
