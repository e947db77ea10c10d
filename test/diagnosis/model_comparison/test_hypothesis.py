# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effects that do nothing, or nothing that is seen, are told from those that matter."""

from dataclasses import replace
from types import SimpleNamespace

from diffcal_ros.calibration.parameters.form_parameters import posture_parameter
from diffcal_ros.diagnosis.model_comparison.absence import (
    deviance,
    has_doubtful_effect,
    has_needless_effect,
    has_nothing_in_common,
    spread_of_amount,
)
from diffcal_ros.diagnosis.model_comparison.any_form import Tolerated
from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis, with_tolerance
from diffcal_ros.diagnosis.model_comparison.second_effect import most_gain
from diffcal_ros.diagnosis.model_comparison.shared_patches import with_groups
from diffcal_ros.diagnosis.nominal_fit import fit_nominal
from diffcal_ros.diagnosis.patch_fits.refit import Refit, refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.patches.patch_group import full_names, only
from diffcal_ros.diagnosis.screening.candidates import Candidate, candidates
from diffcal_ros.diagnosis.screening.shortlist import starts_of
from diffcal_ros.effects.registry import EFFECTS
from diffcal_ros.rigid_motion import upwards
import numpy as np
import pytest
from support.far_worlds import moved_scene, moved_views, shift_by
from support.judged_models import refitted_with
from support.scenes import beam_scene, GRAVITY
from support.watched import watched


@pytest.fixture(scope='module')
def clean() -> tuple[PatchEvaluator, Refit]:
    return fit_nominal(beam_scene((6, 2, 2)), [watched(seed=3)], None)


def _candidate(evaluator: PatchEvaluator, name: str) -> Candidate:
    listed = candidates(evaluator.model.scene, (), None)
    return next(c for c in listed if c.identifier == name and len(c.components) != 2)


def _with_plane_at(clean: tuple[PatchEvaluator, Refit], height: float) -> Hypothesis:
    """Put a plane where it is told to be, without fitting it."""
    evaluator, base = clean
    plane = _candidate(evaluator, 'contact_plane')
    found = try_effects(evaluator, base, [plane], {}, max_iterations=1)
    place = found.fit.parameters.names.index('contact_plane.height')
    start = found.fit.coordinates.copy()
    start[place] = height
    fit = refit(found.evaluator, start, max_iterations=1)
    return Hypothesis((plane,), found.scene, found.evaluator, fit)


@pytest.mark.slow
def test_a_plane_that_touches_nowhere_is_idle(clean):
    far = _with_plane_at(clean, -1.0)
    assert far.has_idle_effect
    assert not has_doubtful_effect(far, clean[1]), 'a plane has no amplitude that would be zero'


def test_a_plane_that_lifts_the_body_is_not_idle(clean):
    assert not _with_plane_at(clean, -0.060).has_idle_effect


def test_a_plane_is_as_likely_however_far_the_worlds_origin_is(clean):
    move = shift_by(10.0)
    scene, seen = moved_scene(beam_scene((6, 2, 2)), move), moved_views([watched(seed=3)], move)
    rise = float(upwards(GRAVITY) @ move[:3, 3])
    near = _with_plane_at(clean, -0.060)
    far = _with_plane_at(fit_nominal(scene, seen, None), -0.060 + rise)
    assert near.fit.chi_square > clean[1].chi_square + 10.0, 'it lifts the body'
    assert far.fit.chi_square == pytest.approx(near.fit.chi_square, rel=1e-3)
    # What is expected of its height is rounded, to less than the size of a body.
    assert far.log_evidence == pytest.approx(near.log_evidence, abs=1.0)


@pytest.mark.parametrize(('bias', 'is_doubtful'), [(0.0, True), (0.003, False)])
def test_an_amplitude_within_its_error_is_doubtful(bias, is_doubtful):
    evaluator, base = fit_nominal(beam_scene((6, 2, 2)), [watched(seed=3, bias=bias)], None)
    found = try_effects(evaluator, base, [_candidate(evaluator, 'depth_affine')], {})
    assert has_doubtful_effect(found, base) == is_doubtful
    assert not found.has_idle_effect
    assert np.isfinite(found.fit.log_evidence)


def _with_errors(found: Hypothesis, sigmas: float) -> Hypothesis:
    """Return a fit as if its amplitudes were so many standard errors from zero."""
    (one,) = found.added
    places = [found.fit.parameters.names.index(name) for name in one.names]
    values = found.fit.coordinates[places]
    covariance = found.fit.covariance.copy()
    covariance[np.ix_(places, places)] = np.diag(len(places) * (values / sigmas) ** 2)
    return replace(found, fit=replace(found.fit, covariance=covariance))


