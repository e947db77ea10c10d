# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which second effects are worth a refit."""

from dataclasses import replace

from diffcal_ros.diagnosis.model_comparison import pair_search
from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects
from diffcal_ros.diagnosis.model_comparison.refit_requests import RefitRequest
from diffcal_ros.diagnosis.patches.patch_group import rows_of
from diffcal_ros.diagnosis.screening.candidates import candidates
from diffcal_ros.diagnosis.screening.screening import screen
from diffcal_ros.diagnosis.screening.shortlist import starts_of
import numpy as np
import pytest
from support.judged_models import refitted_with, with_judgement


class _Pool:
    """Refits as it is told to, and keeps what it was asked for."""

    def __init__(self, nominal, base, fits):
        self.nominal, self.base, self._fits = nominal, base, fits
        self.asked = []

    def refit_all(self, requests):
        names = [tuple(sorted(c.identifier for c in request.added)) for request in requests]
        self.asked += names
        return [self._fits[name] for name in names]

    def finish_beside(self, requests, hypotheses, least, **limits):
        assert not requests
        return [], list(hypotheses)


@pytest.mark.parametrize('leaves_noise', [True, False])
def test_where_a_pair_leaves_noise_others_that_lead_nowhere_near_are_left(screened, leaves_noise):
    evaluator, nominal, scores = screened
    score = next(s for s in scores.scores if s.candidate.identifier == 'depth_affine')
    one = try_effects(evaluator, nominal, [score.candidate], starts_of(score))
    wrong = replace(one, fit=replace(one.fit, log_evidence=-900.0))
    names = {
        tuple(sorted(('depth_affine', c.identifier))) for c in candidates(evaluator.model.scene)
    }
    chi_square = 0.7 if leaves_noise else 3.0
    good = replace(one.fit, log_evidence=5e3, chi_square=chi_square * one.fit.patch_count)
    pool = _Pool(evaluator, nominal, {name: replace(one, fit=good) for name in names})
    pair_search.best_pairs(pool, [wrong], scores, None)
    # No promise of the others reaches as far, and of contact beside what is far off there is none.
    others = [own for own in pool.asked[1:] if 'contact_plane' not in own]
    assert (not others) == leaves_noise
    assert ('contact_plane', 'depth_affine') in pool.asked[1:]


@pytest.mark.parametrize('leaves_noise', [True, False])
def test_beside_an_effect_that_leaves_noise_only_what_may_add_enough_is_tried(
    screened, leaves_noise
):
    """Where much is left tangents say little, and all are tried."""
    evaluator, nominal, scores = screened
    score = next(s for s in scores.scores if s.candidate.identifier == 'depth_affine')
    one = try_effects(evaluator, nominal, [score.candidate], starts_of(score))
    chi_square = 0.7 if leaves_noise else 3.0
    # No promise of a second effect reaches so far.
    good = replace(one.fit, log_evidence=5e3, chi_square=chi_square * one.fit.patch_count)
    names = {
        tuple(sorted(('depth_affine', c.identifier))) for c in candidates(evaluator.model.scene)
    }
    pool = _Pool(evaluator, nominal, dict.fromkeys(names, one))
    best = replace(one, fit=good)
    other = replace(one, fit=replace(one.fit, log_evidence=5e3 + 1e3))
    pair_search.best_pairs(pool, [best, other], scores, None)
    assert (len(pool.asked) == 0) == leaves_noise


@pytest.mark.parametrize('leaves_noise', [True, False])
def test_beside_one_that_leaves_more_in_any_form_promises_are_not_believed(screened, leaves_noise):
    evaluator, nominal, scores = screened
    score = next(s for s in scores.scores if s.candidate.identifier == 'depth_affine')
    one = try_effects(evaluator, nominal, [score.candidate], starts_of(score))
    count = one.fit.patch_count
    judged = with_judgement(one, log_evidence=5e3, chi_square=count * (0.7 if leaves_noise else 3))
    names = {
        tuple(sorted(('depth_affine', c.identifier))) for c in candidates(evaluator.model.scene)
    }
    pool = _Pool(evaluator, nominal, dict.fromkeys(names, one))
    # No promise of a second effect reaches so far.
    other = replace(one, fit=replace(one.fit, log_evidence=5e3 + 1e3))
    pair_search.best_pairs(pool, [judged, other], scores, None)
    assert (len(pool.asked) == 0) == leaves_noise


