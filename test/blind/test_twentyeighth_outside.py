# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the twenty-eighth set has do what their labels say."""

import numpy as np
import pytest
from support.blind_draws import draw_sealed, SEALED
from support.blind_rests import rubber_volumes, tip_moves

from benchmarks.blind.fattening import sample_grid
from benchmarks.blind.faults import Faults
from benchmarks.blind.lapsing import lapsed
from benchmarks.blind.observe import true_rendering
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.rest_shape import true_shape
from benchmarks.blind.setups import Setup
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.twentyeighth_outside import TWENTYEIGHTH_OUTSIDE


def _drawn(name: str, setup: Setup, size: int = 2) -> Faults:
    return Faults(**TWENTYEIGHTH_OUTSIDE[name](size, setup, np.random.default_rng(8)).changes)


@pytest.mark.parametrize('side', [1.0, -1.0])
def test_a_mitred_end_is_a_plane_aslant(setup: Setup, side: float) -> None:
    shape, half = setup.shape, 0.5 * np.array(setup.shape.section)
    mitred = true_shape(shape, Faults(mitred=8.0, mitred_side=side))
    free = shape.length - shape.clamp
    across = half * np.array([[1, 1], [1, -1], [-1, 1], [-1, -1], [0.5, 0], [0, 0]])
    for share, part in ((0.0, 0.0), (0.7, 0.0), (0.85, 0.5), (1.0, 1.0)):
        places = np.column_stack([np.full(6, shape.clamp + share * free), across])
        back = 1e3 * (shape.place(places) - mitred.place(places))
        expected = part * np.array([8.0, 8.0, 0.0, 0.0, 6.0, 4.0])
        assert back[:, 1:] == pytest.approx(0.0, abs=1e-12)
        # On the other side, what is left of 8 mm.
        assert back[:, 0] == pytest.approx(expected if side > 0 else 8.0 * part - expected)


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_a_mitred_body_lacks_half_of_what_is_cut(family: str) -> None:
    drawn = draw_sealed(family)
    faults = _drawn('mitred', drawn)
    left, whole = rubber_volumes(drawn, faults)
    # What is beyond seven tenths is shorter by a share, which is half of the most amid the width.
    specimen, free = make_specimen(drawn, Faults()), drawn.shape.length - drawn.shape.clamp
    shares = specimen.shares[specimen.mesh.cells] @ specimen.body.quadrature.values.T
    outer = float(specimen.body.quadrature.volumes[shares > 0.7].sum())
    expected = 0.5e-3 * faults.mitred / (0.3 * free) * outer
    assert whole - left == pytest.approx(expected, rel=0.15)


def test_a_mitred_beam_lacks_a_wedge(setup: Setup) -> None:
    left, whole = rubber_volumes(setup, Faults(mitred=10.0, mitred_side=-1.0))
    width, height = setup.shape.section
    assert whole - left == pytest.approx(0.5 * 0.010 * width * height, rel=1e-6)


@pytest.mark.slow
def test_a_mitred_bodys_tip_is_some_4_and_10_mm_back(setup: Setup, plain: Specimen) -> None:
    tip = plain.shares > 0.99
    for size, most in ((1, 4.0), (2, 10.0)):
        moves = 1e3 * np.array(tip_moves(setup, plain, _drawn('mitred', setup, size), tip))
        assert moves == pytest.approx(most, rel=0.25)


@pytest.mark.parametrize(
    ('shift', 'pose'),
    [(-17.4, 0), *(pytest.param(*each, marks=pytest.mark.slow) for each in ((7.0, 3), (0.4, 3)))],
)
def test_what_comes_after_lost_bytes_is_seen_to_the_side(
    setup: Setup, plain: Specimen, rests: list[np.ndarray], shift: float, pose: int
) -> None:
    whole = true_rendering(plain, setup, setup.observations[pose], Faults(), rests[pose])
    seen = np.nonzero(np.isfinite(whole.depth).any(axis=(1, 2)))[0] + whole.row
    row = int(seen[len(seen) // 3])
    faults = Faults(lapsed=shift, lapsed_row=row)
    view = true_rendering(plain, setup, setup.observations[pose], faults, rests[pose])
    before, after = (_in_image(one, setup) for one in (whole, view))
    assert np.array_equal(after[:row], before[:row])
    moved = np.roll(before[row:], round(3.0 * shift), axis=2)
    assert np.array_equal(after[row:], moved)
    assert not np.array_equal(after, before)


def _in_image(view: Rendering, setup: Setup) -> np.ndarray:
    """Return depths of all an image's samples, shape (rows, 3, 3 columns)."""
    height, width = setup.camera.height, setup.camera.width
    image = np.full((height, width, 9), np.inf)
    rows, columns = view.depth.shape[:2]
    image[view.row : view.row + rows, view.column : view.column + columns] = view.depth
    return np.asarray(sample_grid(image).reshape(height, 3, 3 * width))


@pytest.mark.parametrize('family', ['beam', *SEALED])
def test_bytes_are_lost_amid_a_body_by_some_4_and_10_mm(family: str) -> None:
    drawn = draw_sealed(family)
    distance = float(np.linalg.norm(drawn.depth_from_world[:3, 3]))
    world = drawn.depth_from_world @ drawn.observations[0].world_from_object
    ends = drawn.shape.place(np.array([[drawn.shape.clamp, 0, 0], [drawn.shape.length, 0, 0.0]]))
    rows = drawn.camera.project(ends @ world[:3, :3].T + world[:3, 3])[:, 1]
    for size, most in ((1, 0.004), (2, 0.010)):
        faults = _drawn('lapsed', drawn, size)
        way = abs(faults.lapsed) * distance / drawn.camera.fx
        assert way == pytest.approx(most, rel=0.16)
        assert rows.min() - 13.0 < faults.lapsed_row < rows.max() + 13.0


def test_no_bytes_are_lost_where_none_are_told(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    view = true_rendering(plain, setup, setup.observations[0], Faults(), rests[0])
    assert lapsed(view, setup.camera, 0.0, view.row) is view
    found = lapsed(view, setup.camera, 5.0, view.row + 3)
    there = np.isfinite(found.depth)
    assert np.array_equal(there, found.labels >= 0)
    assert np.all(found.facing[~there] == 1.0)