def test_an_amplitude_whose_error_is_large_is_there_where_no_fit_does_without_it(screened):
    evaluator, base, _ = screened
    listed = candidates(evaluator.model.scene)
    tilt = next(own for own in listed if own.identifier == 'gravity_tilt')
    found = try_effects(evaluator, base, [tilt], {})
    # As of a stiffening that levels off, which Wald's test alone would take for noise.
    levelled = _with_errors(found, 3.0)
    assert levelled.chance_of_zero(levelled.added[0]) > 0.003
    assert not has_doubtful_effect(levelled, base)
    # Where a fit does without it, or its own interval holds zero, it may be absent.
    as_good = replace(levelled, fit=replace(levelled.fit, groups=base.groups))
    assert has_doubtful_effect(as_good, base)
    assert has_needless_effect(as_good, base)
    assert has_doubtful_effect(_with_errors(found, 1.0), base)
    assert not has_needless_effect(_with_errors(found, 1.0), base)


@pytest.mark.parametrize(('sigmas', 'is_doubtful'), [(1.5, True), (1.8, False)])
def test_of_what_is_never_negative_half_of_the_chance_is_nothing(screened, sigmas, is_doubtful):
    evaluator, base, _ = screened
    found = try_effects(evaluator, base, [_candidate(evaluator, 'added_mass')], {})
    (mass,) = found.added
    assert deviance(base, found.fit) > 20.0
    loose = _with_errors(found, sigmas)
    assert loose.chance_of_zero(mass) > 0.05
    assert has_doubtful_effect(loose, base) == is_doubtful


@pytest.mark.parametrize(
    ('name', 'sigmas', 'is_freed', 'expected'),
    [
        ('compliant_clamp', 1.0, True, True),
        ('compliant_clamp', 9.0, True, False),
        ('compliant_clamp', 1.0, False, False),
        # It may be set anew in each pose, and then has nothing in common.
        ('clamp_offset', 1.0, True, False),
        # A mass is never negative: half of what noise makes of it is nothing.
        ('added_mass', 2.6, True, True),
        ('added_mass', 2.85, True, False),
    ],
)
def test_a_property_has_a_part_that_all_poses_have_in_common(
    screened, name, sigmas, is_freed, expected
):
    evaluator, base, _ = screened
    one = next(c for c in candidates(evaluator.model.scene) if c.identifier == name)
    found = try_effects(evaluator, base, [one], {}, max_iterations=2)
    known = found.fit.parameters
    parts = [
        posture_parameter(known.parameters[known.names.index(own)], 0, 0.3) for own in one.names
    ]
    if is_freed:
        there = {
            own: one.effect.component(c).scale
            for own, c in zip(one.names, one.components, strict=True)
        }
        found = try_effects(evaluator, base, [one], there, max_iterations=1, freed=tuple(parts))
    assert bool(found.freed) == is_freed
    assert has_nothing_in_common(_with_errors(found, sigmas), one) == expected


@pytest.mark.parametrize(
    ('parts', 'forms', 'expected'),
    [
        ((0.0, 0.0), (0.0, 0.0), 0.0),
        ((0.005, -0.005), (0.0, 0.0), 0.5),
        # It slides: what is less at one place is more at another one.
        ((0.005, -0.005), (-0.005, 0.005), 0.0),
        ((-0.010, -0.014), (0.0, 0.0), np.inf),
    ],
)
def test_a_mass_is_about_as_much_in_all_poses(parts, forms, expected):
    effect = EFFECTS['added_mass']
    poses = [
        {'mass': 0.010 + part, 'mass_2': form} for part, form in zip(parts, forms, strict=True)
    ]
    model = SimpleNamespace(
        bodies=dict.fromkeys((1, 0)),
        effects=SimpleNamespace(amplitudes=lambda _, pose: {'added_mass': poses[pose]}),
    )
    hypothesis = SimpleNamespace(
        evaluator=SimpleNamespace(model=model), fit=SimpleNamespace(coordinates=np.zeros(3))
    )
    one = SimpleNamespace(effect=effect, identifier='added_mass')
    assert spread_of_amount(hypothesis, one) == pytest.approx(expected)


def test_of_what_has_no_amount_none_is_asked(screened):
    evaluator, base, _ = screened
    one = next(c for c in candidates(evaluator.model.scene) if c.identifier == 'gravity_tilt')
    found = try_effects(evaluator, base, [one], {}, max_iterations=1)
    assert spread_of_amount(found, one) == 0.0


def test_of_a_pair_each_is_held_against_the_other_alone(screened):
    evaluator, base, _ = screened
    listed = candidates(evaluator.model.scene)
    tilt = next(own for own in listed if own.identifier == 'gravity_tilt')
    both = [tilt, _candidate(evaluator, 'depth_affine')]
    singles = [try_effects(evaluator, base, [one], {}) for one in both]
    pair = try_effects(evaluator, base, both, {})
    # The depth is right, so that the tilt alone does as well; it cannot be done without.
    assert has_doubtful_effect(pair, base, singles)
    assert deviance(singles[0].fit, pair.fit) < 20.0
    assert deviance(singles[1].fit, pair.fit) > 60.0


