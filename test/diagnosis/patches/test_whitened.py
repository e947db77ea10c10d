# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Patches in units of their noise, and what they cost by it."""

from dataclasses import replace

from diffcal_ros.diagnosis.patches.noise_model import CommonError, kernel
from diffcal_ros.diagnosis.patches.patch_group import PatchGroup
from diffcal_ros.diagnosis.patches.whitened import independent_count, Part, whiten
import numpy as np
import pytest
from scipy.stats import multivariate_normal
from support.unit_patches import unit_group


def _uneven(standing: float) -> tuple[list[PatchGroup], list[np.ndarray], list[np.ndarray]]:
    """Return patches of two views, with the covariances of each and those if they were even."""
    random = np.random.default_rng(6)
    groups, covariances, evens = [], [], []
    for view in range(2):
        own = unit_group(random.normal(size=7))
        centers, uneven = random.uniform(0.0, 200.0, (7, 2)), random.uniform(0.0, 3.0, 7)
        even = np.diag(random.uniform(0.5, 2.0, 7)) + 0.5 * kernel(centers, 80.0)
        error = CommonError(np.full(7, standing), 80.0)
        patches = replace(
            own.patches,
            covariance=even + np.diag(uneven),
            centers=centers,
            standing=error,
            uneven=uneven,
        )
        groups.append(replace(own, view=view, recording=view, patches=patches))
        covariances.append(even + np.diag(uneven) + error.covariance(centers))
        evens.append(even + error.covariance(centers))
    return groups, covariances, evens


def _log_determinant(matrix: np.ndarray) -> float:
    return float(np.linalg.slogdet(matrix)[1])


@pytest.mark.parametrize('standing', [0.0, 0.4])
def test_uneven_patches_cost_what_their_variance_adds_to_the_log_determinant(standing):
    groups, covariances, evens = _uneven(standing)
    seen = whiten(groups, Part.ALL, is_apart=True)
    found = [seen.volumes[seen.views == view].sum() for view in range(2)]
    expected = [
        _log_determinant(one) - _log_determinant(other)
        for one, other in zip(covariances, evens, strict=True)
    ]
    np.testing.assert_allclose(found, expected, rtol=1e-9)
    flat = [replace(one, patches=replace(one.patches, uneven=None)) for one in groups]
    assert whiten(flat, Part.ALL).volume == 0.0


def test_what_views_have_in_common_is_in_that_determinant():
    groups, covariances, evens = _uneven(0.4)
    centers = np.concatenate([one.patches.centers for one in groups])
    across = 0.4**2 * kernel(centers, 80.0)[:7, 7:]
    whole, even = (
        np.block([[two[0], across], [across.T, two[1]]]) for two in (covariances, evens)
    )
    expected = _log_determinant(whole) - _log_determinant(even)
    assert whiten(groups, Part.ALL).volume == pytest.approx(expected)
    assert whiten(groups, Part.ALL, is_apart=True).volume != pytest.approx(expected, rel=1e-4)


def test_a_patch_counts_less_by_what_is_left_of_it_where_that_is_told():
    """Beyond five standard deviations, and then in proportion to how far off it is."""
    far = unit_group([20.0, 1.0])
    seen = whiten([far], Part.ALL)
    assert seen.has_far_off
    np.testing.assert_allclose(seen.values, [20.0 / np.sqrt(20.0 / 5.0), 1.0])
    near = replace(far, patches=replace(far.patches, left=np.array([4.0, 1.0])))
    seen = whiten([near], Part.ALL)
    assert not seen.has_far_off
    np.testing.assert_allclose(seen.values, [20.0, 1.0])
    part = near.patches.chosen(np.array([1]))
    np.testing.assert_array_equal(part.left, [1.0])


def test_being_far_off_adds_to_the_log_determinant():
    """A view that is off as a whole tells what it has in common by far less than its noise."""
    random = np.random.default_rng(8)
    centers = random.uniform(0.0, 200.0, (30, 2))
    common = CommonError(np.full(30, 8.0), 2000.0)

    def seen(values):
        own = unit_group(values)
        own = replace(own, patches=replace(own.patches, centers=centers, standing=common))
        return own.patches, whiten([own], Part.ALL)

    noise = random.normal(size=30)
    _, held = seen(2.0 * noise)
    assert held.tolerance == 0.0
    assert not held.has_far_off
    patches, loose = seen(60.0 + 0.5 * noise)
    covariance = patches.covariance + common.covariance(centers)
    own = np.diag(covariance)
    grown = own * (np.abs(patches.values) / (5.0 * np.sqrt(own)) - 1.0)
    expected = _log_determinant(covariance + np.diag(grown)) - _log_determinant(covariance)
    assert loose.tolerance == pytest.approx(expected)
    assert loose.volume == held.volume == 0.0
    # By the squares alone the one that is farther off would be the likelier one.
    assert loose.chi_square < 0.7 * held.chi_square
    assert loose.chi_square + loose.tolerance > 1.1 * held.chi_square


@pytest.mark.parametrize('standing', [0.0, 0.4])
@pytest.mark.parametrize('farther', [0.0, 30.0])
def test_all_that_a_density_costs_is_the_determinant_of_the_covariance(standing, farther):
    """Uneven, far off or near: a larger error is less likely where little is left."""
    groups, covariances, evens = _uneven(standing)
    groups = [
        replace(own, patches=replace(own.patches, values=own.patches.values + farther * (n == 0)))
        for n, own in enumerate(groups)
    ]
    seen = whiten(groups, Part.ALL, is_apart=True)
    whole = seen.chi_square + seen.volume + seen.tolerance + seen.sizes.sum()
    expected, even = 0.0, sum(_log_determinant(one) for one in evens)
    for own, covariance in zip(groups, covariances, strict=True):
        values, spread = own.patches.values, np.sqrt(np.diag(covariance))
        grown = np.diag(covariance) * np.maximum(np.abs(values) / (5.0 * spread) - 1.0, 0.0)
        counted = covariance + np.diag(grown)
        expected += -2.0 * multivariate_normal.logpdf(values, np.zeros(7), counted)
    assert whole + 14.0 * np.log(2.0 * np.pi) == pytest.approx(expected, rel=1e-9)
    assert (seen.sizes.sum() == pytest.approx(even)) == (farther == 0.0)


@pytest.mark.parametrize('standing', [0.0, 2.0])
def test_the_size_of_noise_scatters_as_that_of_so_many_independent_patches(standing, random):
    groups, _, _ = _uneven(standing)
    covariance = np.zeros((14, 14))
    for view, own in enumerate(groups):
        rows = slice(7 * view, 7 * view + 7)
        covariance[rows, rows] = own.patches.covariance
    # What stands in all images is the same at the same place of each.
    centers = np.concatenate([own.patches.centers for own in groups])
    covariance += CommonError(np.full(14, standing), 80.0).covariance(centers)
    count = independent_count(groups, Part.ALL)
    assert 1.0 < count < 14.0
    drawn = random.multivariate_normal(np.zeros(14), covariance, size=200_000)
    squares = np.square(drawn).mean(axis=1)
    assert 2.0 * squares.mean() ** 2 / squares.var() == pytest.approx(count, rel=0.03)


def test_patches_that_share_nothing_count_one_each():
    assert independent_count([unit_group(np.zeros(9))], Part.REPORT) == pytest.approx(9.0)
    rigid = replace(unit_group(np.zeros(5)), is_rigid=True)
    assert independent_count([unit_group(np.zeros(9)), rigid], Part.REPORT) == pytest.approx(9.0)
