# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A second effect beside a fitted one begins where that is."""

from dataclasses import replace

from diffcal_ros.diagnosis.model_comparison import effect_refit, swapped_pairs
from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.model_comparison.refit_rounds import request_beside
from diffcal_ros.diagnosis.screening.shortlist import distinct, starts_of
import numpy as np
import pytest


@pytest.fixture(scope='module')
def both(screened):
    """Scores of two effects."""
    scores = {own.candidate.identifier: own for own in distinct(screened[2].scores)}
    return scores['depth_affine'], scores['gravity_tilt']


@pytest.fixture(scope='module')
def one(screened, both):
    """The first of them, fitted."""
    evaluator, nominal, _ = screened
    return try_effects(evaluator, nominal, [both[0].candidate], starts_of(both[0]))


def test_it_begins_where_the_fitted_model_is(screened, both, one):
    evaluator, nominal, _ = screened
    added = [score.candidate for score in both]
    begun = try_effects(evaluator, nominal, added, one.fit.values_by_name(), max_iterations=1)
    values = begun.fit.values_by_name()
    assert {name: values[name] for name in one.fit.values_by_name()} == one.fit.values_by_name()
    assert [values[name] for name in added[1].names] == [0.0] * len(added[1].names)
    assert begun.fit.chi_square == pytest.approx(one.fit.chi_square, rel=1e-6)
    ended = try_effects(evaluator, nominal, added, one.fit.values_by_name())
    assert ended.fit.log_evidence >= begun.fit.log_evidence


def test_one_that_was_fitted_is_looked_for_nowhere_else(screened, both, one, monkeypatch):
    evaluator, nominal, _ = screened
    asked = []

    def starts(_, __, added):
        asked.append([own.identifier for own in added])
        return [{}]

    monkeypatch.setattr(effect_refit, 'more_starts', starts)
    added = [score.candidate for score in both]
    tangents = {name: value for score in both for name, value in starts_of(score).items()}
    for begin in (one.fit.values_by_name(), tangents):
        try_effects(evaluator, nominal, added, begin, max_iterations=1)
    # Where tangents lead nothing was fitted.
    assert asked == [['gravity_tilt'], ['depth_affine', 'gravity_tilt']]


def test_patches_count_in_full_only_where_nothing_that_was_fitted_is_gone(screened, both, one):
    evaluator, nominal, _ = screened
    added = [score.candidate for score in both]
    beside = request_beside(one.fit.values_by_name(), added, both[1], [], ())
    whole = beside.fit(evaluator, nominal)
    assert whole.pace.is_close, 'it is fitted on likewise'
    alone = try_effects(evaluator, nominal, added[:1], starts_of(both[0]))
    assert not alone.fit.pace.is_close
    pair = replace(one, added=tuple(added), fit=whole)
    swapped = swapped_pairs._request(pair, added[1], both[0], [one])
    assert not swapped.fit(evaluator, nominal).pace.is_close


class _Watched(RefitPool):
    """Refits, and keeps what it was asked for."""

    def _fits(self, tasks):
        self.tasks = tasks
        return super()._fits(tasks)


def test_how_large_it_may_be_is_told_by_where_tangents_lead(screened, both, one):
    evaluator, nominal, _ = screened
    added, pool = [score.candidate for score in both], _Watched(evaluator, nominal)
    request = request_beside(one.fit.values_by_name(), added, both[1], [], ())
    assert not set(added[1].names) & request.starts.keys()
    far = {name: 9.0 * size for name, size in zip(added[1].names, added[1].scales, strict=True)}
    sizes = []
    for expected in (starts_of(both[1]), far):
        request.expected.update(expected)
        (found,) = pool.refit_all([request])
        sizes.append(pool.tasks[0].added[1].size)
        assert np.isfinite(found.fit.log_evidence)
    assert sizes[1] > sizes[0]
