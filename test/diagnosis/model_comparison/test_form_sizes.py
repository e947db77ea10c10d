# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effects that are free to be others are as large in each way as the data favour."""

from dataclasses import replace

from diffcal_ros.diagnosis.diagnose import fit_nominal
from diffcal_ros.diagnosis.model_comparison import form_sizes, looks_in_any_form
from diffcal_ros.diagnosis.model_comparison.any_form import log_prior
from diffcal_ros.diagnosis.model_comparison.form_sizes import with_favoured_sizes
from diffcal_ros.diagnosis.model_comparison.owed_to_poses import owed_to_poses
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.patches.whitened import Part, whiten
from diffcal_ros.diagnosis.screening.candidates import candidates
import numpy as np
import pytest
from scipy.stats import multivariate_normal
from support.clamped_anew import clamped_anew

_CLAMP = ('x', 'y', 'z', 'rx', 'ry', 'rz')


@pytest.fixture(scope='module')
def pool():
    """Who refits models of a beam in three poses that was clamped anew for each."""
    return RefitPool(*fit_nominal(*clamped_anew(), None))


@pytest.fixture(scope='module')
def clamp(pool):
    """A clamp that is another one in each pose."""
    listed = candidates(pool.nominal.model.scene)
    own = next(c for c in listed if (c.identifier, c.components) == ('clamp_offset', _CLAMP))
    parts = looks_in_any_form._in_each_pose(pool, own)
    assert [part.name for part in parts] == [f'{n}@{p}' for n in own.names for p in range(3)]
    (found,) = pool.refit_all([looks_in_any_form._freed(own, parts, 8)])
    return found


def test_levels_are_densities_of_what_is_seen(clamp):
    """By the covariance of what is seen, against products of what parameters do."""
    fit, random = clamp.fit, np.random.default_rng(2)
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
    assert np.ptp(densities) > 5.0
    np.testing.assert_allclose(np.diff(levels), np.diff(densities), rtol=1e-6, atol=1e-6)


def test_each_way_has_the_likeliest_of_some_sizes(clamp):
    shares = form_sizes.favoured_shares(clamp.fit)
    assert set(shares) == {own.name for own in clamp.freed}
    names = clamp.fit.parameters.names
    products = form_sizes.Products.of(clamp.fit, whiten(clamp.fit.groups, Part.FIT))
    belief = dict(zip(form_sizes._SHARES.tolist(), log_prior(form_sizes._SHARES), strict=True))
    for way in _CLAMP:
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


def test_a_model_is_likelier_with_them_and_what_is_not_free_stays_as_it_is(pool, clamp):
    shares, sized = form_sizes.favoured_shares(clamp.fit), with_favoured_sizes(pool, clamp)
    for own, before in zip(sized.freed, clamp.freed, strict=True):
        assert own.quantity.prior_std == shares[own.name] * before.quantity.prior_std
    assert sized.fit.log_evidence > clamp.fit.log_evidence + 2.0
    assert not sized.fit.is_converged, 'it has to be fitted there'
    same = replace(clamp, fit=pool.base)
    assert with_favoured_sizes(pool, same) is same


def test_what_is_owed_to_poses_is_what_the_same_in_all_would_lack(pool, clamp):
    owed = owed_to_poses(clamp, pool.nominal, pool.base)
    (same,) = pool.refit_all([looks_in_any_form._freed(clamp.added[0], (), 12)])
    lacks = clamp.fit.log_evidence - same.fit.log_evidence
    assert lacks > 100.0
    assert owed == pytest.approx(lacks, rel=0.3)
    assert owed_to_poses(same, pool.nominal, pool.base) == 0.0
