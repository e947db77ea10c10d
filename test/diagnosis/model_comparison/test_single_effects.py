# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What need not be refitted is told all the same, and comes out as it would."""

from dataclasses import replace

from diffcal_ros.diagnosis.model_comparison import single_effects
from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects
from diffcal_ros.diagnosis.model_comparison.pair_search import halves
from diffcal_ros.diagnosis.model_comparison.refit_pool import RefitPool
from diffcal_ros.diagnosis.model_comparison.single_effects import refitted_singles
from diffcal_ros.diagnosis.screening.candidates import candidates
from diffcal_ros.diagnosis.screening.shortlist import shortlist
from diffcal_ros.effects.registry import EFFECTS
import numpy as np
import pytest


class _Pool(RefitPool):
    """Refits, and keeps what it was asked for."""

    def __init__(self, nominal, base):
        super().__init__(nominal, base)
        self.asked = []

    def finish_beside(self, requests, hypotheses, least, **limits):
        self.asked += [request.added for request in requests]
        return super().finish_beside(requests, hypotheses, least, **limits)


@pytest.fixture(scope='module')
def variants(too_far, scores):
    found = [s.candidate for s in shortlist(scores, is_measured=True)]
    by_components = {frozenset(c.components): c for c in found if c.identifier == 'depth_affine'}
    return by_components[frozenset({'bias'})], by_components[frozenset({'scale', 'bias'})]


def test_a_variant_with_fewer_amplitudes_is_refitted_only_where_it_may_win(
    too_far, scores, variants, monkeypatch
):
    part, whole = variants
    (alone,) = RefitPool(*too_far).refit_all([single_effects.first_request([part], {})])
    near = _Pool(*too_far)
    found = {h.added: h for h in refitted_singles(near, scores)}
    assert {(part,), (whole,)} <= found.keys()
    assert near.asked.index((whole,)) < near.asked.index((part,))
    monkeypatch.setattr(single_effects, '_NEAR', -1e9)
    far = _Pool(*too_far)
    told = {h.added: h for h in refitted_singles(far, scores)}
    assert (part,) not in far.asked
    # It begins where tangents lead, and comes to the same rest.
    errors = np.sqrt(np.diag(alone.fit.covariance))
    off = np.abs(found[(part,)].fit.coordinates - alone.fit.coordinates)
    assert (off < 0.5 * errors).all()
    assert found[(part,)].fit.evaluations > 0
    assert told[(part,)].fit.evaluations == 0


@pytest.mark.parametrize('looks_long', [True, False])
@pytest.mark.slow_but_first
def test_what_takes_long_is_looked_at_where_a_name_may_be_given(screened, monkeypatch, looks_long):
    evaluator, nominal, scores = screened
    listed = {s.candidate.identifier for s in shortlist(scores, is_measured=True)}
    assert {'gravity_tilt', 'clamp_offset'} <= listed
    monkeypatch.setattr(type(EFFECTS['clamp_offset']), 'needs_long_look', True)
    pool = _Pool(evaluator, nominal)
    refitted_singles(pool, scores, looks_long=looks_long)
    asked = {candidate.identifier for added in pool.asked for candidate in added}
    assert 'gravity_tilt' in asked
    assert ('clamp_offset' in asked) is looks_long


def test_what_takes_long_is_looked_at_where_nothing_else_is_left(too_far, scores, monkeypatch):
    assert {s.candidate.identifier for s in shortlist(scores, is_measured=True)} == {
        'depth_affine'
    }
    monkeypatch.setattr(type(EFFECTS['depth_affine']), 'needs_long_look', True)
    found = refitted_singles(RefitPool(*too_far), scores, looks_long=False)
    assert {h.added[0].identifier for h in found} == {'depth_affine'}


def test_half_of_a_pair_is_tried_where_it_may_come_farther_than_alone(too_far, variants):
    evaluator, base = too_far
    tilt = next(
        c
        for c in candidates(evaluator.model.scene)
        if c.identifier == 'gravity_tilt' and len(c.components) == 2
    )
    part = variants[0]
    single = try_effects(evaluator, base, [part], {})
    pair = try_effects(evaluator, base, [part, tilt], single.fit.values_by_name())
    assert single.fit.is_converged
    # Ahead of the single effect, whichever is.
    pairs = [with_log_evidence(pair, single.log_evidence + 1.0)]
    known, fresh = _Pool(evaluator, base), _Pool(evaluator, base)
    halves(known, [single], pairs, None)
    # The bias has come as far alone as tangents lead; of the tilt nothing is known.
    assert known.asked == [(tilt,)]
    halves(fresh, [with_log_evidence(single, single.log_evidence - 50.0)], pairs, None)
    assert fresh.asked == [(part,), (tilt,)]


def with_log_evidence(hypothesis, log_evidence):
    return replace(hypothesis, fit=replace(hypothesis.fit, log_evidence=log_evidence))
