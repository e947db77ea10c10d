# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the twenty-fourth set has do what their labels say."""

from dataclasses import replace

import numpy as np
import pytest
from support.blind_rests import rubber_volumes, tip_moves
from support.blind_views import with_and_without

from benchmarks.blind.blocks import in_blocks
from benchmarks.blind.faults import Faults
from benchmarks.blind.observe import true_rendering
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.rest_shape import true_shape
from benchmarks.blind.setups import draw_setup, Setup
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.twentyfourth_outside import TWENTYFOURTH_OUTSIDE


def _drawn(name: str, setup: Setup, size: int = 2) -> Faults:
    return Faults(**TWENTYFOURTH_OUTSIDE[name](size, setup, np.random.default_rng(8)).changes)


@pytest.mark.parametrize('share', [0.3, -0.5])
def test_walls_that_flare_make_a_body_wider_above_and_narrower_below(
    setup: Setup, share: float
) -> None:
    shape = setup.shape
    half_width, half_height = 0.5 * np.array(shape.section)
    flaring = true_shape(shape, Faults(drafted=share))
    ahead = shape.clamp + np.array([0.0, 0.075, 0.15, 0.6, 1.0]) * (shape.length - shape.clamp)
    for across, high in ((1.0, 1.0), (-1.0, 1.0), (0.5, -1.0), (1.0, 0.0), (0.0, 1.0)):
        place = np.array([across * half_width, high * half_height])
        places = np.column_stack([ahead, np.tile(place, (5, 1))])
        moved = flaring.place(places) - shape.place(places)
        farther = share * across * high * half_width * np.array([0.0, 0.5, 1.0, 1.0, 1.0])
        assert moved[:, 1] == pytest.approx(farther, abs=1e-12)
        assert not moved[:, [0, 2]].any()
    held = np.array([[0.4 * shape.clamp, 0.5 * half_width, half_height]])
    assert np.array_equal(flaring.place(held), shape.place(held))


@pytest.mark.parametrize('family', ['beam', 'arch', 'waist', 'fin', 'tee'])
def test_as_much_rubber_is_in_a_mould_with_flaring_walls(family: str) -> None:
    drawn = draw_setup(family, is_sealed=True, poses=4, random=np.random.default_rng(3))
    volumes = rubber_volumes(drawn, _drawn('drafted', drawn))
    assert volumes[0] == pytest.approx(volumes[1], rel=0.01)


def test_flaring_walls_move_a_bodys_edges_by_up_to_10_mm(setup: Setup, plain: Specimen) -> None:
    tip, edges = plain.shares > 0.99, []
    for size in (1, 2):
        faults = _drawn('drafted', setup, size)
        edges.append(1e3 * abs(faults.drafted) * 0.5 * setup.shape.section[0])
        assert 0.5 < 1e3 * max(tip_moves(setup, plain, faults, tip)) < 8.0
    assert edges[0] == pytest.approx(0.4 * edges[1], rel=1e-3)
    assert 4.0 < edges[1] < 11.6
    for seed in range(4):
        wide = draw_setup('fin', is_sealed=True, poses=4, random=np.random.default_rng(seed))
        edge = abs(_drawn('drafted', wide).drafted) * 0.5 * wide.shape.section[0]
        assert edge == pytest.approx(0.010, rel=0.17)


def test_each_square_of_a_blocky_image_has_the_mean_of_its_depths() -> None:
    random = np.random.default_rng(5)
    depth = random.uniform(0.2, 0.4, (23, 31, 9))
    depth[random.random(depth.shape) < 0.4] = np.inf
    depth[:9, :7] = np.inf
    view = Rendering(13, 6, depth, np.zeros(depth.shape, dtype=np.int64), np.ones(depth.shape))
    found = in_blocks(view, 8)
    assert found.labels is view.labels
    assert np.array_equal(np.isfinite(found.depth), np.isfinite(depth))
    seen, one = 0, range(8)
    for row in range(0, 32, 8):
        for column in range(8, 48, 8):
            places = [(r + row - 6, c + column - 13) for r in one for c in one]
            inside = [(r, c) for r, c in places if 0 <= r < 23 and 0 <= c < 31]
            before = np.array([depth[place] for place in inside]).ravel()
            after = np.array([found.depth[place] for place in inside]).ravel()
            there = np.isfinite(before)
            seen += int(there.sum())
            assert after[there] == pytest.approx(before[there].sum() / max(there.sum(), 1))
    assert seen == np.isfinite(depth).sum()
    assert in_blocks(view, 0) is view


def test_a_camera_whose_images_are_blocky_sees_steps(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    spreads = []
    for size in (1, 2):
        faults = _drawn('blocky', setup, size)
        found = []
        for pose in range(4):
            view, right, there = with_and_without(plain, setup, faults, pose, rests[pose])
            errors = view.depth[there] - right.depth[there]
            # No depth is lost or won.
            assert errors.mean() == pytest.approx(0.0, abs=1e-9)
            assert len(np.unique(view.depth[there])) < 0.02 * there.sum()
            found.append(1e3 * float(np.percentile(np.abs(errors), 90)))
        spreads.append(max(found))
    assert 3.0 < spreads[0] < 5.5
    assert 7.0 < spreads[1] < 13.0


def test_squares_are_those_of_the_whole_image(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    faults = replace(_drawn('blocky', setup), blocky=40)
    view = true_rendering(plain, setup, setup.observations[0], faults, rests[0])
    steps = np.ptp(np.where(np.isfinite(view.depth), view.depth, np.nan), axis=2)
    # Within a pixel there is no step.
    assert np.nanmax(steps) == 0.0
    amid = view.depth[view.depth.shape[0] // 2, :, 4]
    changes = view.column + 1 + np.flatnonzero(np.diff(amid[np.isfinite(amid)]))
    begun = int(np.flatnonzero(np.isfinite(amid))[0])
    assert len(changes) > 1
    assert set((changes + begun) % 40) == {0}