@pytest.mark.parametrize('leaning', [40.0, 400.0])
def test_where_the_best_leaves_noise_in_its_form_others_are_not_looked_at_beside_far_ones(
    screened, leaning
):
    evaluator, nominal, scores = screened
    one, far = (refitted_with(screened, name) for name in ('depth_affine', 'gravity_tilt'))
    count = one.fit.patch_count
    best = with_judgement(one, log_evidence=5e3, chi_square=0.7 * count, exact=5e3 - leaning)
    far = with_judgement(far, log_evidence=1e3, chi_square=3.0 * count)
    # No promise of a second effect reaches so far.
    other = replace(one, fit=replace(one.fit, log_evidence=5e3 + 1e3))
    listed = [own.identifier for own in candidates(evaluator.model.scene)]
    names = {tuple(sorted((a, b))) for a in listed for b in ('depth_affine', 'gravity_tilt')}
    pool = _Pool(evaluator, nominal, dict.fromkeys(names, one))
    pair_search.best_pairs(pool, [best, far, other], scores, None)
    assert all('gravity_tilt' in names for names in pool.asked)
    assert bool(pool.asked) == (leaning == 400.0)


_PAIRS = (('contact_plane', 'depth_affine'), ('depth_affine', 'gravity_tilt'))


@pytest.fixture
def offered(screened, monkeypatch):
    """A pair that leaves noise, and what else is offered: another kind of it, and another pair.

    Both lead nowhere near.
    """
    evaluator, nominal, scores = screened
    names = ('depth_affine', 'contact_plane', 'gravity_tilt')
    first, *seconds = (
        next(s for s in scores.scores if s.candidate.identifier == name) for name in names
    )
    one = try_effects(evaluator, nominal, [first.candidate], starts_of(first))
    offers = [
        pair_search._Offer(
            RefitRequest((first.candidate, second.candidate), {}, 4), -100.0, gain, 1.25, True
        )
        for second, gain in ((seconds[0], 90.0), (seconds[0], 12.0), (seconds[1], 11.0))
    ]
    monkeypatch.setattr(pair_search, '_offers', lambda *_: offers)
    single = replace(one, fit=replace(one.fit, log_evidence=-100.0))
    pair = refitted_with(screened, *names[:2])
    fit = replace(pair.fit, log_evidence=0.0, chi_square=0.7 * pair.fit.patch_count)
    return single, replace(pair, fit=fit)


def _asked_beside(offered, screened, best):
    evaluator, nominal, scores = screened
    pool = _Pool(evaluator, nominal, dict.fromkeys(_PAIRS, best))
    pair_search.best_pairs(pool, [offered[0]], scores, None)
    return pool.asked


def test_where_a_plane_leaves_noise_a_bar_is_tried_all_the_same(offered, screened):
    assert _asked_beside(offered, screened, offered[1]) == [_PAIRS[0]] * 2


def test_a_pair_that_owes_much_to_other_forms_keeps_none_from_being_tried(offered, screened):
    best = replace(
        offered[1], judged=with_judgement(offered[1], chi_square=1.0, exact=-400.0).judged
    )
    assert best.leaning == 400.0
    assert len(_asked_beside(offered, screened, best)) == 3


def test_of_what_has_no_tangent_every_kind_is_offered(screened):
    """What stands in for a plane, and for a bar below one place, tells neither from the other."""
    _, _, scores = screened
    best = {}
    for score in scores.scores:
        best.setdefault(score.candidate.identifier, score)
    listed = [s for s in scores.scores if s.candidate.identifier == 'contact_plane']
    kinds = {}
    for score in listed:
        kinds.setdefault(score.candidate.components, score)
    one, other = kinds.values()
    assert len(listed) > 2
    first = best['depth_affine'].candidate
    tilts = [s for s in scores.scores if s.candidate.identifier == 'gravity_tilt']
    scored = [listed[0], *tilts, *listed[1:]]
    found = pair_search._seconds(first, scored, is_measured=True, tells=True)
    assert found == [one, tilts[0], other]
    # Where it is none of the best it is offered only where scores tell nothing of it.
    ahead = [best[name] for name in ('camera_offset', 'clamp_offset', 'gravity_tilt')]
    for tells in (True, False):
        found = pair_search._seconds(first, [*ahead, *listed], is_measured=True, tells=tells)
        assert found == (ahead if tells else [*ahead, one, other])
    nothing = [replace(own, gain=0.0) for own in listed]
    found = pair_search._seconds(first, [*ahead, *nothing], is_measured=True, tells=False)
    assert found == ahead


def test_forms_are_told_by_the_names_of_patches(screened):
    """A state that is found again may show a patch at the outline more, or one less."""
    evaluator, nominal, scores = screened
    random = np.random.default_rng(5)
    columns = [1e-4 * random.normal(size=(len(b.patches.values), 3)) for b in nominal.groups]
    rows = rows_of(nominal.groups, columns)
    name = next(iter(rows))
    fewer = {own: row for own, row in rows.items() if own != name}
    listed = [score.candidate for score in scores.scores]
    found = [screen(evaluator, nominal.coordinates, listed, beside) for beside in (rows, fewer)]
    assert found[0].chi_square < scores.chi_square
    # Where nothing is known of a patch nothing moves it.
    still = rows | {name: np.zeros(3)}
    again = screen(evaluator, nominal.coordinates, listed, still)
    assert found[1].chi_square == pytest.approx(again.chi_square, rel=1e-9)
    assert found[1].chi_square != pytest.approx(found[0].chi_square, rel=1e-6)
