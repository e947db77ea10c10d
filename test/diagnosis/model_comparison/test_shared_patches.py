# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A model does not win by having looked away from what it does not explain."""

from dataclasses import replace

from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects
from diffcal_ros.diagnosis.model_comparison.judged_models import judged, judged_side_by_side
from diffcal_ros.diagnosis.model_comparison.shared_patches import (
    on_shared_patches,
    on_shared_patches_of_the_near,
    with_groups,
)
from diffcal_ros.diagnosis.patches.patch_group import full_names, only
from diffcal_ros.diagnosis.screening.candidates import candidates
import numpy as np
import pytest


@pytest.fixture(scope='module')
def whole(screened):
    evaluator, nominal, _ = screened
    tilt = next(
        c
        for c in candidates(evaluator.model.scene)
        if c.identifier == 'gravity_tilt' and len(c.components) == 2
    )
    found = try_effects(evaluator, nominal, [tilt], {})
    return with_groups(found, _spoilt(found.fit))


def _spoilt(fit):
    """Put one patch that is fitted five standard errors off."""
    (group, *others) = fit.groups
    index = int(np.flatnonzero(~group.is_report)[3])
    values = group.patches.values.copy()
    values[index] = 5.0 * np.sqrt(group.patches.variances[index])
    return [replace(group, patches=replace(group.patches, values=values)), *others]


def _without_it(fit):
    (group, *_) = fit.groups
    sizes = np.abs(group.patches.values) / np.sqrt(group.patches.variances)
    worst = full_names([group])[int(np.argmax(sizes))]
    return only(fit.groups, set(full_names(fit.groups)) - {worst})


def test_a_patch_that_one_model_lost_counts_for_neither(whole):
    blind = with_groups(whole, _without_it(whole.fit))
    # The same model at the same place, and much likelier for what it does not see.
    assert blind.fit.patch_count == whole.fit.patch_count - 1
    assert blind.log_evidence > whole.log_evidence + 5.0
    one, two = on_shared_patches([whole, blind])
    assert one.log_evidence == pytest.approx(two.log_evidence)
    assert two.log_evidence == pytest.approx(blind.log_evidence)
    assert one.fit.patch_count == two.fit.patch_count == blind.fit.patch_count


def test_a_model_far_behind_has_no_say(whole):
    blind = with_groups(whole, _without_it(whole.fit))
    behind = replace(blind, fit=replace(blind.fit, log_evidence=whole.log_evidence - 4000.0))
    near, far = on_shared_patches_of_the_near([whole, behind])
    assert near.fit.patch_count == whole.fit.patch_count
    assert near.log_evidence == pytest.approx(whole.log_evidence)
    assert far is behind
    assert on_shared_patches_of_the_near([]) == []


def test_two_models_are_held_against_one_another_where_both_look(whole, basis):
    """However far one is behind: what it left out as strange speaks against the other alone."""
    blind = with_groups(whole, _without_it(whole.fit))
    far = replace(blind, fit=replace(blind.fit, log_evidence=whole.log_evidence - 4000.0))
    before, seeing = judged([far, whole], basis)
    assert seeing.log_evidence < before.log_evidence - 5.0
    one, two = judged_side_by_side(before, seeing, basis)
    assert one.log_evidence == pytest.approx(two.log_evidence, abs=1e-6)
    assert one.judged.log_prediction == pytest.approx(two.judged.log_prediction, abs=1e-6)
    assert judged_side_by_side(one, two, basis) == (one, two)
