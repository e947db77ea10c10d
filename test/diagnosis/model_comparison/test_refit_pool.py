# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Refits in processes of their own are those of this one; what is lost is given up."""

from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, replace
from functools import partialmethod
from multiprocessing import spawn
import os
import pickle
import sys

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.diagnosis.model_comparison import refit_pool
from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects
from diffcal_ros.diagnosis.model_comparison.processes import Processes
from diffcal_ros.diagnosis.model_comparison.refit_pool import processes_begun, RefitPool
from diffcal_ros.diagnosis.model_comparison.refit_requests import RefitRequest
from diffcal_ros.diagnosis.model_comparison.refit_rounds import finished
from diffcal_ros.diagnosis.nominal_fit import fit_nominal
from diffcal_ros.diagnosis.patches.patch_group import moved
from diffcal_ros.diagnosis.screening.candidates import candidates
import numpy as np
import pytest
from support.scenes import beam_scene
from support.watched import watched

BIAS = 0.003
# What a pipe holds on Linux [bytes].
_PIPE = 65536

# A tilt that is far from where any fit leaves it: its fit has a way to go.
_FAR = {'gravity_tilt.a': 0.2}


@pytest.fixture(scope='module')
def fitted():
    return fit_nominal(beam_scene((6, 2, 2)), [watched(seed=1, bias=BIAS)], None)


@pytest.fixture(scope='module')
def added(fitted):
    listed = candidates(fitted[0].model.scene, (), None)
    wanted = {('depth_affine', ('bias',)), ('gravity_tilt', ('a', 'b'))}
    return [(c,) for c in listed if (c.identifier, c.components) in wanted]


@dataclass(frozen=True)
class Death:
    """A task in which a process dies, if it is not this one."""

    survivor: int
    words: str = 'dying'
    max_iterations: int = 1

    def is_same(self, other):
        return False

    def fit(self, nominal, base):
        if os.getpid() != self.survivor:
            os._exit(1)
        return base


def test_nothing_is_refitted_twice(fitted, added):
    requests, told = [RefitRequest(one, _FAR, 2) for one in added], []
    pool = RefitPool(*fitted, told.append)
    first = pool.finish(pool.refit_all(requests), [-np.inf] * len(requests))
    count = len(told)
    assert count == 2 * len(requests)
    again = pool.finish(pool.refit_all(requests[::-1]), [-np.inf] * len(requests))
    assert len(told) == count
    assert all(h.fit is known.fit for h, known in zip(again, first[::-1], strict=True))
    # From elsewhere, for longer, or from where another fit ended it is another one.
    pool.refit_all([replace(requests[0], starts={}), replace(requests[0], max_iterations=3)])
    others = [replace(own, fit=replace(own.fit, groups=list(own.fit.groups))) for own in first]
    pool.finish(others[:1], [-np.inf])
    pool.finish(first[:1], [0.0])
    assert len(told) == count + 4


def test_another_process_finds_the_same(fitted, added, monkeypatch):
    monkeypatch.setattr(refit_pool, '_WORTH_STARTING', 0.0)
    requests = [RefitRequest(one, {}, 4) for one in added]
    told = []
    with RefitPool(*fitted, told.append, jobs=2) as pool:
        found = pool.finish(pool.refit_all(requests), [-np.inf] * len(requests))
        assert pool._processes is not None
    alone = RefitPool(*fitted)
    expected = alone.finish(alone.refit_all(requests), [-np.inf] * len(requests))
    assert [h.identifiers for h in found] == [h.identifiers for h in expected]
    for here, there in zip(expected, found, strict=True):
        # Equilibria agree to their tolerance, whatever state they began with.
        errors = np.sqrt(np.diag(here.fit.covariance))
        assert np.abs(there.fit.coordinates - here.fit.coordinates).max() < 0.02 * errors.max()
        assert there.fit.log_evidence == pytest.approx(here.fit.log_evidence, abs=0.1)
    first = requests[0].added[0].identifier
    assert told[0] == f'refitting with {first}'
    assert told[-1].endswith('to the end')


def test_evidence_that_was_sent_away_sees_the_same(fitted):
    evaluator, nominal = fitted
    again = pickle.loads(pickle.dumps(evaluator))
    assert again.model.bodies[0] is not evaluator.model.bodies[0]
    sent = again.groups(nominal.coordinates)
    for here, there in zip(evaluator.groups(nominal.coordinates), sent, strict=True):
        np.testing.assert_allclose(there.patches.values, here.patches.values, atol=1e-8)
        np.testing.assert_allclose(there.patches.covariance, here.patches.covariance)
        np.testing.assert_array_equal(there.patches.cells, here.patches.cells)


