# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effects that are free to be others are as large in each way as the data favour."""

from dataclasses import replace

from diffcal_ros.diagnosis.model_comparison import form_sizes, looks_in_any_form
from diffcal_ros.diagnosis.model_comparison.any_form import log_prior
from diffcal_ros.diagnosis.model_comparison.form_sizes import with_favoured_sizes
from diffcal_ros.diagnosis.model_comparison.owed_to_poses import owed_to_poses
from diffcal_ros.diagnosis.patches.whitened import Part, whiten
import numpy as np
import pytest
from scipy.stats import multivariate_normal
from support.clamped_anew import CLAMP


def test_levels_are_densities_of_what_is_seen(anew_clamp):
    """By the covariance of what is seen, against products of what parameters do."""
    fit, random = anew_clamp.fit, np.random.default_rng(2)
    seen = whiten(fit.groups, Part.FIT)
    offset, before = fit.prior_offset()
    expected, known = seen.values + seen.jacobian @ offset, np.linalg.inv(before)
    products = form_sizes.Products.of(fit, seen)
    levels, densities = [], []
    # Sizes scale rows and columns of what is known: nothing ties what is freed to anything.
    free = [own.is_freed for own in fit.parameters]
    for _ in range(3):
        sizes = np.where(free, 10.0 ** random.uniform(-1.0, 0.5, len(free)), 1.0)
        covariance = seen.jacobian @ (known * np.outer(sizes, sizes)) @ seen.jacobian.T
        covariance += np.eye(len(expected))
        densities.append(multivariate_normal(cov=covariance).logpdf(expected))
        levels.append(products.level(sizes))
        # And by the normal equations of what is known and seen.
        precision = np.linalg.inv(known * np.outer(sizes, sizes))
        information = seen.jacobian.T @ seen.jacobian + precision
        step = np.linalg.solve(information, seen.jacobian.T @ seen.values - precision @ offset)
        np.testing.assert_allclose(products.step(sizes), step, rtol=1e-6, atol=1e-12)
        expected_covariance = np.linalg.inv(information)
        sizes_of_all = np.sqrt(np.diag(expected_covariance))
        found = products.covariance(sizes) / np.outer(sizes_of_all, sizes_of_all)
        expected_covariance /= np.outer(sizes_of_all, sizes_of_all)
        np.testing.assert_allclose(found, expected_covariance, atol=1e-6)
    assert np.ptp(densities) > 5.0
    np.testing.assert_allclose(np.diff(levels), np.diff(densities), rtol=1e-6, atol=1e-6)


def test_each_way_has_the_likeliest_of_some_sizes(anew_clamp):
    shares = form_sizes.favoured_shares(anew_clamp.fit)
    assert set(shares) == {own.name for own in anew_clamp.freed}
    names = anew_clamp.fit.parameters.names
    products = form_sizes.Products.of(anew_clamp.fit, whiten(anew_clamp.fit.groups, Part.FIT))
    belief = dict(zip(form_sizes._SHARES.tolist(), log_prior(form_sizes._SHARES), strict=True))
    for way in CLAMP:
        own = [f'clamp_offset.{way}@{pose}' for pose in range(3)]
        # All poses of one amplitude have a size in common.
        (chosen,) = {shares[name] for name in own}
        levels = {}
        for share, believed in belief.items():
            sizes = {**shares, **dict.fromkeys(own, share)}
            every = np.array([sizes.get(name, 1.0) for name in names])
            levels[share] = products.level(every) + believed
        assert max(levels, key=levels.__getitem__) == chosen
    assert len(set(shares.values())) > 1


def test_a_model_is_likelier_with_them_and_what_is_not_free_stays_as_it_is(anew_pool, anew_clamp):
    shares, sized = (
        form_sizes.favoured_shares(anew_clamp.fit),
        with_favoured_sizes(anew_pool, anew_clamp),
    )
    for own, before in zip(sized.freed, anew_clamp.freed, strict=True):
        assert own.quantity.prior_std == shares[own.name] * before.quantity.prior_std
    assert sized.fit.log_evidence > anew_clamp.fit.log_evidence + 2.0
    assert not sized.fit.is_converged, 'it has to be fitted there'
    same = replace(anew_clamp, fit=anew_pool.base)
    assert with_favoured_sizes(anew_pool, same) is same


@pytest.mark.slow
def test_what_is_owed_to_poses_is_what_the_same_in_all_would_lack(anew_pool, anew_clamp):
    owed = owed_to_poses(anew_clamp, anew_pool.nominal, anew_pool.base)
    (same,) = anew_pool.refit_all([looks_in_any_form._freed(anew_clamp.added[0], (), 12)])
    lacks = anew_clamp.fit.log_evidence - same.fit.log_evidence
    assert lacks > 100.0
    assert owed == pytest.approx(lacks, rel=0.3)
    assert owed_to_poses(same, anew_pool.nominal, anew_pool.base) == 0.0
