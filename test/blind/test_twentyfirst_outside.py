# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the twenty-first set has do what their labels say."""

import numpy as np
import pytest
from support.blind_rests import COARSE, tip_moves

from benchmarks.blind.combing import combed
from benchmarks.blind.fattening import sample_grid
from benchmarks.blind.faults import Faults
from benchmarks.blind.observe import true_rendering
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.setups import draw_setup, Setup
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.twentyfirst_outside import TWENTYFIRST_OUTSIDE


def _drawn(name: str, setup: Setup, size: int = 2) -> Faults:
    return Faults(**TWENTYFIRST_OUTSIDE[name](size, setup, np.random.default_rng(8)).changes)


@pytest.mark.parametrize('family', ['beam', 'tee', 'fin'])
def test_a_flattened_body_is_wider_and_as_much_thinner(family: str) -> None:
    setup = draw_setup(family, is_sealed=True, poses=4, random=np.random.default_rng(3))
    flat, whole = (
        make_specimen(setup, each, COARSE) for each in (Faults(flattened=0.5), Faults())
    )
    grown = 1.0 + 0.5 * whole.shares
    assert flat.mesh.nodes[:, 0] == pytest.approx(whole.mesh.nodes[:, 0], abs=1e-12)
    assert flat.mesh.nodes[:, 1] == pytest.approx(whole.mesh.nodes[:, 1] * grown, abs=1e-12)
    assert flat.mesh.nodes[:, 2] == pytest.approx(whole.mesh.nodes[:, 2] / grown, abs=1e-12)
    assert flat.body.masses.sum() == pytest.approx(whole.body.masses.sum(), rel=5e-3)


def test_a_flattened_body_sags_more_and_less_on_its_edge(setup: Setup, plain: Specimen) -> None:
    tip = plain.shares > 0.99
    for size, least, most in ((1, 2.0, 6.5), (2, 6.0, 15.0)):
        moves = tip_moves(setup, plain, _drawn('flattened', setup, size), tip)
        assert least < 1e3 * max(moves) < most
        # The second pose is rolled: its weight is across the width.
        assert moves[1] < 0.7 * moves[0]


@pytest.mark.parametrize('shift', [7.0, -17.4, 0.4])
@pytest.mark.parametrize('pose', [0, 3])
def test_odd_rows_are_seen_beside_the_others(
    setup: Setup, plain: Specimen, rests: list[np.ndarray], shift: float, pose: int
) -> None:
    right, view = (
        true_rendering(plain, setup, setup.observations[pose], each, rests[pose])
        for each in (Faults(), Faults(combed=shift))
    )
    whole, found = (_in_image(one, setup) for one in (right, view))
    assert np.array_equal(found[::2], whole[::2])
    columns = round(3.0 * shift)
    moved = np.roll(whole[1::2], columns, axis=2)
    assert np.array_equal(found[1::2], moved)
    assert not np.array_equal(found, whole)


def _in_image(view: Rendering, setup: Setup) -> np.ndarray:
    """Return depths of all an image's samples, shape (rows, 3, 3 columns)."""
    height, width = setup.camera.height, setup.camera.width
    image = np.full((height, width, 9), np.inf)
    rows, columns = view.depth.shape[:2]
    image[view.row : view.row + rows, view.column : view.column + columns] = view.depth
    return np.asarray(sample_grid(image).reshape(height, 3, 3 * width))


def test_labels_and_angles_go_with_the_depths(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    view = true_rendering(plain, setup, setup.observations[0], Faults(), rests[0])
    assert combed(view, setup.camera, 0.0) is view
    found = combed(view, setup.camera, 5.0)
    there = np.isfinite(found.depth)
    assert np.array_equal(there, found.labels >= 0)
    assert np.all(found.facing[~there] == 1.0)
    assert np.sort(found.facing[there]) == pytest.approx(
        np.sort(view.facing[np.isfinite(view.depth)])
    )


def test_a_scan_is_off_by_some_4_and_10_mm(setup: Setup) -> None:
    for size, most in ((1, 0.004), (2, 0.010)):
        distance = float(np.linalg.norm(setup.depth_from_world[:3, 3]))
        way = abs(_drawn('combed', setup, size).combed) * distance / setup.camera.fx
        assert way == pytest.approx(most, rel=0.3)
