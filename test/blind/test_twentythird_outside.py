# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the twenty-third set has do what their labels say."""

import numpy as np
import pytest
from support.blind_rests import rubber_volumes, tip_moves
from support.blind_views import with_and_without

from benchmarks.blind.faults import Faults
from benchmarks.blind.rest_shape import true_shape
from benchmarks.blind.setups import draw_setup, Setup
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.twentythird_outside import TWENTYTHIRD_OUTSIDE


def _drawn(name: str, setup: Setup, size: int = 2) -> Faults:
    return Faults(**TWENTYTHIRD_OUTSIDE[name](size, setup, np.random.default_rng(8)).changes)


@pytest.mark.parametrize('share', [0.3, -0.5])
def test_a_mould_that_is_not_level_slopes_a_bodys_upper_side_alone(
    setup: Setup, share: float
) -> None:
    shape = setup.shape
    width, height = shape.section
    sloping = true_shape(shape, Faults(unlevel=share))
    ahead = shape.clamp + np.array([0.0, 0.075, 0.15, 0.6, 1.0]) * (shape.length - shape.clamp)
    for across in (-0.5, -0.25, 0.0, 0.5):
        upper = np.stack([ahead, np.full(5, across * width), np.full(5, 0.5 * height)], axis=-1)
        higher = sloping.place(upper) - shape.place(upper)
        expected = 2.0 * across * share * height * np.array([0.0, 0.5, 1.0, 1.0, 1.0])
        assert higher[:, 2] == pytest.approx(expected, abs=1e-12)
        assert not higher[:, :2].any()
        lower = upper * np.array([1.0, 1.0, -1.0])
        assert sloping.place(lower) == pytest.approx(shape.place(lower), abs=1e-12)
    held = np.array([[0.4 * shape.clamp, 0.1 * width, 0.5 * height]])
    assert np.array_equal(sloping.place(held), shape.place(held))


@pytest.mark.parametrize('family', ['beam', 'arch', 'waist', 'fin', 'tee'])
def test_as_much_rubber_is_in_a_mould_that_is_not_level(family: str) -> None:
    drawn = draw_setup(family, is_sealed=True, poses=4, random=np.random.default_rng(3))
    volumes = rubber_volumes(drawn, _drawn('unlevel', drawn))
    # A tee's arms are not alike, and one of them is higher.
    assert volumes[0] == pytest.approx(volumes[1], rel=0.1 if family == 'tee' else 0.02)


def test_a_sloping_side_moves_what_is_seen_by_some_4_and_10_mm(
    setup: Setup, plain: Specimen
) -> None:
    tip = plain.shares > 0.99
    height = setup.shape.section[1]
    for size, most in ((1, 0.004), (2, 0.010)):
        faults = _drawn('unlevel', setup, size)
        assert abs(faults.unlevel) * height == pytest.approx(most, rel=0.16)
        assert 1.0 < 1e3 * max(tip_moves(setup, plain, faults, tip)) < 12.0


def test_a_sloping_side_is_no_steeper_than_a_thin_body_bears() -> None:
    for family in ('plate', 'fin'):
        for seed in range(4):
            drawn = draw_setup(family, is_sealed=True, poses=4, random=np.random.default_rng(seed))
            assert abs(_drawn('unlevel', drawn).unlevel) <= 0.55 * 1.15 + 1e-4


def test_flicker_swings_over_the_rows_by_a_phase_of_each_pose(
    setup: Setup, plain: Specimen, rests: list[np.ndarray]
) -> None:
    faults, phases = _drawn('flicker', setup), []
    for pose in range(4):
        view, right, there = with_and_without(plain, setup, faults, pose, rests[pose])
        rows, _, _ = np.nonzero(there)
        errors = view.depth[there] - right.depth[there]
        angles = 2.0 * np.pi * (right.row + rows) / faults.flicker_period
        waves = np.stack([np.sin(angles), np.cos(angles)], axis=-1)
        (by_sine, by_cosine), *_ = np.linalg.lstsq(waves, errors, rcond=None)
        assert waves @ [by_sine, by_cosine] == pytest.approx(errors, abs=1e-12)
        assert np.hypot(by_sine, by_cosine) == pytest.approx(1e-3 * faults.flicker)
        phases.append(np.arctan2(by_cosine, by_sine) % (2.0 * np.pi))
    assert phases == pytest.approx(np.array(faults.flicker_phases), abs=1e-6)
    assert np.ptp(phases) > 0.5
    assert faults.flicker == pytest.approx(10.0, rel=0.16)
