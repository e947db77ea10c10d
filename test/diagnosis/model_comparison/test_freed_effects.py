# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which models are fitted with effects that are free to be others."""

from dataclasses import replace

from diffcal_ros.diagnosis.model_comparison import form_sizes, freed_effects, freedom
from diffcal_ros.diagnosis.model_comparison.freed_effects import with_those_freed
from diffcal_ros.diagnosis.model_comparison.freedom import freed_parts
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
import pytest
from support.freed import judged_model, Refits, with_parts


@pytest.fixture(autouse=True)
def as_large_as_they_were(monkeypatch):
    """What is freed here stays as large as it was asked for; see test_form_sizes."""
    monkeypatch.setattr(form_sizes, 'with_favoured_sizes', lambda _, model: model)


@pytest.fixture(scope='module')
def clamp(screened, basis) -> Hypothesis:
    return judged_model(screened, basis, 'clamp_offset', 0.3)


def test_only_what_may_be_clamped_or_moved_anew_and_may_win_is_fitted_so(screened, basis, clamp):
    assert freed_effects._may_win(clamp, clamp.level)
    same = replace(clamp, judged=replace(clamp.judged, by_pose=0.05))
    assert not freed_effects._may_win(same, clamp.level)
    noise = 0.5 * max(clamp.chi_square - clamp.judged.freedom, 0.0)
    assert freed_effects._may_win(clamp, clamp.log_evidence + noise - 0.1)
    assert not freed_effects._may_win(clamp, clamp.log_evidence + noise + 0.1)
    exact = clamp.judged.log_evidence - 40.0
    sure = replace(clamp, judged=replace(clamp.judged, exact=exact))
    assert not freed_effects._may_win(sure, clamp.level), 'forms decide nothing'
    load = judged_model(screened, basis, 'gravity_tilt', 0.9)
    assert not freed_effects._may_win(load, load.level)


def test_where_models_are_judged_as_they_are_they_stay_so(screened, clamp):
    evaluator, nominal, _ = screened
    assert with_those_freed(RefitPool(evaluator, nominal), [clamp], None) == [clamp]


@pytest.mark.parametrize(('gains', 'rounds'), [((5.0, 5.0), 2), ((-5.0,), 1)])
def test_what_shows_once_a_form_is_free_is_freed_as_well(
    screened, basis, monkeypatch, gains, rounds
):
    camera = judged_model(screened, basis, 'camera_offset', 0.05, 0.4)
    refits = Refits(gains, camera)
    monkeypatch.setattr(freedom, 'judged', lambda models, *_, **__: list(models))
    found = freed_effects._freed_as_it_wants(refits, camera, basis, camera.level)
    forms, parts = len(camera.added[0].effect.forms), len(camera.added[0].names)
    assert refits.asked == [forms, forms + parts][:rounds]
    assert found.level == pytest.approx(max(camera.level, camera.level + sum(gains)))


@pytest.mark.parametrize(
    ('is_converged', 'is_freed', 'left', 'is_better'),
    [
        (False, True, 0.9, True),
        (False, True, 1.1, False),
        (True, True, 0.9, False),
        (False, False, 0.9, False),
    ],
)
def test_the_best_is_fitted_to_the_end_where_it_is_free(
    screened, basis, clamp, monkeypatch, is_converged, is_freed, left, is_better
):
    monkeypatch.setattr(freed_effects, 'judged', lambda models, *_, **__: list(models))
    parts = freed_parts(clamp) if is_freed else []
    model = with_parts(clamp, parts)
    model = replace(model, fit=replace(model.fit, is_converged=is_converged))
    assert bool(model.freed) == is_freed
    refits = Refits(())
    refits.left = left
    found = freed_effects._to_the_end(refits, model, basis)
    assert refits.ended == (is_freed and not is_converged)
    assert found.fit.chi_square == (left if is_better else 1.0) * model.fit.chi_square