def test_evidence_that_was_sent_away_goes_on_from_where_it_is(fitted):
    evaluator, nominal = fitted
    there = evaluator.model.worlds(nominal.coordinates)[0]
    again = pickle.loads(pickle.dumps(evaluator)).model
    from_rest = ForwardModel(again.scene, again.observations, again.parameters)
    here, _ = again.worlds(nominal.coordinates)[0], from_rest.worlds(nominal.coordinates)
    state, settled = again.bodies[0].body.own_state, from_rest.bodies[0].body.own_state
    assert state.newton_steps < settled.newton_steps
    np.testing.assert_allclose(here, there, atol=1e-8)


@pytest.mark.parametrize(
    ('effect', 'amplitudes'),
    [
        ('strain_stiffening', {'ratio': 8.0}),
        ('anisotropy', {'ratio': 0.5}),
        ('contact_plane', {'height': -0.004}),
        ('compliant_clamp', {'compliance': 3.0}),
        ('rest_curvature', {'a': 2.0}),
    ],
)
def test_a_scene_that_has_an_effect_is_sent_with_where_its_body_is(effect, amplitudes):
    scene = replace(beam_scene((6, 2, 2)), effects={effect: amplitudes})
    seen = watched(seed=2)
    parameters = make_parameters(scene, ('youngs_modulus',), with_edge_bias=False)
    model = ForwardModel(scene, [seen], parameters)
    here = model.worlds(parameters.start())[0]
    there = pickle.loads(pickle.dumps(model))
    np.testing.assert_allclose(there.worlds(parameters.start())[0], here, atol=1e-8)
    plain = ForwardModel(replace(scene, effects={}), [seen], parameters)
    assert np.abs(plain.worlds(parameters.start())[0] - here).max() > 1e-5


@pytest.mark.slow
def test_processes_that_have_begun_find_the_same(fitted, added):
    requests = [RefitRequest(one, {}, 4) for one in added]
    alone = RefitPool(*fitted).refit_all(requests)
    evaluator, base = fitted
    # What is off by more than its noise, after a fit that took long.
    off = replace(base, groups=moved(base.groups, np.full(len(base.coordinates), 0.05)))
    with processes_begun(evaluator, off, 9.0, 2) as processes:
        assert processes is not None
        with RefitPool(evaluator, base, jobs=2, processes=processes) as pool:
            found = pool.refit_all(requests)
    for here, there in zip(alone, found, strict=True):
        np.testing.assert_allclose(
            there.fit.coordinates, here.fit.coordinates, rtol=1e-5, atol=1e-9
        )
        assert there.fit.log_evidence == pytest.approx(here.fit.log_evidence, abs=1e-3)


@pytest.mark.parametrize(
    ('seconds', 'jobs', 'step'), [(9.0, 1, 0.05), (0.5, 2, 0.05), (9.0, 2, 0.0)]
)
def test_no_process_begins_for_nothing(fitted, added, seconds, jobs, step):
    evaluator, base = fitted
    right = try_effects(evaluator, base, added[0], {}).fit
    groups = moved(right.groups, np.full(len(right.coordinates), step))
    with processes_begun(evaluator, replace(right, groups=groups), seconds, jobs) as processes:
        assert processes is None


def test_a_late_look_is_given_up_where_it_will_not_come_near(fitted, added):
    evaluator, base = fitted
    right, wrong = added if added[0][0].identifier == 'depth_affine' else added[::-1]
    pool = RefitPool(evaluator, base)
    brief = pool.refit_all([RefitRequest(right, {}, 8)])
    late = RefitRequest(wrong, _FAR, 8)
    (alone,) = pool.refit_all([late])
    found = finished(pool, brief, late=[late])
    assert [h.identifiers[0] for h in found] == [right[0].identifier, wrong[0].identifier]
    assert found[0].log_evidence > found[1].log_evidence + 40.0
    assert found[1].fit.evaluations < alone.fit.evaluations
    # With no rival it is looked at to its end.
    (only,) = finished(pool, [], late=[late])
    assert only.fit.log_evidence >= alone.fit.log_evidence - 0.1


def test_a_model_with_other_parameters_keeps_its_bodies(fitted):
    model = fitted[0].model
    other = model.with_parameters(model.scene, model.parameters)
    assert other.bodies is model.bodies


@pytest.mark.slow
def test_work_goes_on_where_a_process_dies(fitted, monkeypatch):
    monkeypatch.setattr(refit_pool, '_WORTH_STARTING', -1.0)
    told = []
    with RefitPool(*fitted, told.append, jobs=2) as pool:
        assert pool._fits([Death(os.getpid())] * 3) == [fitted[1]] * 3
        assert pool._processes is None
    assert any('a process died' in words for words in told)


