# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Models are where they were fitted, however far tangents are from leading there."""

from dataclasses import replace

from diffcal_ros.diagnosis.model_comparison.effect_refit import with_effects
from diffcal_ros.diagnosis.model_comparison.form_sizes import refitted, with_favoured_sizes
from diffcal_ros.diagnosis.model_comparison.promised_fits import fitted_as_promised
from diffcal_ros.diagnosis.patch_fits.refit import refit, weighed_anew
import numpy as np
import pytest


@pytest.fixture(scope='module')
def promised(anew_pool, anew_clamp):
    return with_favoured_sizes(anew_pool, anew_clamp)


def _level_there(model):
    return refit(model.evaluator, model.fit.coordinates, max_iterations=1).log_evidence


def _moved(model, distance):
    """Return a model that is said to stand elsewhere, as good as it was [m]."""
    here = model.fit.coordinates.copy()
    here[model.fit.parameters.names.index('clamp_offset.x')] += distance
    return replace(model, fit=replace(model.fit, coordinates=here))


@pytest.mark.slow
def test_what_is_refitted_is_as_good_as_it_says(anew_pool, anew_request):
    (found,) = refitted(anew_pool, [anew_request])
    assert found.fit.log_evidence == pytest.approx(_level_there(found), abs=1e-3)


def test_a_model_stays_where_its_step_promised(anew_pool, anew_clamp, promised):
    (found,) = fitted_as_promised(anew_pool, [anew_clamp], [promised])
    np.testing.assert_array_equal(found.fit.coordinates, promised.fit.coordinates)
    assert found.fit.log_evidence == pytest.approx(_level_there(promised), abs=1e-3)
    assert found.fit.log_evidence != promised.fit.log_evidence, 'it was simulated there'
    assert not found.fit.is_converged


@pytest.mark.parametrize('distance', [0.01, 0.5])
def test_where_a_promise_is_broken_a_model_is_fitted_on_from_the_better_place(
    anew_pool, anew_clamp, promised, distance
):
    """A centimetre off the body is seen elsewhere; half a metre off it is seen nowhere."""
    told = _moved(promised, distance)
    (looked,) = anew_pool.look([told])
    stayed = weighed_anew(anew_clamp.fit, promised.evaluator)
    margin = 100.0
    assert looked is None or looked.fit.log_evidence < stayed.log_evidence - margin
    (found,) = fitted_as_promised(anew_pool, [anew_clamp], [told])
    assert found.fit.log_evidence == pytest.approx(_level_there(found), abs=1e-3)
    assert found.fit.log_evidence >= max(stayed.log_evidence, anew_clamp.fit.log_evidence)
    assert found.fit.log_evidence > promised.fit.log_evidence - 3.0


def test_one_that_wins_nothing_by_it_is_what_it_was(anew_pool, anew_clamp, promised):
    """Where sizes are a hundredth of what data ask for, the fit as it was is likelier."""
    small = tuple(
        replace(own, quantity=replace(own.quantity, prior_std=0.001 * own.quantity.prior_std))
        for own in anew_clamp.freed
    )
    scene, evaluator = with_effects(anew_pool.nominal, anew_pool.base, anew_clamp.added, small)
    fit = replace(weighed_anew(anew_clamp.fit, evaluator), log_evidence=1e6)
    told = replace(promised, scene=scene, evaluator=evaluator, fit=fit)
    (found,) = fitted_as_promised(anew_pool, [anew_clamp], [told])
    assert found is anew_clamp


def test_models_keep_their_order_and_those_that_were_not_changed_stay(
    anew_pool, anew_clamp, promised
):
    told = _moved(promised, 0.01)
    found = fitted_as_promised(anew_pool, [anew_clamp] * 3, [told, anew_clamp, promised])
    assert found[1] is anew_clamp
    np.testing.assert_array_equal(found[2].fit.coordinates, promised.fit.coordinates)
    assert not np.array_equal(found[0].fit.coordinates, told.fit.coordinates)
