# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is off in one place of a body says nothing about the rest of it."""

from dataclasses import replace

from diffcal_ros.diagnosis.answers import Verdict
from diffcal_ros.diagnosis.detection.local_outlier import (
    _bending,
    _seen_along,
    find_local_outlier,
)
from diffcal_ros.diagnosis.diagnose import diagnose
from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects
from diffcal_ros.diagnosis.patch_fits.residual_location import nearest_nodes
from diffcal_ros.diagnosis.patches.whitened import Part, precision_of, whiten
from diffcal_ros.diagnosis.screening.shortlist import starts_of
from diffcal_ros.diagnosis.verdict.doubts import doubts_about
import numpy as np
import pytest
from scipy.integrate import trapezoid
from support.scenes import beam_scene
from support.watched import watched


def _off(fit, places: dict[int, float]):
    """A fit with some of its first group's patches further off by so much [m]."""
    first = fit.groups[0]
    values = first.patches.values.copy()
    for place, size in places.items():
        values[place] += size
    moved = replace(first, patches=replace(first.patches, values=values))
    return replace(fit, groups=[moved, *fit.groups[1:]])


def _noisy(fit, seed: int):
    """The fit with patches that are off by noise alone."""
    random = np.random.default_rng(seed)
    groups = [
        replace(
            group,
            patches=replace(
                group.patches,
                values=np.linalg.cholesky(group.patches.covariance)
                @ random.standard_normal(len(group.patches.values)),
            ),
        )
        for group in fit.groups
    ]
    return replace(fit, groups=groups)


@pytest.fixture(scope='module')
def draws(clearly_screened):
    """Fits whose patches are off by noise alone, as it is drawn."""
    _, fit, _ = clearly_screened
    return [_noisy(fit, seed) for seed in range(6)]


@pytest.fixture(scope='module')
def clean(draws):
    """One of them."""
    return draws[0]


def test_one_place_is_found_with_its_size_and_part(clearly_screened, clean):
    evaluator, _, _ = clearly_screened
    group = clean.groups[0]
    # The patch farthest along the body and whatever lies right beside it.
    tip = int(group.patches.centers[:, 0].argmax())
    found = find_local_outlier(evaluator, _off(clean, {tip: 0.006}))
    assert found is not None
    assert (group.view, group.kind, int(group.patches.cells[tip])) in found.patches
    assert found.size > 0.001
    assert len(found.patches) <= 0.15 * sum(len(b.patches.values) for b in clean.groups)
    assert found.where in found.sentence


def test_weights_of_the_rest_are_those_of_all_less_what_was_left_out(clearly_screened):
    _, fit, _ = clearly_screened
    weights = precision_of(fit.groups)
    columns = np.concatenate(
        [np.column_stack([b.patches.values, b.patches.jacobian]) for b in fit.groups]
    )
    seen = whiten(fit.groups, Part.ALL)
    both = np.column_stack([seen.values, seen.jacobian])
    assert np.allclose(columns.T @ weights @ columns, both.T @ both, rtol=1e-8)
    # The second half of the outline, and every third patch of depth.
    kept = [
        np.arange(len(b.patches.values)) % 3 > 0
        if b.kind == 'depth'
        else np.arange(len(b.patches.values)) < len(b.patches.values) // 2
        for b in fit.groups
    ]
    rest = [
        replace(b, patches=b.patches.chosen(k), mesh=b.mesh[k], is_report=b.is_report[k])
        for b, k in zip(fit.groups, kept, strict=True)
    ]
    out = np.flatnonzero(~np.concatenate(kept))
    pulls = weights @ columns
    less = pulls[out].T @ np.linalg.solve(weights[np.ix_(out, out)], pulls[out])
    left = whiten(rest, Part.ALL)
    both = np.column_stack([left.values, left.jacobian])
    assert np.allclose(columns.T @ pulls - less, both.T @ both, rtol=1e-6, atol=1e-6)


def test_what_moves_a_large_part_of_the_body_is_no_outlier(clearly_screened, clean):
    evaluator, tilted, _ = clearly_screened
    assert find_local_outlier(evaluator, tilted) is None
    everywhere = dict.fromkeys(range(len(clean.groups[0].patches.values)), 0.004)
    assert find_local_outlier(evaluator, _off(clean, everywhere)) is None


