# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effects that are other ones in the course of a recording, on a small body let go."""

from dataclasses import replace
from types import SimpleNamespace

from diffcal_ros.calibration.parameters.form_parameters import knot_parameter
from diffcal_ros.diagnosis.model_comparison.choice import choose
from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.model_comparison.over_time import others_over_time
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.model_comparison.selection import Selection
from diffcal_ros.diagnosis.nominal_fit import fit_nominal
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.screening.candidates import Candidate, candidates
from diffcal_ros.diagnosis.screening.screening import screen
from diffcal_ros.diagnosis.verdict.effect_course import course_of, spread_over_time
from diffcal_ros.time_knot import knots_between
import numpy as np
import pytest
from support.filmed import filmed, filmed_scene

LATE = 0.012 * np.linspace(0.0, 1.0, 14)
TILT = Candidate('gravity_tilt', ('a', 'b'))
NEARER = -0.003 * (np.arange(14) >= 6)


def _nearer(frames, nearer):
    return [
        replace(frame, depth=(frame.depth + float(own)).astype(np.float32))
        for frame, own in zip(frames, nearer, strict=True)
    ]


def _looked(frames) -> tuple[list[Hypothesis], Hypothesis]:
    """Return the models that were found over time, and late stamps as they are in all frames."""
    scene = filmed_scene(is_small=True)
    evaluator, nominal = fit_nominal(scene, frames, None)
    listed = [
        own
        for own in candidates(scene)
        if own.identifier in ('time_offset', 'depth_affine', 'gravity_tilt')
        and 'scale' not in own.components
    ]
    scores = screen(evaluator, nominal.coordinates, listed)
    offset = next(own for own in listed if own.identifier == 'time_offset')
    always = try_effects(evaluator, nominal, [offset], {})
    assert always is not None
    with RefitPool(evaluator, nominal, lambda _: None, jobs=1) as pool:
        return others_over_time(pool, scores, [always]), always


@pytest.fixture(scope='module')
def behind() -> tuple[list[Hypothesis], Hypothesis]:
    return _looked(filmed(seed=1, late=LATE, is_small=True))


@pytest.mark.slow
def test_stamps_that_fall_behind_are_late_stamps_over_time(behind) -> None:
    found, always = behind
    best = max(found, key=lambda own: own.level)
    assert best.identifiers == ('time_offset',)
    assert best.level > always.level + 20.0
    (course,) = course_of(best, best.added[0]).values()
    # At rest nothing tells stamps, and the release is clocked; three frames are held out.
    seen = [number for number in range(3, 14) if number % 5 != 2]
    off = np.array(course)[seen] - 1e3 * LATE[seen]
    assert np.sqrt(np.mean(off**2)) < 1.0
    assert np.corrcoef(np.array(course)[seen], LATE[seen])[0, 1] > 0.9


@pytest.mark.slow
def test_a_course_is_told_in_words(behind) -> None:
    found, always = behind
    best = max(found, key=lambda own: own.level)
    (said,) = spread_over_time(best)
    assert said.startswith('time_offset is another one in the course of the recording: late from')
    assert said.endswith('ms; no scene has that: mend what is filmed, and record again')
    assert spread_over_time(always) == []
    assert course_of(always, always.added[0]) == {}


@pytest.mark.slow
def test_a_camera_that_reads_nearer_from_a_time_on() -> None:
    found, always = _looked(_nearer(filmed(seed=2, is_small=True), NEARER))
    best = max(found, key=lambda own: own.level)
    assert best.identifiers == ('depth_affine',)
    assert best.level > always.level + 100.0
    course = np.array(course_of(best, best.added[0])['bias'])
    # Knots are two frames apart.
    np.testing.assert_allclose(
        np.delete(course, [5, 6]), np.delete(1e3 * NEARER, [5, 6]), atol=0.6
    )


def _named(best: Hypothesis, other: Hypothesis, nominal: Refit, behind: float) -> float:
    """Return the confidence in the best where another one is so far behind it."""
    models = (
        replace(best, guessed=-100.0),
        replace(other, guessed=-100.0 - behind),
    )
    seen = best.evaluator.model.observations
    evaluator = SimpleNamespace(is_measured=True, model=SimpleNamespace(observations=seen))
    choice = choose(Selection(models), evaluator, nominal)
    assert choice is not None
    return choice.confidence


@pytest.mark.slow
def test_what_owes_all_to_its_course_is_clearly_ahead_or_shares_the_answer(behind) -> None:
    found, always = behind
    best = max(found, key=lambda own: own.level)
    evaluator, nominal = always.evaluator, always.fit
    tilted = try_effects(evaluator, nominal, [TILT], {})
    assert tilted is not None
    # It owes 600 to its course at most, of which a tenth is in doubt beside 12 of twins.
    nominal = replace(always.fit, log_evidence=-700.0)
    assert _named(best, tilted, nominal, 80.0) > 0.99
    assert _named(best, tilted, nominal, 60.0) == pytest.approx(0.5)
    # At all times alike it owes nothing.
    assert _named(always, tilted, nominal, 60.0) > 0.99
    # What is as free owes as much, which is in doubt where neither leaves noise.
    own = next(one for one in tilted.fit.parameters if one.effect == 'gravity_tilt')
    knots = tuple(knot_parameter(own, knot, 1.0) for knot in knots_between(0.0, 0.4, 3))
    free = try_effects(evaluator, nominal, [TILT], {}, freed=knots)
    assert free is not None
    count = best.fit.patch_count
    for left, confidence in ((0.8, 1.0), (1.5, 0.5)):
        there = replace(best, fit=replace(best.fit, chi_square=left * count))
        assert _named(there, free, nominal, 60.0) == pytest.approx(confidence, abs=0.01)


@pytest.mark.parametrize(
    'case', ['noise is a guess', 'few frames', 'two poses', 'at rest', 'stamps are the same']
)
def test_nothing_has_a_course_where_there_is_no_recording_that_tells(case) -> None:
    seen = [
        SimpleNamespace(time=0.1 * number, setup_index=0)
        for number in range(7 if case == 'few frames' else 14)
    ]
    if case == 'stamps are the same':
        seen = [*seen[:7], *seen[:7]]
    if case == 'two poses':
        seen[-1].setup_index = 1
    if case == 'at rest':
        seen[0].time = None
    nominal = SimpleNamespace(
        is_measured=case != 'noise is a guess', model=SimpleNamespace(observations=seen)
    )
    # It has no way to refit anything.
    assert others_over_time(SimpleNamespace(nominal=nominal), SimpleNamespace(), []) == []
