# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The class of a cause by fields that predict views they have not seen."""

from diffcal_ros.diagnosis.patch_fits.free_fields import free_fields
from diffcal_ros.diagnosis.verdict.frame_test import frame_test, prediction
import numpy as np
import pytest
from scipy.stats import multivariate_normal

_ONE_MILLIMETRE = 1e-3


def test_prediction_is_the_sum_of_conditional_densities():
    """By Schur complements, which share nothing with the ratio of densities but the covariance."""
    random = np.random.default_rng(4)
    views = np.array([0, 0, 0, 1, 1, 2, 2, 2, 2])
    half = random.normal(size=(len(views), 5))
    covariance, values = np.eye(len(views)) + half @ half.T, random.normal(size=len(views))
    expected = 0.0
    for view in range(3):
        own, rest = np.flatnonzero(views == view), np.flatnonzero(views != view)
        across = covariance[np.ix_(own, rest)] @ np.linalg.inv(covariance[np.ix_(rest, rest)])
        spread = covariance[np.ix_(own, own)] - across @ covariance[np.ix_(rest, own)]
        mean = across @ values[rest]
        density = multivariate_normal(mean, spread).logpdf(values[own])
        expected += density + 0.5 * len(own) * np.log(2.0 * np.pi)
    assert prediction(covariance, values, views) == pytest.approx(expected, rel=1e-10)


def test_fields_of_all_classes_are_of_one_size(screened):
    evaluator, fit, _ = screened
    fields = free_fields(evaluator.model, fit.coordinates)
    assert set(fields) == {'sensor', 'load', 'boundary', 'shape', 'material'}
    for views in fields.values():
        sizes = np.sqrt(np.mean([(f**2).sum(axis=2).mean(axis=1) for f in views], axis=0))
        assert sizes == pytest.approx(_ONE_MILLIMETRE)


def test_shape_fields_turn_with_the_body(screened):
    """Towards the tip a field along the body's own axis follows the bent body, not the world."""
    evaluator, fit, _ = screened
    (fields,) = free_fields(evaluator.model, fit.coordinates)['shape']
    model = evaluator.model
    view = model.views(fit.coordinates)[0]
    body = model.body(model.observations[0])
    share = model.effects.axes(0).fraction(body.discretisation.rest_nodes)
    tip, before = share > 0.9, (share > 0.7) & (share < 0.8)
    along = view.points[tip].mean(axis=0) - view.points[before].mean(axis=0)
    stretch = fields[0][tip].mean(axis=0)
    cosine = along @ stretch / np.linalg.norm(along) / np.linalg.norm(stretch)
    assert cosine > np.cos(np.radians(10.0))


def test_one_view_tells_no_class(screened):
    evaluator, fit, _ = screened
    assert frame_test(evaluator, fit) == ()


def test_depths_that_are_read_by_angle_move_along_their_rays(screened):
    evaluator, fit, _ = screened
    (fields,) = free_fields(evaluator.model, fit.coordinates)['sensor']
    view = evaluator.model.views(fit.coordinates)[0]
    once, twice = fields[-2:]
    np.testing.assert_allclose(np.cross(once, view.points), 0.0, atol=1e-12)
    # By the vectors of area of the triangles around a node inside a face, all of one direction.
    triangles = view.tracer.triangles
    a, b, c = (view.points[triangles[:, corner]] for corner in range(3))
    areas = np.cross(b - a, c - a)
    whole, sizes = np.zeros_like(view.points), np.zeros(len(view.points))
    for corner in range(3):
        np.add.at(whole, triangles[:, corner], areas)
        np.add.at(sizes, triangles[:, corner], np.linalg.norm(areas, axis=1))
    towards = -view.points
    facing = (whole * towards).sum(axis=1) / np.linalg.norm(towards, axis=1)
    seen = (np.linalg.norm(whole, axis=1) > 0.99 * sizes) & (facing > 0.0)
    aslant = 1.0 - facing[seen] / sizes[seen]
    away = np.linalg.norm(towards, axis=1)
    told = [(np.linalg.norm(field, axis=1) / away)[seen] for field in (once, twice)]
    assert seen.sum() > 20
    assert np.ptp(aslant) > 0.05
    slope = (told[0] @ aslant) / (aslant @ aslant)
    np.testing.assert_allclose(told[0], slope * aslant, atol=0.02 * told[0].max())
    assert np.ptp(told[1] / told[0] ** 2) < 1e-6 * (told[1] / told[0] ** 2).max()
