# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What moves by its nature takes the place of what would have to be another one in each pose."""

from dataclasses import replace

from diffcal_ros.diagnosis.model_comparison.absence import differing_by_pose
from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects
from diffcal_ros.diagnosis.model_comparison.judged_models import judge_by, nominal_basis
from diffcal_ros.diagnosis.model_comparison.looks_in_any_form import in_each_pose
from diffcal_ros.diagnosis.model_comparison.moved_in_place import with_what_moves
from diffcal_ros.diagnosis.screening.candidates import candidates
from diffcal_ros.diagnosis.screening.screening import screen
import numpy as np
import pytest


@pytest.fixture(scope='module')
def scores(anew_pool):
    nominal, base = anew_pool.nominal, anew_pool.base
    return screen(nominal, base.coordinates, candidates(nominal.model.scene))


@pytest.fixture(scope='module')
def judge(anew_pool):
    return judge_by(nominal_basis(anew_pool))


def _judged_pair(anew_pool, scores, judge, *names):
    added = [next(s for s in scores.scores if s.candidate.identifier == name) for name in names]
    pair = try_effects(anew_pool.nominal, anew_pool.base, [s.candidate for s in added], {})
    return judge([pair])[0]


@pytest.fixture(scope='module')
def tilted_anew(anew_pool, scores, judge):
    """A body that was clamped anew, fitted as one that is tilted before a camera with a bias."""
    return _judged_pair(anew_pool, scores, judge, 'gravity_tilt', 'depth_affine')


def _by_pose(pair, share):
    return replace(pair, judged=replace(pair.judged, by_pose=share))


@pytest.mark.slow
def test_a_clamp_that_was_closed_anew_takes_the_place_of_a_tilt(
    anew_pool, scores, judge, tilted_anew
):
    wrong = _by_pose(tilted_anew, 0.9)
    best, *others = with_what_moves(anew_pool, [wrong], [], scores, judge)
    assert best.identifiers == ('clamp_offset', 'depth_affine')
    assert best.level > wrong.level + 20.0
    assert any(model is wrong for model in others)
    # It is another one in each pose from the start, and the reading stays as it was.
    freed = {own.name.partition('@')[0] for own in best.freed}
    assert freed == set(next(o for o in best.added if o.identifier == 'clamp_offset').names)


@pytest.mark.parametrize('share', [0.0, 0.45])
def test_what_stays_about_the_same_is_left(anew_pool, scores, judge, tilted_anew, share):
    pair = _by_pose(tilted_anew, share)
    assert with_what_moves(anew_pool, [pair], [], scores, judge) == [pair]


def test_what_moves_itself_has_nothing_in_its_place(anew_pool, scores, judge):
    pair = _judged_pair(anew_pool, scores, judge, 'clamp_offset', 'depth_affine')
    moving = _by_pose(pair, 0.9)
    assert with_what_moves(anew_pool, [moving], [], scores, judge) == [moving]


@pytest.mark.slow  # To give up takes a body that hangs from nothing more than a minute.
def test_a_pair_that_finds_no_rest_without_one_of_its_effects_is_left(
    anew_pool, scores, judge, tilted_anew
):
    soft = tilted_anew.fit.coordinates.copy()
    soft[tilted_anew.fit.parameters.names.index('youngs_modulus')] -= np.log(1e9)
    lost = _by_pose(replace(tilted_anew, fit=replace(tilted_anew.fit, coordinates=soft)), 0.9)
    assert with_what_moves(anew_pool, [lost], [], scores, judge) == [lost]
    assert with_what_moves(anew_pool, [], [], scores, judge) == []


@pytest.mark.parametrize(('grams', 'is_apart'), [(0.0, True), (40.0, False)])
def test_a_mass_that_is_none_in_common_differs_by_pose(anew_pool, scores, grams, is_apart):
    mass = next(s.candidate for s in scores.scores if s.candidate.identifier == 'added_mass')
    (name,), freed = mass.names, in_each_pose(anew_pool, mass)
    base = anew_pool.nominal, anew_pool.base
    moved = try_effects(*base, [mass], {}, freed=freed, max_iterations=1)
    still = try_effects(*base, [mass], {}, max_iterations=1)
    for model, is_moved in ((moved, True), (still, False)):
        coordinates = model.fit.coordinates.copy()
        coordinates[model.fit.parameters.names.index(name)] = 1e-3 * grams
        there = replace(model, fit=replace(model.fit, coordinates=coordinates))
        assert there.is_at_bound == (grams == 0.0)
        assert (differing_by_pose(there) is mass) == (is_moved and is_apart)
