# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Patches: means with their Jacobian, and a covariance that says how far they may be off."""

from dataclasses import replace

from diffcal_ros.calibration.residuals.robust_residual import ResidualKind, Residuals
from diffcal_ros.diagnosis.patches.noise_model import NoiseModel
from diffcal_ros.diagnosis.patches.patches import _medians, depth_patches, edge_patches
from diffcal_ros.diagnosis.patches.whitened import _tolerant
import numpy as np
import pytest

NOISE = NoiseModel(pixel=0.00014)


def residuals(random: np.random.Generator, count: int = 4000) -> Residuals:
    pixels = random.integers(0, 80, size=(count, 2)).astype(np.int32)
    return Residuals(
        kind=ResidualKind.DEPTH,
        values=random.normal(scale=1e-4, size=count) + 1e-5 * pixels[:, 0],
        weights=np.ones(count),
        pixels=pixels,
        indices=np.arange(count, dtype=np.int32),
        missing=0.0,
    )


def test_patches_are_means_over_cells(random):
    given = residuals(random)
    jacobian = random.normal(size=(4000, 3))
    patches = depth_patches(given, jacobian, NOISE, 20)
    assert len(patches.values) == 16
    assert patches.weights.sum() == pytest.approx(4000, rel=0.01)
    in_first = (given.pixels < 20).all(axis=1)
    np.testing.assert_allclose(patches.values[0], given.values[in_first].mean(), atol=2e-6)
    np.testing.assert_allclose(patches.jacobian[0], jacobian[in_first].mean(axis=0), atol=0.05)
    np.testing.assert_allclose(patches.centers[0], given.pixels[in_first].mean(axis=0), atol=0.2)


def test_what_moves_nothing_has_no_slope_and_leaves_others_as_they_are(random):
    given, own = residuals(random), random.normal(size=(4000, 2))
    wide = np.zeros((4000, 5))
    wide[:, [1, 4]] = own
    patches = depth_patches(given, wide, NOISE, 20)
    np.testing.assert_array_equal(
        patches.jacobian[:, [1, 4]], depth_patches(given, own, NOISE, 20).jacobian
    )
    assert not patches.jacobian[:, [0, 2, 3]].any()


def test_flying_pixels_do_not_move_a_patch(random):
    given = residuals(random)
    clean = depth_patches(given, np.zeros((4000, 1)), NOISE, 20).values
    given.values[::25] += 0.05
    spoilt = depth_patches(given, np.zeros((4000, 1)), NOISE, 20).values
    np.testing.assert_allclose(spoilt, clean, atol=3e-5)


@pytest.mark.slow
def test_a_pixel_that_becomes_an_outlier_makes_no_step(random):
    """The average follows one pixel smoothly from the body to far before it."""
    given = residuals(random, 100)
    given.pixels[:] %= 10
    ways = np.arange(-0.003, 0.003, 2e-6)
    means = []
    for way in ways:
        values = given.values.copy()
        values[0] += way
        moved = replace(given, values=values)
        means.append(depth_patches(moved, np.zeros((100, 1)), NOISE, 10).values[0])
    followed = np.diff(means) / np.diff(ways)
    assert followed.max() > 0.5 / 100  # Near the others it counts like any of them,
    assert np.abs(followed).max() < 2.0 / 100  # at no place does it jump,
    assert means[-1] == pytest.approx(means[0], abs=2e-6)  # and far off it says nothing.


def test_of_an_uneven_patch_the_average_is_known_as_well_as_its_pixels_tell(random):
    """Where residuals run over 6 mm in a cell, other pixels of it give another average."""
    count, cells = 60, 400
    rows = np.arange(cells) * 20
    pixels = random.integers(0, 20, size=(cells, count, 2))
    pixels[..., 1] += rows[:, None]
    values = 0.0003 * (pixels[..., 0] - 9.5) + random.normal(scale=1e-4, size=(cells, count))
    given = Residuals(
        kind=ResidualKind.DEPTH,
        values=values.ravel(),
        weights=np.ones(values.size),
        pixels=pixels.reshape(-1, 2).astype(np.int32),
        indices=np.arange(values.size, dtype=np.int32),
        missing=0.0,
    )
    exact = NoiseModel(pixel=1e-4, smooth=0.0, rough=0.0)
    patches = depth_patches(given, np.zeros((values.size, 1)), exact, 20)
    assert len(patches.values) == cells
    assert patches.values.std() == pytest.approx(np.sqrt(patches.variances.mean()), rel=0.15)
    assert patches.variances.mean() > 100.0 * (1e-4**2 / count)


def test_covariance_is_that_of_errors_drawn_from_it(random):
    """Smooth errors are shared by neighbours, pixel noise averages out."""
    centers = np.array([[10.0, 10.0], [30.0, 10.0], [300.0, 200.0]])
    covariance = NOISE.depth_covariance(centers, np.array([400.0, 400.0, 400.0]))
    assert np.linalg.eigvalsh(covariance).min() > 0.0
    assert covariance[0, 1] > 0.9 * NOISE.smooth**2
    assert covariance[0, 2] < 1e-3 * NOISE.smooth**2
    # Where lengths are known by their order only some of it is all of the picture's.
    mixed = replace(NOISE, is_mixed=True).depth_covariance(centers, np.full(3, 400.0))
    assert 0.01 * NOISE.smooth**2 < mixed[0, 2] < 0.1 * NOISE.smooth**2
    pixel = covariance[0, 0] - NOISE.smooth**2 - NOISE.rough**2
    assert pixel == pytest.approx(NOISE.pixel**2 / 400.0)


def test_outline_in_doubt_says_less(random):
    given = residuals(random, 400)
    sizes, sure = np.full(400, 0.0006), np.zeros(400)
    plain = edge_patches(given, np.zeros((400, 1)), sizes, sure, NOISE, 20)
    doubtful = edge_patches(given, np.zeros((400, 1)), sizes, sure + 2.0, NOISE, 20)
    assert len(doubtful.values) == 0 or (
        np.diag(doubtful.covariance).min() > 4.0 * np.diag(plain.covariance).max()
    )
    mixed = np.where(given.pixels[:, 0] % 2, 2.0, 0.0)
    half = edge_patches(given, np.zeros((400, 1)), sizes, mixed, NOISE, 20)
    assert half.weights.sum() == pytest.approx(plain.weights.sum() / 2.0, rel=0.15)


def test_a_patch_that_is_far_off_counts_in_proportion():
    covariance = 1e-8 * np.eye(3)
    values = np.array([1e-4, 5e-4, 50e-4])
    inflated = _tolerant(covariance, values)
    counts = values**2 / np.diag(inflated)
    np.testing.assert_allclose(counts, [1.0, 25.0, 250.0])


def test_medians_of_all_cells_are_those_of_each(random):
    groups = random.integers(0, 40, size=1000)
    groups[:41] = np.arange(41)  # None is empty, and the last one has one member.
    values = random.standard_t(2, size=1000)
    expected = [np.median(values[groups == number]) for number in range(41)]
    assert {int(count % 2) for count in np.bincount(groups)} == {0, 1}
    np.testing.assert_array_equal(_medians(values, groups), expected)
