# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is off in one place of a body says nothing about the rest of it."""

from dataclasses import replace

from diffcal_ros.diagnosis.diagnose import diagnose
from diffcal_ros.diagnosis.model_comparison.hypothesis import try_effects
from diffcal_ros.diagnosis.patches.local_outlier import find_local_outlier
from diffcal_ros.diagnosis.patches.whitened import Part, precision_of, whiten
from diffcal_ros.diagnosis.screening.shortlist import starts_of
from diffcal_ros.diagnosis.verdict.naming import doubts_about
from diffcal_ros.diagnosis.verdict.verdict import Verdict
import numpy as np
import pytest
from support.scenes import beam_scene
from support.watched import watched


def _off(fit, places: dict[int, float]):
    """A fit with some of its first block's patches further off by so much [m]."""
    first = fit.blocks[0]
    values = first.patches.values.copy()
    for place, size in places.items():
        values[place] += size
    moved = replace(first, patches=replace(first.patches, values=values))
    return replace(fit, blocks=[moved, *fit.blocks[1:]])


@pytest.fixture(scope='module')
def clean(screened):
    """A fit whose patches are off by noise alone."""
    _, fit, _ = screened
    random = np.random.default_rng(5)
    blocks = [
        replace(
            block,
            patches=replace(
                block.patches,
                values=np.linalg.cholesky(block.patches.covariance)
                @ random.standard_normal(len(block.patches.values)),
            ),
        )
        for block in fit.blocks
    ]
    return replace(fit, blocks=blocks)


def test_one_place_is_found_with_its_size_and_part(screened, clean):
    evidence, _, _ = screened
    block = clean.blocks[0]
    # The patch farthest along the body and whatever lies right beside it.
    tip = int(block.patches.centers[:, 0].argmax())
    found = find_local_outlier(evidence.model, _off(clean, {tip: 0.006}))
    assert found is not None
    assert (block.view, block.kind, int(block.patches.cells[tip])) in found.patches
    assert found.size > 0.001
    assert len(found.patches) <= 0.15 * sum(len(b.patches.values) for b in clean.blocks)
    assert found.where in found.sentence


def test_weights_of_the_rest_are_those_of_all_less_what_was_left_out(screened):
    _, fit, _ = screened
    weights = precision_of(fit.blocks)
    columns = np.concatenate(
        [np.column_stack([b.patches.values, b.patches.jacobian]) for b in fit.blocks]
    )
    seen = whiten(fit.blocks, Part.ALL)
    both = np.column_stack([seen.values, seen.jacobian])
    assert np.allclose(columns.T @ weights @ columns, both.T @ both, rtol=1e-8)
    # The second half of the outline, and every third patch of depth.
    kept = [
        np.arange(len(b.patches.values)) % 3 > 0
        if b.kind == 'depth'
        else np.arange(len(b.patches.values)) < len(b.patches.values) // 2
        for b in fit.blocks
    ]
    rest = [
        replace(b, patches=b.patches.chosen(k), mesh=b.mesh[k], is_report=b.is_report[k])
        for b, k in zip(fit.blocks, kept, strict=True)
    ]
    out = np.flatnonzero(~np.concatenate(kept))
    pulls = weights @ columns
    less = pulls[out].T @ np.linalg.solve(weights[np.ix_(out, out)], pulls[out])
    left = whiten(rest, Part.ALL)
    both = np.column_stack([left.values, left.jacobian])
    assert np.allclose(columns.T @ pulls - less, both.T @ both, rtol=1e-6, atol=1e-6)


def test_what_moves_a_large_part_of_the_body_is_no_outlier(screened, clean):
    evidence, tilted, _ = screened
    assert find_local_outlier(evidence.model, tilted) is None
    everywhere = dict.fromkeys(range(len(clean.blocks[0].patches.values)), 0.004)
    assert find_local_outlier(evidence.model, _off(clean, everywhere)) is None


def test_two_places_that_lie_apart_are_no_outlier_of_one(screened, clean):
    evidence, _, _ = screened
    order = np.argsort(clean.blocks[0].patches.centers[:, 0])
    ends = {int(order[0]): 0.006, int(order[-1]): 0.006, int(order[len(order) // 2]): 0.006}
    assert find_local_outlier(evidence.model, _off(clean, ends)) is None


def test_a_thing_before_a_clean_body_is_told_and_the_body_agrees():
    seen = watched(seed=4)
    depth = seen.depth.copy()
    rows, columns = np.nonzero(np.isfinite(depth) & (depth > 0.0))
    middle = np.argmin(np.hypot(rows - np.median(rows), columns - np.median(columns)))
    window = np.s_[
        rows[middle] - 6 : rows[middle] + 6,
        columns[middle] - 6 : columns[middle] + 6,
    ]
    depth[window] -= 0.0025
    course = diagnose(beam_scene((8, 2, 2)), [replace(seen, depth=depth)])
    assert course.diagnosis.verdict is Verdict.AGREE
    assert course.diagnosis.effects == ()
    told = [note for note in course.diagnosis.notes if 'in one place' in note]
    assert len(told) == 1


def test_nothing_is_named_that_does_not_lower_the_gap_or_may_be_zero(screened, clean):
    evidence, fit, scores = screened
    tilt = next(s for s in scores.scores if s.candidate.identifier == 'gravity_tilt')
    tried = try_effects(evidence, fit, [tilt.candidate], starts_of(tilt))
    assert doubts_about(tried, fit) == ()
    # The same held-out patches as without it, or with a gap that noise alone would make.
    (reason,) = doubts_about(replace(tried, fit=replace(tried.fit, blocks=fit.blocks)), fit)
    assert 'leaves as much' in reason
    (reason,) = doubts_about(tried, clean)
    assert 'within the floors' in reason
    doubtful = replace(tried.fit, covariance=1e6 * tried.fit.covariance)
    (reason,) = doubts_about(replace(tried, fit=doubtful), fit)
    assert 'may be zero' in reason
