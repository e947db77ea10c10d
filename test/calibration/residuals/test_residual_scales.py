# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Widths follow the bulk of the residuals down, and stop where the sensor's structure begins."""

from diffcal_ros.calibration.residuals.residual_scales import FINAL_WIDTH, Scale, Scales, spread
from diffcal_ros.calibration.residuals.robust_residual import ResidualKind, Residuals
import numpy as np
import pytest


def _residuals(values) -> Residuals:
    values = np.asarray(values, dtype=float)
    nowhere = np.zeros((len(values), 2), dtype=np.int32)
    kind = ResidualKind.DEPTH
    return Residuals(kind, values, np.ones(len(values)), nowhere, np.arange(len(values)), 0.0)


def test_a_width_follows_the_bulk_and_no_outlier() -> None:
    values = [0.004] * 85 + [0.5] * 15
    annealed = Scale(width=0.02).annealed([_residuals(values)])
    assert annealed.width == annealed.noise == pytest.approx(0.004)


def test_a_width_at_least_halves_and_never_passes_its_end() -> None:
    wide = [_residuals([0.018] * 10)]
    scale = Scale(width=0.02)
    widths = [(scale := scale.annealed(wide)).width for _ in range(6)]
    assert widths == pytest.approx([0.01, 0.005, 0.0025, FINAL_WIDTH, FINAL_WIDTH, FINAL_WIDTH])
    assert Scale(width=0.02).annealed([_residuals([1e-5] * 10)]).width == FINAL_WIDTH


def test_the_view_that_is_off_most_decides() -> None:
    fits, off = _residuals([1e-4] * 50), _residuals([0.006] * 5)
    assert Scale(width=0.02).annealed([fits, off]).width == pytest.approx(0.006)
    assert Scale(width=0.02).annealed([]).width == FINAL_WIDTH
    assert Scale(width=0.02).annealed([_residuals([])]).width == FINAL_WIDTH


def test_known_noise_sets_width_and_what_residuals_are_worth() -> None:
    scale = Scale(correlation=8.0).refined(2e-4, 12.0, 3.0)
    # Cauchy's weights at 95 % efficiency.
    assert scale.width == pytest.approx(2.385 * 2e-4)
    assert scale.noise == 2e-4
    # A length that was measured longer than before is not believed.
    assert scale.correlation == 8.0
    assert scale.patch(2) == pytest.approx(3.0 * 64.0)
    assert scale.patch(1) == pytest.approx(3.0 * 8.0)


def test_scales_are_final_when_both_are() -> None:
    end = Scale(noise=FINAL_WIDTH)
    assert Scales(end, end).are_final
    assert not Scales(end, Scale(noise=1.1 * FINAL_WIDTH)).are_final
    assert not Scales(Scale(noise=1.1 * FINAL_WIDTH), end).are_final


def test_spread_is_the_standard_deviation_of_noise_with_a_few_outliers(random) -> None:
    noise = random.normal(0.0, 3e-4, 20_000)
    noise[:200] = 1.0
    assert spread(_residuals(noise)) == pytest.approx(3e-4, rel=0.04)
    assert spread(_residuals([])) == 0.0
