# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the sixteenth set has do what their labels say."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from support.blind_rests import COARSE, rest_of, tip_moves

from benchmarks.blind.faults import Faults
from benchmarks.blind.ghost import ghosted
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.setups import Setup
from benchmarks.blind.simulation import make_specimen
from benchmarks.blind.sixteenth_outside import SIXTEENTH_OUTSIDE
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.whirl import whirled

Depths = Callable[[Faults, int], np.ndarray]


def _drawn(name: str, setup: Setup, size: int = 2) -> Faults:
    return Faults(**SIXTEENTH_OUTSIDE[name](size, setup, np.random.default_rng(8)).changes)


@pytest.mark.parametrize('way', [(1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.6, 0.0, -0.8)])
def test_a_whirl_goes_around_its_axis_and_is_strongest_at_its_radius(
    way: tuple[float, float, float],
) -> None:
    faults = Faults(whirl=5.0, whirl_at=(0.02, -0.01), whirl_radius=0.04)
    axis, outward = np.array([0.02, 0.3, -0.01]), np.array(way)
    distances = np.array([0.0, 0.02, 0.039, 0.04, 0.041, 0.08])
    pushes = whirled(axis + distances[:, None] * outward, faults)
    # Along the turn about what is up, and by as much at every height.
    around = np.cross([0.0, 1.0, 0.0], outward)
    sizes = pushes @ around
    assert pushes == pytest.approx(sizes[:, None] * around, abs=1e-12)
    lower = axis - np.array([0.0, 0.7, 0.0])
    assert pushes == pytest.approx(whirled(lower + distances[:, None] * outward, faults))
    assert sizes.argmax() == 3
    # Half and twice the radius are alike: 4/5 of the speed.
    assert sizes[[0, 1, 3, 5]] == pytest.approx([0.0, 3.2, 5.0, 3.2])


def test_a_whirl_moves_a_tip_by_some_4_and_10_mm(setup: Setup, plain: Specimen) -> None:
    for size, least, most in ((1, 2.5, 6.0), (2, 7.0, 15.0)):
        moves = tip_moves(setup, plain, _drawn('whirl', setup, size), plain.shares > 0.99)
        assert least < 1e3 * max(moves) < most


def test_a_whirl_moves_a_body_back_that_turns_back_and_none_that_is_far(setup: Setup) -> None:
    faults = _drawn('whirl', setup)
    tip = make_specimen(setup, Faults(), COARSE).shares > 0.99
    hanging = rest_of(setup, Faults())[tip].mean(axis=0)
    there, back, far = (
        rest_of(setup, each)[tip].mean(axis=0) - hanging
        for each in (
            faults,
            replace(faults, whirl=-faults.whirl),
            replace(faults, whirl_at=(9.0, 9.0)),
        )
    )
    assert np.linalg.norm(there + back) < 0.3 * np.linalg.norm(there)
    assert np.linalg.norm(far) < 1e-5


def _view(row: int, column: int, depth: np.ndarray) -> Rendering:
    return Rendering(column, row, depth, np.zeros(depth.shape, dtype=np.int64), depth)


def test_a_ghost_is_mixed_in_where_both_views_see_something_and_nowhere_else() -> None:
    now, before = np.full((4, 5, 9), 0.3), np.full((5, 9, 9), 0.4)
    now[0, 0], before[4, 1] = np.inf, np.inf
    found = ghosted(_view(10, 20, now), _view(8, 23, before), 0.25).depth
    # In the image: rows 10 to 13 and columns 20 to 24; rows 8 to 12 and columns 23 to 31.
    expected = np.full((4, 5), 0.3)
    expected[:3, 3:] = 0.325
    expected[0, 0], expected[2, 4] = np.inf, 0.3
    assert found == pytest.approx(np.repeat(expected[..., None], 9, axis=-1))


def test_a_ghost_of_a_view_that_lies_elsewhere_is_not_seen() -> None:
    now, before = _view(0, 0, np.full((3, 3, 9), 0.3)), _view(50, 2, np.full((3, 3, 9), 0.4))
    assert np.array_equal(ghosted(now, before, 0.25).depth, now.depth)


def test_a_sensor_with_a_ghost_errs_from_the_second_pose_on(setup: Setup, depths: Depths) -> None:
    whole, largest = _drawn('ghost', setup), []
    for size in (1, 2):
        faults, errors = _drawn('ghost', setup, size), []
        assert np.array_equal(depths(faults, 0), depths(Faults(), 0))
        for pose in (1, 2, 3):
            clean, found, more = (depths(each, pose) for each in (Faults(), faults, whole))
            there = np.isfinite(clean)
            assert np.array_equal(there, np.isfinite(found))
            change = found[there] - clean[there]
            # By the same, times the share, where it is larger.
            assert whole.ghost * change == pytest.approx(
                faults.ghost * (more[there] - clean[there]), abs=1e-12
            )
            errors.append(float(np.abs(change).max()))
        largest.append(max(errors))
    assert 0.003 < largest[0] < largest[1] < 0.03
