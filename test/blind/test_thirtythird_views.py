# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forms of the thirty-third set that change what is seen do what their labels say."""

import numpy as np
import pytest
from support.blind_draws import draw_faults
from support.blind_views import region_errors, with_and_without

from benchmarks.blind.faults import Faults
from benchmarks.blind.paint import Paint, ROOT, TIP
from benchmarks.blind.setups import Setup
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.surface import body_triangles


@pytest.mark.parametrize(('size', 'most'), [(1, 4.0), (2, 10.0)])
def test_a_sealed_window_bulges_as_a_plate_whose_edges_are_held(
    setup: Setup, plain: Specimen, rests: list[np.ndarray], size: int, most: float
) -> None:
    faults = draw_faults('depth_affine/sealed window', setup, size)
    assert abs(faults.depth_bias) == pytest.approx(most, rel=0.16)
    for pose in range(4):
        view, right, there = with_and_without(plain, setup, faults, pose, rests[pose])
        rows, columns, _ = np.nonzero(there)
        u = columns + right.column - setup.camera.cx - faults.depth_spot[0]
        v = rows + right.row - setup.camera.cy - faults.depth_spot[1]
        # Both as shares of the ways to the edges: the square of each's beam.
        u, v = u / faults.depth_width, v / (0.75 * faults.depth_width)
        beams = [np.where(np.abs(way) < 1.0, 1.0 - 2.0 * way**2 + way**4, 0.0) for way in (u, v)]
        errors = 1e3 * (view.depth[there] - right.depth[there])
        assert errors == pytest.approx(faults.depth_bias * beams[0] * beams[1], abs=1e-6)
        # It is there where the body is, and not the same all over.
        assert np.abs(errors).max() > 0.7 * abs(faults.depth_bias)
        assert np.ptp(errors) > 0.1 * abs(faults.depth_bias)


def test_a_label_has_bars_and_what_is_between_them(setup: Setup) -> None:
    plain, bars = make_specimen(setup, Faults()), (0.1, 0.25, 0.4, 0.7)
    painted = body_triangles(plain.mesh, plain.mesh.nodes, plain.shares, Paint(0.1, bars=bars))
    assert set(painted.labels) == {ROOT, TIP}
    ahead = painted.corners.mean(axis=1)[:, 0] - setup.shape.clamp
    share = ahead / (setup.shape.length - setup.shape.clamp)
    for begin, end, label in (
        (0.0, 0.1, ROOT),
        (0.1, 0.25, TIP),
        (0.25, 0.4, ROOT),
        (0.4, 0.7, TIP),
        (0.7, 1.0, ROOT),
    ):
        within = (share > begin + 0.03) & (share < end - 0.03)
        assert set(painted.labels[within]) == {label}


@pytest.mark.parametrize(('size', 'most'), [(1, 5.0), (2, 12.0)])
def test_bars_err_where_they_are(
    setup: Setup, plain: Specimen, rests: list[np.ndarray], size: int, most: float
) -> None:
    faults = draw_faults('depth_bias_by_region/barcode', setup, size)
    assert abs(faults.region_bias) == pytest.approx(most, rel=0.16)
    # A bar first and last, and all of one to four modules.
    widths = np.diff(faults.region_bars)
    assert len(widths) % 2 == 1
    modules = widths / widths.min()
    assert 1.0 < modules.max() < 4.2
    assert faults.region_bars[0] == faults.region_from
    for pose in range(4):
        errors = region_errors(plain, setup, faults, pose, rests[pose])
        is_off = errors > 0.5
        assert errors == pytest.approx(is_off.astype(float), abs=1e-9)
        assert 0.2 < is_off.mean() < 0.75
