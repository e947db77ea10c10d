# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the thirtieth set that change what is seen do what their labels say."""

import numpy as np
import pytest
from support.blind_draws import draw_faults, draw_sealed, SEALED
from support.blind_rests import COARSE
from support.blind_views import region_errors, with_and_without

from benchmarks.blind.faults import Faults
from benchmarks.blind.observe import jostled, true_camera
from benchmarks.blind.paint import FIXTURE, Paint, ROOT, TIP
from benchmarks.blind.setups import Setup
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.surface import body_triangles


@pytest.mark.parametrize(('size', 'most'), [(1, 4.0), (2, 10.0)])
def test_a_glued_window_errs_like_a_roof(
    setup: Setup, plain: Specimen, rests: list[np.ndarray], size: int, most: float
) -> None:
    faults = draw_faults('depth_affine/glued window', setup, size)
    assert abs(faults.depth_bias) == pytest.approx(most, rel=0.16)
    # As a complex number, the way across the seam.
    across, sides = np.exp(-1j * np.deg2rad(faults.depth_slant)), set()
    for pose in range(4):
        view, right, there = with_and_without(plain, setup, faults, pose, rests[pose])
        rows, columns, _ = np.nonzero(there)
        ways = columns + right.column - setup.camera.cx - faults.depth_spot[0] + 0j
        ways += 1j * (rows + right.row - setup.camera.cy - faults.depth_spot[1])
        off = (ways * across).real / faults.depth_width
        errors = 1e3 * (view.depth[there] - right.depth[there])
        assert errors == pytest.approx(faults.depth_bias * np.sqrt(off**2), abs=1e-6)
        sides |= set(np.sign(off))
        # The fixture is farther off.
        spread = np.ptp(errors[right.labels[there] != FIXTURE])
        assert 0.3 * most < spread < 1.6 * most
    assert sides >= {-1.0, 1.0}


def test_a_coat_is_worn_off_along_all_edges(setup: Setup) -> None:
    plain = make_specimen(setup, Faults())
    painted = body_triangles(plain.mesh, plain.mesh.nodes, plain.shares, Paint(0.2, edges=0.4))
    corners, shape = painted.corners, setup.shape
    middles, half = corners.mean(axis=1), 0.5 * np.array(shape.section)
    share = (middles[:, 0] - shape.clamp) / (shape.length - shape.clamp)
    # How far below the two nearest sides, over half of what is between these and their others.
    below = np.sort(1.0 - np.abs(middles[:, 1:]) / half, axis=1)
    end = middles[:, 0] > shape.length - 1e-9
    assert 0.0 <= below[~end & (share > 0.0), 0].max() < 1e-9
    worn = np.where(end, below[:, 0], below[:, 1]) < 0.4
    expected = np.where(worn & (share > 0.2), TIP, ROOT)
    assert np.array_equal(painted.labels, expected)
    # On each side and at the end.
    assert set(painted.labels[end]) == set(painted.labels) == {ROOT, TIP}
    for axis in (1, 2):
        on_side = ~end & (share > 0.2) & (np.abs(middles[:, axis]) > 0.999 * half[axis - 1])
        assert 0.3 < (painted.labels[on_side] == TIP).mean() < 0.5


@pytest.mark.parametrize(('size', 'most'), [(1, 5.0), (2, 12.0)])
def test_what_is_worn_errs(
    setup: Setup, plain: Specimen, rests: list[np.ndarray], size: int, most: float
) -> None:
    faults = draw_faults('depth_bias_by_region/worn edges', setup, size)
    error = region_errors(plain, setup, faults, 0, rests[0])
    assert error[error > 0.5] == pytest.approx(1.0, abs=1e-6)
    assert error[error < 0.5] == pytest.approx(0.0, abs=1e-6)
    assert 0.2 < error.mean() < 0.7
    assert abs(faults.region_bias) == pytest.approx(most, rel=0.16)


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_camera_on_a_gas_spring_sinks_less_and_less(family: str) -> None:
    drawn = draw_sealed(family)
    plain = make_specimen(drawn, Faults(), COARSE)
    stored = drawn.depth_from_world
    for size, most in ((1, 0.004), (2, 0.010)):
        faults, heights = draw_faults('camera_offset/gas spring', drawn, size), []
        for pose in range(4):
            off = jostled(drawn, drawn.observations[pose], faults)
            found = true_camera(plain, drawn, off)
            # It looks the same way, and goes neither ahead nor aside.
            assert found[:3, :3] == pytest.approx(stored[:3, :3], abs=1e-9)
            before, after = (-each[:3, :3].T @ each[:3, 3] for each in (stored, found))
            assert (after - before)[[0, 2]] == pytest.approx(0.0, abs=1e-6)
            heights.append(float((after - before)[1]))
        assert heights[0] == pytest.approx(0.0, abs=1e-9)
        assert -heights[-1] == pytest.approx(most, rel=0.16)
        # Each step is the same share of the one before it.
        steps = np.diff(heights)
        assert (steps < 0.0).all()
        assert steps[2] / steps[1] == pytest.approx(steps[1] / steps[0], rel=2e-3)
        assert np.exp(-1.0 / 0.8) - 0.01 < steps[1] / steps[0] < np.exp(-1.0 / 2.0) + 0.01
