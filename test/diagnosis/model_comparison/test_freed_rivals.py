# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A rival that may be better in a form of its own is fitted so."""

from dataclasses import replace

from diffcal_ros.diagnosis.model_comparison import form_sizes, freedom
from diffcal_ros.diagnosis.model_comparison.freed_rivals import with_its_rival_freed
from diffcal_ros.diagnosis.model_comparison.freedom import freeing_request
from diffcal_ros.effects.registry import EFFECTS
import pytest
from support.freed import judged_model, likelier, Refits, RefitsOf, with_parts


@pytest.fixture(autouse=True)
def as_large_as_they_were(monkeypatch):
    """What is freed here stays as large as it was asked for; see test_form_sizes."""
    monkeypatch.setattr(form_sizes, 'with_favoured_sizes', lambda _, model: model)


@pytest.mark.parametrize(
    ('behind', 'gain', 'is_asked'), [(10.0, 30.0, True), (10.0, 5.0, True), (60.0, 90.0, False)]
)
def test_the_rival_of_one_that_is_free_is_free_as_well(
    screened, basis, monkeypatch, behind, gain, is_asked
):
    monkeypatch.setattr(freedom, 'judged', lambda models, *_, **__: list(models))
    camera = judged_model(screened, basis, 'camera_offset', 0.05, 0.1)
    first = with_parts(camera, freeing_request(camera).freed)
    scale = max(1.0, first.chi_square_per_patch)
    # Data say next to nothing of its form.
    bend = judged_model(screened, basis, 'rest_curvature', 0.02, 0.03)
    rival = likelier(bend, first.level - scale * behind - bend.level)
    refits = Refits((scale * gain,), rival)
    found = with_its_rival_freed(refits, [first, rival], basis)
    assert refits.asked == ([len(EFFECTS['rest_curvature'].forms)] if is_asked else [])
    assert found[0].identifiers == (
        ('rest_curvature',) if is_asked and gain > behind else ('camera_offset',)
    )
    # One that has come to rest with a free form is not fitted again.
    free = with_parts(rival, freeing_request(rival, 0.1).freed)
    for is_converged in (True, False):
        model = replace(free, fit=replace(free.fit, is_converged=is_converged))
        again = Refits((-90.0,), model)
        with_its_rival_freed(again, [first, again.model], basis)
        assert len(again.asked) == (is_asked and not is_converged)


@pytest.mark.parametrize(
    ('behind', 'leaning', 'left', 'is_asked'),
    [
        (30.0, 80.0, 0.0, True),
        (10.0, 10.0, 0.0, False),
        (45.0, 80.0, 0.0, False),
        (40.0, 0.0, 90.0, True),
        (40.0, 0.0, 60.0, False),
    ],
)
def test_a_rival_is_free_where_a_form_that_is_fitted_may_bring_it_near(
    screened, basis, monkeypatch, behind, leaning, left, is_asked
):
    """By 0.4 of what it owes to forms to first order, or as far as leaving noise alone would."""
    monkeypatch.setattr(freedom, 'judged', lambda models, *_, **__: list(models))
    first = judged_model(screened, basis, 'camera_offset', 0.05, 0.1)
    scale = max(1.0, first.chi_square_per_patch)
    bend = judged_model(screened, basis, 'rest_curvature', 0.02, 0.03, leaning=leaning * scale)
    rival = likelier(bend, first.level - scale * behind - bend.level)
    more = rival.judged.freedom + left * scale
    rival = replace(rival, judged=replace(rival.judged, chi_square=more))
    refits = RefitsOf({'rest_curvature': (rival, 60.0 * scale), 'camera_offset': (first, -1.0)})
    found = with_its_rival_freed(refits, [first, rival], basis)
    # What is overtaken is free as well.
    assert refits.asked == (['rest_curvature', 'camera_offset'] if is_asked else [])
    best = ('rest_curvature',) if is_asked else ('camera_offset',)
    assert found[0].identifiers == best


@pytest.mark.parametrize(
    ('fraction', 'leaning', 'is_asked'),
    [(0.12, 80.0, False), (0.13, 80.0, True), (0.4, 49.0, False), (0.4, 51.0, True)],
)
def test_beside_a_form_in_doubt_whatever_owes_much_to_forms_is_looked_at_in_its_own(
    screened, basis, monkeypatch, fraction, leaning, is_asked
):
    """However far behind: to first order a body that was stored bent explains little as an arc."""
    monkeypatch.setattr(freedom, 'judged', lambda models, *_, **__: list(models))
    first = judged_model(screened, basis, 'clamp_offset', 0.05, fraction)
    bend = judged_model(screened, basis, 'rest_curvature', 0.02, 0.03, leaning=leaning)
    rival = likelier(bend, first.level - 600.0 - bend.level)
    quiet = replace(rival, judged=replace(rival.judged, chi_square=rival.judged.freedom))
    refits = RefitsOf({'rest_curvature': (quiet, 650.0), 'clamp_offset': (first, -1.0)})
    found = with_its_rival_freed(refits, [first, quiet], basis)
    assert ('rest_curvature' in refits.asked) == is_asked
    assert (found[0].identifiers == ('rest_curvature',)) == is_asked


@pytest.mark.parametrize(('gain', 'is_first'), [(30.0, True), (5.0, False)])
def test_what_is_overtaken_by_a_free_form_may_be_the_best_in_its_own(
    screened, basis, monkeypatch, gain, is_first
):
    monkeypatch.setattr(freedom, 'judged', lambda models, *_, **__: list(models))
    first = judged_model(screened, basis, 'camera_offset', 0.05, 0.03)
    scale = max(1.0, first.chi_square_per_patch)
    bend = judged_model(screened, basis, 'rest_curvature', 0.02, 0.03)
    rival = likelier(bend, first.level - scale * 20.0 - bend.level)
    refits = RefitsOf(
        {'rest_curvature': (rival, 30.0 * scale), 'camera_offset': (first, gain * scale)}
    )
    found = with_its_rival_freed(refits, [first, rival], basis)
    assert refits.asked == ['rest_curvature', 'camera_offset']
    assert (found[0].identifiers == ('camera_offset',)) == is_first
    assert all(model.freed for model in found)