def test_work_goes_on_where_a_process_dies_before_it_has_begun(fitted, tmp_path, monkeypatch):
    monkeypatch.setattr(refit_pool, '_WORTH_STARTING', -1.0)
    stillborn = tmp_path / 'python'
    stillborn.write_text(
        f'#!/bin/sh\ncase "$*" in *resource_tracker*) exec {sys.executable} "$@";; esac\nexit 1\n'
    )
    stillborn.chmod(0o755)
    monkeypatch.setattr(spawn, '_python_exe', os.fsencode(stillborn))
    assert len(pickle.dumps(fitted)) > 2 * _PIPE
    told = []
    with RefitPool(*fitted, told.append, jobs=2) as pool:
        assert pool._fits([Death(os.getpid())] * 3) == [fitted[1]] * 3
        assert pool._processes is None
    assert any('a process died' in words for words in told)


@pytest.mark.parametrize('error', [OSError('no memory'), ValueError('fds_to_keep')])
@pytest.mark.slow
def test_a_process_that_cannot_be_started_is_told_as_dead(monkeypatch, error):
    """Pipes of a pool whose first process died may be closed while another one begins."""

    def submit(*_):
        raise error

    processes = Processes(2)
    monkeypatch.setattr(processes._pool, 'submit', submit)
    with pytest.raises(BrokenProcessPool, match='cannot be started'):
        processes.submit(Death(os.getpid()))
    processes.end()


def test_little_work_starts_no_process(fitted, added):
    with RefitPool(*fitted, jobs=4) as pool:
        pool.refit_all([RefitRequest(one, {}, 2) for one in added])
        assert pool._processes is None


def test_a_model_far_behind_its_rivals_is_given_up(fitted, added):
    evaluator, base = fitted
    right, wrong = added if added[0][0].identifier == 'depth_affine' else added[::-1]
    best = try_effects(evaluator, base, right, {})
    whole = try_effects(evaluator, base, wrong, _FAR)
    brief = try_effects(
        evaluator, base, wrong, _FAR, least_log_evidence=best.fit.log_evidence - 40.0
    )
    assert whole.fit.log_evidence < best.fit.log_evidence - 60.0
    assert brief.fit.evaluations < whole.fit.evaluations
    assert brief.fit.log_evidence < best.fit.log_evidence - 40.0
    # One that comes near is fitted as if it were alone.
    near = try_effects(evaluator, base, right, {}, least_log_evidence=best.fit.log_evidence - 40.0)
    assert near.fit.evaluations == best.fit.evaluations
    np.testing.assert_allclose(near.fit.coordinates, best.fit.coordinates, rtol=1e-4)


def test_a_model_that_ran_out_of_evaluations_and_may_still_win_is_fitted_on(
    fitted, added, monkeypatch
):
    # Fits to the end run out after two.
    brief_end = partialmethod(RefitPool.finish_beside, max_iterations=2)
    monkeypatch.setattr(RefitPool, 'finish_beside', brief_end)
    told = []
    pool = RefitPool(*fitted, told.append)
    right = added[0] if added[0][0].identifier == 'depth_affine' else added[1]
    brief = pool.refit_all([RefitRequest(right, {'depth_affine.bias': -0.05}, 2)])
    (once,) = pool.finish(brief, [-np.inf], 2)
    assert not once.fit.is_converged
    told.clear()
    (found,) = finished(pool, brief)
    assert len(told) == 2
    assert found.fit.log_evidence > once.fit.log_evidence


def test_a_model_goes_on_where_it_may_win_in_some_form(fitted, added):
    """However far behind it is in the library's: the judgement has a step behind it."""
    pool = RefitPool(*fitted)
    right, wrong = added if added[0][0].identifier == 'depth_affine' else added[::-1]
    brief = pool.refit_all([RefitRequest(right, {}, 2), RefitRequest(wrong, _FAR, 2)])
    assert not any(model.fit.is_converged for model in brief)
    assert brief[0].log_evidence > brief[1].log_evidence + 100.0

    def judged(models):
        """Return them as if the wrong one were ahead in any form."""
        ahead = {wrong: 0.0, right: -1000.0}
        return [replace(model, guessed=ahead[model.added]) for model in models]

    first, second = finished(pool, brief, judge=judged)
    assert {first.added, second.added} == {right, wrong}
    went_on = {model.added for model in (first, second) if model.fit.evaluations > 2}
    assert went_on == {wrong}
    # Halfway down a front runner is judged where it happens to stand.
    leading = finished(pool, brief, frozenset({right[0].identifier}), judge=judged)
    assert all(model.fit.is_converged for model in leading)
    assert not all(model.fit.is_converged for model in (first, second))


def test_a_fit_halfway_down_promises_what_is_left(fitted, added):
    evaluator, base = fitted
    right = added[0] if added[0][0].identifier == 'depth_affine' else added[1]
    whole = try_effects(evaluator, base, right, {}).fit
    brief = try_effects(evaluator, base, right, {}, max_iterations=1).fit
    assert not whole.promise > 0.1
    left = whole.log_evidence - brief.log_evidence
    assert left > 50.0
    assert 0.5 * left < brief.promise < 2.0 * left
