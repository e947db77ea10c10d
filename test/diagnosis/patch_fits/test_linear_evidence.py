# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The evidence of further errors is that of the whole covariance."""

from dataclasses import replace

from diffcal_ros.diagnosis.patch_fits.linear_evidence import LinearEvidence
from diffcal_ros.diagnosis.patches.regularised_prior import regularised_prior
from diffcal_ros.diagnosis.patches.whitened import precision_of
import numpy as np
import pytest
from scipy.stats import multivariate_normal


def _evidence(random, count):
    root = random.normal(size=(count, count))
    covariance = root @ root.T / count + 0.1 * np.eye(count)
    values = random.normal(size=count)
    weights = np.linalg.inv(covariance)
    return covariance, values, LinearEvidence(weights, weights @ values)


@pytest.mark.parametrize('places', [None, [3, 1, 7]])
def test_gain_is_the_ratio_of_two_densities(places):
    random = np.random.default_rng(2)
    covariance, values, evidence = _evidence(random, 12)
    own = np.arange(12) if places is None else np.array(places)
    ways = np.zeros((12, 2))
    ways[own] = random.normal(size=(len(own), 2))
    sizes = np.array([0.3, 2.0])
    ratios = [
        multivariate_normal.pdf(values, cov=covariance + size**2 * ways @ ways.T)
        / multivariate_normal.pdf(values, cov=covariance)
        for size in sizes
    ]
    expected = np.log(np.mean(ratios))
    where = None if places is None else own
    assert evidence.gain(ways[own], sizes, where) == pytest.approx(expected, rel=1e-9)


def test_parameters_are_integrated_out_from_what_is_known_of_them(screened):
    _, fit, _ = screened
    groups = [group for group in fit.groups if len(group.patches.values)]
    evidence = LinearEvidence.of_fit(fit, groups)
    tangents = np.concatenate([group.patches.jacobian for group in groups])
    mean, precision = regularised_prior(fit.parameters)
    covariance = np.linalg.inv(precision_of(groups))
    whole = covariance + tangents @ np.linalg.inv(precision) @ tangents.T
    values = np.concatenate([group.patches.values for group in groups])
    expected = values + tangents @ (fit.coordinates - mean)
    assert np.allclose(whole @ evidence.weights, np.eye(len(values)), atol=1e-6)
    assert np.allclose(whole @ evidence.pulls, expected, atol=1e-9)


@pytest.mark.parametrize('step', [0.05, 0.1, 0.2])
def test_residuals_fall_by_their_tangents(screened, step):
    """So what is expected of them where a parameter is known to be is more, not less."""
    evaluator, fit, _ = screened
    place = fit.parameters.names.index('edge_bias')
    moved = np.zeros(len(fit.coordinates))
    moved[place] = step
    edges, ahead, back = (
        next(own.patches for own in groups if own.kind == 'edge')
        for groups in (
            fit.groups,
            *(evaluator.groups(fit.coordinates + d) for d in (moved, -moved)),
        )
    )
    assert np.array_equal(ahead.cells, edges.cells)
    assert np.array_equal(back.cells, edges.cells)
    slopes = (ahead.values - back.values) / (2.0 * step)
    tangents = edges.jacobian[:, place]
    assert slopes @ tangents / (tangents @ tangents) == pytest.approx(-1.0, abs=0.3)


def test_a_residual_that_the_rest_does_not_foretell_is_off(screened):
    _, fit, _ = screened
    first = fit.groups[0]
    values = np.zeros(len(first.patches.values))
    values[4] = 0.004
    quiet = [
        replace(b, patches=replace(b.patches, values=np.zeros(len(b.patches.values))))
        for b in fit.groups
    ]
    quiet[0] = replace(first, patches=replace(first.patches, values=values))
    mean, _ = regularised_prior(fit.parameters)
    still = replace(fit, coordinates=mean - fit.shifts)
    off = LinearEvidence.of_fit(still, quiet).offsets() > 4.0
    assert off[4]
    assert off.sum() < 0.2 * len(off)
