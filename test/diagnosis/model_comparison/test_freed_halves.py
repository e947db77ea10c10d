# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which effects are fitted in a form of their own, and which need not be."""

from dataclasses import replace
from types import SimpleNamespace

from diffcal_ros.calibration.parameters.form_parameters import form_parameters
from diffcal_ros.diagnosis.model_comparison import form_sizes, freed_rivals, selection
from diffcal_ros.diagnosis.model_comparison.any_form import tolerated
from diffcal_ros.diagnosis.model_comparison.form_ways import ways_of
from diffcal_ros.diagnosis.model_comparison.freed_rivals import with_halves_freed
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.model_comparison.refit_requests import RefitRequest
from diffcal_ros.diagnosis.model_comparison.selection import select
import pytest
from support.judged_models import refitted_with


@pytest.fixture(autouse=True)
def as_they_are(monkeypatch):
    """What is judged stays so, and what is freed as large as it was asked for."""
    monkeypatch.setattr(form_sizes, 'with_favoured_sizes', lambda _, model: model)
    monkeypatch.setattr(freed_rivals, 'judged', lambda models, *_, **__: list(models))


def _model(screened, basis, level: float, *names: str) -> Hypothesis:
    """Return a model of a level, judged, that owes nothing to forms."""
    model = refitted_with(screened, *names)
    judged = tolerated(model.fit, ways_of(model.evaluator.model, model.fit, basis, model.added))
    return replace(
        model, judged=replace(judged, log_evidence=level, exact=level, fraction=0.0, by_pose=0.0)
    )


@pytest.fixture(scope='module')
def bend(screened, basis) -> Hypothesis:
    return _model(screened, basis, -120.0, 'rest_curvature')


@pytest.fixture(scope='module')
def tilt(screened, basis) -> Hypothesis:
    return _model(screened, basis, -100.0, 'gravity_tilt')


@pytest.fixture(scope='module')
def both(screened, basis) -> Hypothesis:
    return _model(screened, basis, -80.0, 'rest_curvature', 'gravity_tilt')


class _Pool:
    """Refits that come to a level, and remember what was asked."""

    def __init__(self, bend: Hypothesis, level: float) -> None:
        judged = replace(bend.judged, log_evidence=level, exact=level)
        self.found, self.asked = replace(bend, judged=judged), list[RefitRequest]()

    def refit_all(self, requests):
        self.asked += requests
        return [self.found]


def test_half_of_a_pair_that_leads_is_tried_in_a_form_of_its_own(basis, bend, tilt, both):
    pool = _Pool(bend, -70.0)
    found = with_halves_freed(pool, [tilt, bend], [both], basis)
    (asked,) = pool.asked
    assert asked.added == bend.added
    assert asked.starts == bend.fit.values_by_name()
    # The library has no other form of a tilt.
    assert {own.effect for own in asked.freed} == {'rest_curvature'}
    assert all(own.posture is None for own in asked.freed)
    assert [model.level for model in found] == [-70.0, -100.0, -120.0]


@pytest.mark.parametrize('level', [-101.0, -100.0])
def test_half_of_a_pair_that_one_effect_does_as_well_as_is_not(basis, bend, tilt, both, level):
    judged = replace(both.judged, log_evidence=level, exact=level)
    pool = SimpleNamespace()
    singles = [tilt, bend]
    assert with_halves_freed(pool, singles, [replace(both, judged=judged)], basis) == singles
    assert with_halves_freed(pool, singles, [both], None) == singles
    assert with_halves_freed(pool, singles, [], basis) == singles


def test_what_is_of_a_form_of_its_own_already_is_not_tried_again(
    basis, bend, tilt, both, monkeypatch
):
    form = form_parameters(bend.added[0].effect, 0.1)
    freed = property(lambda model: tuple(form) if model is bend else ())
    monkeypatch.setattr(Hypothesis, 'freed', freed)
    assert with_halves_freed(SimpleNamespace(), [tilt, bend], [both], basis) == [tilt, bend]


@pytest.mark.parametrize('in_any_form', [True, False])
def test_of_what_cannot_matter_no_form_is_asked(screened, tilt, monkeypatch, in_any_form):
    evaluator, nominal, scores = screened
    asked: list[str] = []

    def freed(_, models, *rest):
        asked.append('freed')
        return list(models)

    def others(*_):
        asked.append('others')
        return []

    monkeypatch.setattr(selection, 'refitted_singles', lambda *_, **__: [tilt])
    monkeypatch.setattr(selection, 'with_those_freed', freed)
    monkeypatch.setattr(selection, 'others_in_any_form', others)
    pool = RefitPool(evaluator, nominal)
    found = select(pool, scores, with_pairs=False, in_any_form=in_any_form)
    assert asked == (['freed', 'others'] if in_any_form else [])
    assert [model.identifiers for model in found.singles] == [('gravity_tilt',)]