def test_of_an_effect_that_is_linear_both_tests_say_the_same():
    evaluator, base = fit_nominal(beam_scene((6, 2, 2)), [watched(seed=3, bias=0.0006)], None)
    found = try_effects(evaluator, base, [_candidate(evaluator, 'depth_affine')], {})
    (one,) = found.added
    places = [found.fit.parameters.names.index(name) for name in one.names]
    values = found.fit.coordinates[places]
    covariance = found.fit.covariance[np.ix_(places, places)]
    walds = float(values @ np.linalg.solve(covariance, values))
    assert deviance(base, found.fit) == pytest.approx(walds, rel=0.2)


def test_a_clamp_may_give_way_about_one_axis_alone(clean):
    evaluator, base = clean
    listed = candidates(evaluator.model.scene)
    axes = ('compliance_a', 'compliance_b')
    across = next(own for own in listed if own.components[:2] == axes)
    found = try_effects(evaluator, base, [across], {}, max_iterations=1)
    names = found.fit.parameters.names

    def stopped_at(a: float, b: float) -> Hypothesis:
        coordinates = np.where(found.fit.coordinates == 0.0, 0.01, found.fit.coordinates)
        coordinates[[names.index(f'compliant_clamp.{axis}') for axis in axes]] = a, b
        return replace(found, fit=replace(found.fit, coordinates=coordinates))

    assert not stopped_at(0.5, 0.0).is_at_bound
    assert stopped_at(0.5, 0.0).has_absent_amplitude
    assert not stopped_at(0.5, 0.2).is_at_bound
    assert not stopped_at(0.5, 0.2).has_absent_amplitude
    _, upper = found.fit.parameters.bounds()
    assert stopped_at(float(upper[names.index('compliant_clamp.compliance_a')]), 0.0).is_at_bound
    single = next(own for own in listed if own.components == ('compliance_a',))
    alone = try_effects(evaluator, base, [single], {}, max_iterations=1)
    absent = replace(alone.fit, coordinates=np.zeros(len(names) - 2))
    assert replace(alone, fit=absent).is_at_bound, 'nothing of it is there'


def test_a_model_is_judged_once_where_it_stands(screened, basis):
    tilt = refitted_with(screened, 'gravity_tilt')
    brief = with_tolerance(tilt, basis, is_brief=True).judged
    whole = with_tolerance(tilt, basis).judged
    assert np.isnan(brief.log_prediction)
    assert np.isfinite(whole.log_prediction)
    # What was judged whole need not be judged in brief again.
    assert with_tolerance(replace(tilt), basis, is_brief=True).judged is whole
    # Where it sees less, stands elsewhere, or may well be larger, it is another model.
    names = full_names(tilt.fit.groups)
    fewer = with_groups(tilt, only(tilt.fit.groups, set(names[::2])))
    moved = tilt.fit.coordinates.copy()
    moved[tilt.evaluator.model.parameters.names.index('youngs_modulus')] += 0.05
    elsewhere = replace(tilt, fit=refit(tilt.evaluator, moved, max_iterations=1))
    larger = replace(tilt, added=(replace(tilt.added[0], size=3.0),))
    for other in (fewer, elsewhere, larger):
        known, anew = (
            with_tolerance(other, own).judged for own in (basis, replace(basis, known={}))
        )
        assert known is not whole
        assert known.log_evidence == anew.log_evidence
        assert known.log_prediction == anew.log_prediction


def test_a_second_effect_can_gain_what_is_left_and_what_tolerance_costs(screened):
    evaluator, base, scores = screened
    listed = candidates(evaluator.model.scene)
    tilt = next(own for own in listed if own.identifier == 'gravity_tilt')
    score = next(s for s in scores.scores if s.candidate.identifier == 'gravity_tilt')
    single = try_effects(evaluator, base, [tilt], starts_of(score))
    pair = try_effects(
        evaluator, base, [tilt, _candidate(evaluator, 'depth_affine')], starts_of(score)
    )
    gained = pair.log_evidence - single.log_evidence
    assert gained < max(most_gain(single), 0.0)
    # The less is left of chi-square, the less can be gained, one for two.
    fit = replace(single.fit, chi_square=single.fit.chi_square + 30.0)
    assert most_gain(replace(single, fit=fit)) - most_gain(single) == pytest.approx(15.0)
    # A tolerance that has gained all that was left leaves nothing to be gained.
    exact = single.fit.log_evidence
    fit = single.fit
    judged = Tolerated(
        log_evidence=exact + most_gain(single),
        log_prediction=0.0,
        fraction=0.1,
        by_pose=0.0,
        left=0.0,
        chi_square=0.0,
        freedom=60.0,
        exact=exact,
        coordinates=fit.coordinates,
        covariance=fit.covariance,
    )
    assert most_gain(replace(single, judged=judged)) == pytest.approx(0.0, abs=1e-9)
