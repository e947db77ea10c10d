# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is free in more ways than data ask for is fitted with fewer."""

from dataclasses import replace
from types import SimpleNamespace

from diffcal_ros.calibration.parameters.form_parameters import form_parameters
from diffcal_ros.diagnosis.model_comparison import form_sizes, freedom, less_freedom
from diffcal_ros.diagnosis.model_comparison.freedom import _in_each
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.model_comparison.less_freedom import free_in_one_way, with_less_freedom
import pytest
from support.freed import judged_model, likelier, with_parts


@pytest.fixture(autouse=True)
def as_large_as_they_were(monkeypatch):
    """What is freed here stays as large as it was asked for; see test_form_sizes."""
    monkeypatch.setattr(form_sizes, 'with_favoured_sizes', lambda _, model: model)


def _with_a_lens(screened, basis) -> Hypothesis:
    """Return a camera that is another one in each pose and has another picture."""
    camera = judged_model(screened, basis, 'camera_offset', 0.3, 0.4)
    parts = _in_each(camera, camera.added[0].names, 0.3)
    lens = form_parameters(camera.added[0].effect, 0.4)
    return with_parts(camera, [*parts, *lens])


@pytest.mark.parametrize(
    ('behind', 'leaning', 'is_one'),
    [
        ((-20.0, 90.0), 0.0, 'in form'),
        ((4.0, 90.0), 0.0, 'in form'),
        ((6.0, 90.0), 40.0, 'in form'),
        ((6.0, 6.0), 0.0, ''),
        ((90.0, 4.0), 0.0, 'in poses'),
        ((3.0, 1.0), 0.0, 'in poses'),
        ((1.0, 3.0), 0.0, 'in form'),
    ],
)
def test_what_does_as_well_with_one_freedom_has_one(
    screened, basis, monkeypatch, behind, leaning, is_one
):
    monkeypatch.setattr(freedom, 'judged', lambda models, *_, **__: list(models))
    free, asked = _with_a_lens(screened, basis), []
    assert free.is_free_in_everything
    scale = max(1.0, free.chi_square_per_patch)

    def refit_all(requests):
        asked.extend(requests)
        plain = judged_model(screened, basis, 'camera_offset', 0.0, leaning=leaning * scale)
        models = [with_parts(plain, request.freed) for request in requests]
        # What is in doubt of what it owes to forms is for it.
        return [
            likelier(one, free.level - scale * own - one.log_evidence)
            for one, own in zip(models, behind, strict=True)
        ]

    found = free_in_one_way(SimpleNamespace(refit_all=refit_all), free, basis)
    form, poses = (request.freed for request in asked)
    assert {part.posture for part in form} == {None}
    assert {part.name.partition('@')[0] for part in poses} == set(free.added[0].names)
    assert None not in {part.posture for part in poses}
    assert found.freed == {'in form': form, 'in poses': poses, '': free.freed}[is_one]


def test_a_form_that_is_another_one_in_each_pose_belongs_to_no_freedom_of_poses(
    screened, basis, monkeypatch
):
    monkeypatch.setattr(freedom, 'judged', lambda models, *_, **__: list(models))
    free, asked = _with_a_lens(screened, basis), []
    names = [part.name for part in free.freed if part.posture is None]
    twice = with_parts(free, [*free.freed, *_in_each(free, names, 0.3)])

    def refit_all(requests):
        asked.extend(requests)
        return []

    found = free_in_one_way(SimpleNamespace(refit_all=refit_all), twice, basis)
    assert found is twice, 'nothing else can be simulated'
    poses = {part.name.partition('@')[0] for part in asked[1].freed}
    assert poses == set(free.added[0].names), 'a lens of each pose is a form'


@pytest.mark.parametrize(('gain', 'is_plain'), [(30.0, True), (-30.0, False)])
def test_a_form_that_stood_in_for_the_second_effect_is_taken_back(
    screened, basis, monkeypatch, gain, is_plain
):
    for module in (freedom, less_freedom):
        monkeypatch.setattr(module, 'judged', lambda models, *_, **__: list(models))
    pair, behind = _with_a_lens(screened, basis), judged_model(screened, basis, 'clamp_offset', 0)
    plain, asked = likelier(pair, gain), []

    def refit_all(requests):
        asked.extend(requests)
        return [plain]

    behind = replace(behind, judged=replace(behind.judged, log_evidence=pair.level - 99.0))
    found = with_less_freedom(SimpleNamespace(refit_all=refit_all), [behind, pair], basis)
    (request,) = asked
    assert {part.name.partition('@')[0] for part in request.freed} == set(pair.added[0].names)
    assert request.added == pair.added
    assert request.starts == pair.fit.values_by_name()
    assert (found[0] is plain) == is_plain
    assert found[1:] == [behind]


def test_what_is_another_one_in_each_pose_only_is_not_fitted_again(screened, basis):
    camera = judged_model(screened, basis, 'camera_offset', 0.3)
    parts = _in_each(camera, camera.added[0].names, 0.3)
    pairs = [with_parts(camera, parts)]
    assert with_less_freedom(SimpleNamespace(), pairs, basis) == pairs
    assert with_less_freedom(SimpleNamespace(), pairs, None) == pairs
