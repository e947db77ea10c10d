# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What effects are free to be besides, and how large that is."""

from dataclasses import replace
from types import SimpleNamespace

from diffcal_ros.diagnosis.model_comparison import any_form, freed_effects
from diffcal_ros.diagnosis.model_comparison.form_ways import ways_of
from diffcal_ros.diagnosis.model_comparison.freedom import freed_parts, freeing_request
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.screening.candidates import parameters_of
from diffcal_ros.diagnosis.verdict.verdict_figures import spread_over_poses
import numpy as np
import pytest
from support.freed import judged_model, with_parts


@pytest.fixture(scope='module')
def clamp(screened, basis) -> Hypothesis:
    return judged_model(screened, basis, 'clamp_offset', 0.3)


def test_amplitudes_get_a_part_of_their_own_as_large_as_data_say(clamp):
    request = freeing_request(clamp)
    assert [part.name for part in request.freed] == [f'{n}@0' for n in clamp.added[0].names]
    assert all(part.is_nuisance and part.posture == 0 for part in request.freed)
    names = clamp.fit.parameters.names
    scales = np.array(
        [clamp.added[0].effect.component(c).scale for c in clamp.added[0].components]
    )
    values = clamp.fit.coordinates[[names.index(name) for name in clamp.added[0].names]]
    usual = np.array([part.quantity.prior_std for part in request.freed]) / scales
    np.testing.assert_allclose(usual, 0.3 * np.linalg.norm(values / scales))


def test_an_effect_that_came_to_nothing_is_of_no_other_form(clamp):
    """A prior as large as a share of nothing has no precision."""
    bent = replace(clamp, judged=replace(clamp.judged, fraction=0.3))
    names = clamp.fit.parameters.names
    coordinates = clamp.fit.coordinates.copy()
    coordinates[[names.index(name) for name in clamp.added[0].names]] = 0.0
    nothing = replace(bent, fit=replace(clamp.fit, coordinates=coordinates))
    assert freed_parts(bent)
    assert freed_parts(nothing) == []
    assert freed_parts(nothing, 0.09) == []


def test_what_is_of_another_form_gets_what_it_is_more_in_that(screened, basis):
    bend = judged_model(screened, basis, 'rest_curvature', 0.05, 0.4)
    request, effect = freeing_request(bend), bend.added[0].effect
    assert [part.amplitude for part in request.freed] == [part.name for part in effect.forms]
    assert all(part.is_freed and part.posture is None for part in request.freed)
    names = bend.fit.parameters.names
    values = bend.fit.coordinates[[names.index(name) for name in bend.added[0].names]]
    size = np.linalg.norm(values / effect.components[0].scale)
    usual = [part.quantity.prior_std / effect.forms[0].scale for part in request.freed]
    np.testing.assert_allclose(usual, 0.4 * size)
    assert freed_effects._may_win(bend, bend.level)
    of_that = replace(bend, judged=replace(bend.judged, fraction=0.05))
    assert not freed_effects._may_win(of_that, bend.level)
    tilt = judged_model(screened, basis, 'gravity_tilt', 0.05, 0.9)
    assert not freed_effects._may_win(tilt, tilt.level), 'the library has no other form of it'


def test_a_place_is_freed_by_a_usual_size(screened, basis):
    plane = judged_model(screened, basis, 'contact_plane', 0.05, 0.5)
    request = freeing_request(plane)
    assert {part.quantity.prior_std for part in request.freed} == {0.5 * 0.010}


def test_a_form_that_is_free_and_still_another_one_is_so_in_each_pose(screened, basis):
    camera = judged_model(screened, basis, 'camera_offset', 0.05, 0.4)
    form = freeing_request(camera).freed
    assert [part.posture for part in form] == [None] * len(form)
    freed = with_parts(camera, form)
    assert freed_parts(freed) == [], 'of one pose it is told already'
    two = SimpleNamespace(model=SimpleNamespace(bodies={0: None, 1: None}))
    more = freed_parts(replace(freed, evaluator=two))
    assert [part.name for part in more] == [
        f'{part.name}@{posture}' for part in form for posture in (0, 1)
    ]
    # As large as data say that the form is another one yet.
    by_name = {part.name: part.quantity.prior_std for part in form}
    for part in more:
        assert part.quantity.prior_std == pytest.approx(by_name[part.name.partition('@')[0]])
    # A body is bent at rest by one curve, whatever its pose.
    bend = judged_model(screened, basis, 'rest_curvature', 0.05, 0.4)
    bent = with_parts(bend, freeing_request(bend).freed)
    assert freed_parts(replace(bent, evaluator=two)) == []


def test_such_a_model_goes_on_with_its_parts_and_needs_no_tolerance_for_them(
    screened, basis, clamp
):
    evaluator, nominal, _ = screened
    pool = RefitPool(evaluator, nominal)
    (found,) = pool.refit_all([freeing_request(clamp)])
    assert [part.name for part in found.freed] == [f'{n}@0' for n in clamp.added[0].names]
    ways = ways_of(found.evaluator.model, found.fit, basis, found.added)
    assert ways.pose_count == 0
    brought = parameters_of(found.fit.parameters, found.added)
    assert set(brought) == {*clamp.added[0].names, *(p.name for p in found.freed)}
    (again,) = pool.finish([found], [-np.inf])
    assert again.fit.parameters.names == found.fit.parameters.names
    assert again.fit.log_evidence >= found.fit.log_evidence - 0.1
    once = replace(found, judged=clamp.judged)
    assert not freed_effects._may_win(once, clamp.level), 'it is free already'
    (said,) = spread_over_poses(found)
    assert said.startswith('clamp_offset is another one in each pose: rx by ')
    assert spread_over_poses(clamp) == []


def test_in_the_librarys_form_parameters_are_those_of_the_fit(screened, basis, monkeypatch):
    monkeypatch.setattr(any_form, 'OF_FORM', np.zeros(1))
    monkeypatch.setattr(any_form, 'BY_POSE', np.zeros(1))
    tilt = judged_model(screened, basis, 'gravity_tilt', 0.0)
    exact = tilt.in_any_form
    # Two routes: normal equations of the fit, and columns scaled by the root of the prior.
    np.testing.assert_allclose(exact.covariance, tilt.fit.covariance, rtol=1e-6, atol=1e-14)
    errors = np.sqrt(np.diag(tilt.fit.covariance))
    assert np.abs((exact.coordinates - tilt.fit.coordinates) / errors).max() < 0.1


def test_parameters_are_less_sure_beside_an_effect_of_whatever_form(screened, basis):
    tilt = judged_model(screened, basis, 'gravity_tilt', 0.0)
    index = tilt.fit.parameters.names.index('youngs_modulus')
    _, alone = tilt.fit.of_the_body(index)
    _, in_any = tilt.in_any_form.of_the_body(index)
    assert in_any > alone
    assert replace(tilt, judged=None).in_any_form is tilt.fit