def test_places_that_lie_apart_are_found_one_at_a_time(clearly_screened, clean):
    evaluator, _, _ = clearly_screened
    group = clean.groups[0]
    order = np.argsort(group.patches.centers[:, 0])
    apart = [int(order[0]), int(order[len(order) // 2]), int(order[-1])]
    names = {(group.view, group.kind, int(group.patches.cells[place])) for place in apart}
    found = find_local_outlier(evaluator, _off(clean, dict.fromkeys(apart, 0.006)))
    assert len(found.patches & names) == 1


def _moved(evaluator, fit, field):
    """A fit whose body has moved by a field [m], camera frame, shape (N, 3), besides."""
    shifted = evaluator.groups(fit.coordinates, [field[None]])
    return replace(
        fit,
        groups=[
            replace(
                group,
                patches=replace(
                    group.patches,
                    values=group.patches.values + wide.patches.jacobian[:, -1],
                ),
            )
            for group, wide in zip(fit.groups, shifted, strict=True)
        ],
    )


def _along(evaluator):
    """Place of each node along the body, 0 at its clamp and 1 at its tip, shape (N,)."""
    model = evaluator.model
    rest = model.body(model.observations[0]).discretisation.rest_nodes
    return model.effects.axes(0).fraction(rest)


@pytest.mark.parametrize('begins', [0.4, 0.6, 0.75, 0.85])
@pytest.mark.parametrize('direction', [(0.0, 0.0, 1.0), (0.0, 1.0, 0.5)])
def test_an_end_that_bends_on_its_own_is_the_body(clearly_screened, draws, begins, direction):
    evaluator, _, _ = clearly_screened
    beyond = np.clip((_along(evaluator) - begins) / (1.0 - begins), 0.0, 1.0)
    bent = (0.003 * beyond**2)[:, None] * np.array(direction)
    found = [find_local_outlier(evaluator, _moved(evaluator, draw, bent)) for draw in draws]
    assert found == [None] * len(draws)


@pytest.mark.parametrize(
    ('ends', 'where'), [((-0.1, 0.1), 'near the clamp'), ((0.45, 0.55), 'in the middle')]
)
def test_a_strip_that_jumps_at_its_borders_is_not(clearly_screened, draws, ends, where):
    """But where noise happens to smooth the jump: of six draws in one at most."""
    evaluator, _, _ = clearly_screened
    along = _along(evaluator)
    jumped = (-0.002 * ((along > ends[0]) & (along < ends[1])))[:, None] * [0.0, 0.0, 1.0]
    found = [find_local_outlier(evaluator, _moved(evaluator, draw, jumped)) for draw in draws]
    told = [one.where for one in found if one is not None]
    assert len(told) >= len(draws) - 1
    assert set(told) == {where}


def test_patches_know_where_on_the_body_they_lie(clearly_screened):
    """By how they follow the body, and by the triangles that are seen in them."""
    evaluator, fit, _ = clearly_screened
    along = _along(evaluator)
    slopes, means = _seen_along(evaluator, fit, along)
    groups = [group for group in fit.groups if len(group.patches.values)]
    view = evaluator.model.views(fit.coordinates)[0]
    nodes = np.concatenate(
        [nearest_nodes(own, view.points, evaluator.model.observations[0].camera) for own in groups]
    )
    assert slopes.shape == (len(nodes), 3)
    # Nodes are a sixteenth apart.
    assert np.abs(means - along[nodes]).max() < 0.06


@pytest.mark.parametrize('begins', [0.5, 0.75])
def test_what_bends_from_a_place_on_is_curvature_integrated_twice(begins):
    along = np.array([0.2, 0.55, 0.8, 0.93, 1.0])
    places = np.linspace(begins, 1.0, 40_001)
    levers = np.clip(along[:, None] - places, 0.0, None) / (1.0 - begins)
    products = levers[:, None] * levers
    integrals = trapezoid(products, places, axis=-1) / (1.0 - begins)
    np.testing.assert_allclose(_bending(along, begins), 3.0 * integrals, atol=1e-6)
    assert _bending(along, begins)[-1, -1] == pytest.approx(1.0)


@pytest.mark.slow
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


def _with_held_out(tried, fit, share):
    """A model that leaves a share of the gap on patches that were held out, and none elsewhere."""
    groups = [
        replace(
            group,
            patches=replace(
                group.patches, values=np.where(group.is_report, share, 0.0) * group.patches.values
            ),
        )
        for group in fit.groups
    ]
    return replace(tried, fit=replace(tried.fit, groups=groups))


def test_nothing_is_named_that_does_not_lower_the_gap_or_may_be_zero(clearly_screened, clean):
    evaluator, fit, scores = clearly_screened
    tilt = next(s for s in scores.scores if s.candidate.identifier == 'gravity_tilt')
    tried = try_effects(evaluator, fit, [tilt.candidate], starts_of(tilt))
    assert doubts_about(tried, fit) == ()
    # The same held-out patches as without it, or with a gap that noise alone would make.
    (reason,) = doubts_about(_with_held_out(tried, fit, 1.0), fit)
    assert 'leaves as much' in reason
    (reason,) = doubts_about(tried, clean)
    assert 'within the floors' in reason
    # Of the gap, nearly half is closed.
    (reason,) = doubts_about(_with_held_out(tried, fit, 0.6), fit)
    assert 'closes 4' in reason
    # Those that were fitted want it as little.
    same = replace(tried, fit=replace(tried.fit, groups=fit.groups))
    (reason,) = doubts_about(same, fit)
    assert 'may be zero' in reason
    doubtful = replace(tried.fit, covariance=1e6 * tried.fit.covariance)
    (reason,) = doubts_about(replace(tried, fit=doubtful), fit)
    assert 'may be zero' in reason
