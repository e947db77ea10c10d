# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Frames fade as they should, and a surprise is told from noise."""

from diffcal_ros.calibration.tracking.forgetting_filter import ForgettingFilter
from diffcal_ros.calibration.tracking.innovation import Innovation
from diffcal_ros.least_squares.normal_equations import NormalEquations
import numpy as np
import pytest

SECOND = 1_000_000_000  # [ns]
MEMORY = 0.4  # [s]
# Of a tilted, stretched valley.
CURVATURE = np.array([[5.0, 1.2], [1.2, 0.7]])


def _valley(bottom, here, curvature=CURVATURE) -> NormalEquations:
    return NormalEquations(0.0, curvature @ (bottom - here), curvature)


def test_weights_are_those_of_an_exponential_window():
    kept = ForgettingFilter(2, MEMORY)
    random = np.random.default_rng(2)
    bottoms = random.normal(size=(400, 2))
    stamps = np.cumsum(random.integers(20_000_000, 60_000_000, size=400))
    for bottom, stamp in zip(bottoms, stamps, strict=True):
        kept.add(_valley(bottom, np.zeros(2)), int(stamp))
    # A frame's weight: what its age gave it when it came, times how that has faded since.
    steps = np.diff(stamps) / SECOND
    shares = np.concatenate([[1.0], 1.0 - np.exp(-steps / MEMORY)])
    faded = np.exp(-(stamps[-1] - stamps) / SECOND / MEMORY)
    weights = shares * faded
    # So long ago that the first frames, which weigh alike, do not count.
    assert weights[:100].sum() < 1e-6
    expected = CURVATURE @ (weights @ bottoms)
    np.testing.assert_allclose(kept.equations.negative_gradient, expected, rtol=1e-6)
    np.testing.assert_allclose(kept.equations.curvature, CURVATURE, rtol=1e-12)
    assert kept.frames_worth == pytest.approx(1.0 / (weights**2).sum(), rel=1e-6)


def test_the_first_frames_weigh_alike():
    kept = ForgettingFilter(2, 1e6)
    bottoms = np.arange(14.0).reshape(7, 2) ** 2
    for number, bottom in enumerate(bottoms):
        kept.add(_valley(bottom, np.zeros(2)), number * SECOND // 30)
    np.testing.assert_allclose(
        kept.equations.negative_gradient, CURVATURE @ bottoms.mean(axis=0), rtol=1e-12
    )
    assert kept.frames_worth == pytest.approx(7.0)


def test_moving_the_point_changes_nothing_of_what_is_known():
    kept, moved = ForgettingFilter(2, MEMORY), ForgettingFilter(2, MEMORY)
    here = np.zeros(2)
    for number in range(5):
        bottom = np.array([0.3 * number, -1.0])
        stamp = number * SECOND // 30
        kept.add(_valley(bottom, np.zeros(2)), stamp)
        moved.add(_valley(bottom, here), stamp)
        step = np.array([0.1, 0.05 * number])
        moved.move(step)
        here = here + step
    found = np.linalg.solve(kept.equations.curvature, kept.equations.negative_gradient)
    found_moved = here + np.linalg.solve(
        moved.equations.curvature, moved.equations.negative_gradient
    )
    np.testing.assert_allclose(found_moved, found, rtol=1e-12)


def test_after_a_gap_of_seconds_the_past_is_gone():
    kept = ForgettingFilter(2, MEMORY)
    for number in range(30):
        kept.add(_valley(np.array([9.0, 9.0]), np.zeros(2)), number * SECOND // 30)
    kept.add(_valley(np.array([1.0, -2.0]), np.zeros(2)), 10 * SECOND)
    found = np.linalg.solve(kept.equations.curvature, kept.equations.negative_gradient)
    # Nine seconds of 0.4 s each.
    np.testing.assert_allclose(found, [1.0, -2.0], atol=20.0 * np.exp(-9.0 / MEMORY))
    assert kept.frames_worth == pytest.approx(1.0, abs=1e-6)


class Pulls:
    """Pulls whose covariance is a known share of the one that is stated."""

    def __init__(self, seed: int, share: float) -> None:
        self._random = np.random.default_rng(seed)
        root = self._random.normal(size=(4, 4))
        # The last two coordinates say the same: the covariance is singular.
        root[3] = root[2]
        self.gradient_covariance = root @ root.T
        self._root = np.sqrt(share) * root

    def draw(self, factor: float = 1.0) -> np.ndarray:
        return factor * self._root @ self._random.normal(size=4)


def test_usual_frames_weigh_as_their_age_says():
    pulls = Pulls(seed=1, share=0.3)
    innovation = Innovation()
    innovation.hold(pulls.gradient_covariance)
    shares = np.array([innovation.least_fraction(pulls.draw()) for _ in range(3000)])
    # Chi-square of three directions exceeds 24 once in 40,000.
    assert np.count_nonzero(shares) <= 2
    assert innovation.new_fraction == pytest.approx(0.3, rel=0.15)


def test_a_surprise_weighs_the_more_the_larger_it_is():
    pulls = Pulls(seed=2, share=0.3)
    innovation = Innovation()
    innovation.hold(pulls.gradient_covariance)
    for _ in range(200):
        innovation.least_fraction(pulls.draw())
    away = pulls.draw()
    square = away @ np.linalg.pinv(pulls.gradient_covariance, rcond=1e-9) @ away / 3.0
    size = np.sqrt(square / innovation.new_fraction)
    shares = [innovation.least_fraction(away * factor / size) for factor in (16.0, 4.0, 2.0)]
    # One less 8 over the square of its size in usual sizes.
    # It learns from them a little.
    np.testing.assert_allclose(shares, [1.0 - 8.0 / 256.0, 0.5, 0.0], atol=0.02)


def test_a_camera_that_becomes_noisier_is_not_surprising_for_ever():
    pulls = Pulls(seed=3, share=0.3)
    innovation = Innovation()
    innovation.hold(pulls.gradient_covariance)
    for _ in range(200):
        innovation.least_fraction(pulls.draw())
    early = np.mean([innovation.least_fraction(pulls.draw(5.0)) for _ in range(20)])
    for _ in range(3000):
        innovation.least_fraction(pulls.draw(5.0))
    late = np.mean([innovation.least_fraction(pulls.draw(5.0)) for _ in range(100)])
    assert early > 0.3
    assert late < 0.05
