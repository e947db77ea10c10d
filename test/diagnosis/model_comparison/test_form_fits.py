# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Models where a fit that knows of forms would have them."""

from dataclasses import replace
from types import SimpleNamespace

from diffcal_ros.diagnosis.model_comparison import form_fits
from diffcal_ros.diagnosis.model_comparison.any_form import tolerated
from diffcal_ros.diagnosis.model_comparison.form_fits import each_alone, one_of_each
from diffcal_ros.diagnosis.model_comparison.form_ways import ways_of
import pytest
from support.judged_models import refitted_with


def test_each_effect_of_a_pair_stands_alone_where_it_is_simulated(screened, basis):
    evaluator, nominal, _ = screened
    pool = SimpleNamespace(nominal=evaluator, base=nominal)
    pair = refitted_with(screened, 'gravity_tilt', 'depth_affine')
    alone = each_alone(pool, pair, basis)
    (tilt,) = [model for model in alone if model.identifiers == ('gravity_tilt',)]
    # Nothing but the tilt is there: alone it is where the pair had it, and leaves no more.
    fitted = refitted_with(screened, 'gravity_tilt')
    errors = fitted.fit.covariance.diagonal() ** 0.5
    assert abs((tilt.fit.coordinates - fitted.fit.coordinates) / errors).max() < 0.5
    assert tilt.fit.log_evidence == pytest.approx(fitted.fit.log_evidence, abs=0.5)
    # A depth that is read wrong does not bend the body.
    assert all(model.fit.chi_square < nominal.chi_square for model in alone)


def test_what_has_lost_the_body_from_view_is_no_model_of_it(screened):
    """It leaves nothing, since it sees nothing; beside it no two models would share a patch."""
    tilt = refitted_with(screened, 'gravity_tilt')
    _, nominal, _ = screened
    fit = tilt.fit
    blind = replace(tilt, fit=replace(fit, chi_square=0.0, patch_count=fit.patch_count // 2))
    poor = replace(tilt, fit=replace(fit, chi_square=2.0 * nominal.chi_square))
    assert form_fits._is_sound(tilt, tilt, nominal)
    assert not form_fits._is_sound(blind, tilt, nominal)
    assert not form_fits._is_sound(poor, tilt, nominal)


def test_of_the_same_effects_the_fitted_one_stays_with_the_better_judgement(screened, basis):
    tilt = refitted_with(screened, 'gravity_tilt')
    ways = ways_of(tilt.evaluator.model, tilt.fit, basis, tilt.added)
    judged = tolerated(tilt.fit, ways)
    poor, good = (replace(judged, log_evidence=judged.log_evidence + d) for d in (-5.0, 5.0))
    fitted = replace(tilt, judged=judged)
    led = replace(tilt, fit=replace(tilt.fit, evaluations=1), judged=good)
    (found,) = one_of_each([fitted, led])
    assert found.fit is fitted.fit
    assert found.judged is good
    (found,) = one_of_each([fitted, replace(led, judged=poor)])
    assert found is fitted
