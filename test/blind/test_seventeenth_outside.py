# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the seventeenth set has do what their labels say."""

from collections.abc import Callable

import numpy as np
import pytest
from support.blind_rests import tip_moves

from benchmarks.blind.fattening import fattened
from benchmarks.blind.faults import Faults
from benchmarks.blind.hexahedra import integrate, mesh_hexahedra
from benchmarks.blind.renderer import Camera, Rendering
from benchmarks.blind.rest_shape import true_shape
from benchmarks.blind.setups import draw_setup, Setup
from benchmarks.blind.seventeenth_outside import SEVENTEENTH_OUTSIDE
from benchmarks.blind.specimen import Specimen

Depths = Callable[[Faults, int], np.ndarray]
CAMERA = Camera(width=40, height=30, fx=50.0, fy=51.0, cx=19.5, cy=14.5)


def _drawn(name: str, setup: Setup, size: int = 2) -> Faults:
    return Faults(**SEVENTEENTH_OUTSIDE[name](size, setup, np.random.default_rng(8)).changes)


def test_a_dished_body_lacks_its_share_amid_its_upper_side_alone(setup: Setup) -> None:
    share, shape = 0.3, setup.shape
    width, height = shape.section
    dished = true_shape(shape, Faults(dished=share))
    ahead = shape.clamp + np.array([0.0, 0.075, 0.15, 0.6, 1.0]) * (shape.length - shape.clamp)
    for across, part in ((0.0, 1.0), (0.25, 0.75), (-0.5, 0.0)):
        upper = np.stack([ahead, np.full(5, across * width), np.full(5, 0.5 * height)], axis=-1)
        lacking = shape.place(upper) - dished.place(upper)
        expected = share * height * part * np.array([0.0, 0.5, 1.0, 1.0, 1.0])
        assert lacking[:, 2] == pytest.approx(expected, abs=1e-12)
        assert not lacking[:, :2].any()
        lower = upper * np.array([1.0, 1.0, -1.0])
        assert dished.place(lower) == pytest.approx(shape.place(lower), abs=1e-12)
    held = np.array([[0.4 * shape.clamp, 0.1 * width, 0.5 * height]])
    assert np.array_equal(dished.place(held), shape.place(held))


def test_a_dished_body_lacks_two_thirds_of_that_in_volume(setup: Setup) -> None:
    share, volumes = 0.24, []
    for faults in (Faults(), Faults(dished=share)):
        mesh = mesh_hexahedra(true_shape(setup.shape, faults))
        volumes.append(float(integrate(mesh.nodes, mesh.cells).volumes.sum()))
    free = np.prod(setup.shape.section) * (setup.shape.length - setup.shape.clamp)
    # Less over the first part, where it comes up: 0.15 / 2.
    assert volumes[0] - volumes[1] == pytest.approx(free * share * 2.0 / 3.0 * 0.925, rel=2e-3)


def test_a_crossbar_is_not_dished_beyond_its_body() -> None:
    setup = draw_setup('tee', is_sealed=True, poses=4, random=np.random.default_rng(1))
    width, height = setup.shape.section
    arm = np.array([[setup.shape.length, 0.9 * width, 0.5 * height]])
    dished = true_shape(setup.shape, Faults(dished=0.3))
    assert np.array_equal(dished.place(arm), setup.shape.place(arm))


def test_a_dish_moves_a_tip_by_some_4_and_10_mm(setup: Setup, plain: Specimen) -> None:
    for size, least, most in ((1, 2.5, 6.0), (2, 7.0, 15.0)):
        moves = tip_moves(setup, plain, _drawn('dished', setup, size), plain.shares > 0.99)
        assert least < 1e3 * max(moves) < most


def _view(row: int, column: int, depth: np.ndarray) -> Rendering:
    labels = np.where(np.isfinite(depth), 1, -1)
    return Rendering(column, row, depth, labels, np.where(labels > 0, 0.7, 1.0))


def test_a_fattened_outline_lies_farther_out_on_all_sides_and_tells_what_is_nearest() -> None:
    depth = np.full((5, 6, 9), np.inf)
    depth[2, 3] = 0.3 + 0.001 * np.arange(9)
    found = fattened(_view(10, 20, depth), CAMERA, 2.0)
    assert (found.row, found.column, found.depth.shape) == (8, 18, (9, 10, 9))
    assert found.depth[4, 5] == pytest.approx(depth[2, 3])
    # Centres of samples of the pixel at (12, 23), and of all others in the image [px].
    offsets = (np.arange(3) - 1.0) / 3.0
    rows = 8.0 + np.arange(9)[:, None, None] + np.repeat(offsets, 3)
    columns = 18.0 + np.arange(10)[None, :, None] + np.tile(offsets, 3)
    down = np.maximum(np.abs(rows - 12.0) - 1.0 / 3.0, 0.0)
    aside = np.maximum(np.abs(columns - 23.0) - 1.0 / 3.0, 0.0)
    away = np.hypot(down, aside)
    assert np.array_equal(np.isfinite(found.depth), away < 2.0 + 1e-9)
    assert found.depth[4, 7, 3] == pytest.approx(depth[2, 3, 5])
    assert np.array_equal(found.labels > 0, np.isfinite(found.depth))
    assert found.facing[4, 7, 3] == 0.7
    assert found.facing[0, 0, 0] == 1.0


def test_a_fattened_view_ends_where_the_image_does() -> None:
    found = fattened(_view(1, 33, np.full((4, 6, 9), 0.3)), CAMERA, 3.5)
    assert (found.row, found.column) == (0, 29)
    assert found.depth.shape == (9, 11, 9)


def test_a_view_that_is_not_fattened_is_as_it_was() -> None:
    view = _view(10, 20, np.full((5, 6, 9), 0.3))
    assert fattened(view, CAMERA, 0.0) is view


def test_a_body_is_seen_wider_by_its_outline(setup: Setup, depths: Depths) -> None:
    for pose in (0, 3):
        areas = [np.isfinite(depths(Faults(), pose)).sum() / 9.0]
        radii = [0.0]
        for size in (1, 2):
            faults = _drawn('fattened', setup, size)
            radii.append(faults.fattened)
            areas.append(np.isfinite(depths(faults, pose)).sum() / 9.0)
        # Steiner: a convex outline grows by its length times the way, and that way's disc.
        lengths = [
            (area - areas[0] - np.pi * radius**2) / radius
            for area, radius in zip(areas[1:], radii[1:], strict=True)
        ]
        assert lengths[1] == pytest.approx(lengths[0], rel=0.15)
        across = 2.0 * np.sqrt(np.pi * areas[0])
        assert across < lengths[0] < 3.0 * across
