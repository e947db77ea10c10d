# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effects in single images, whose noise nobody has measured: fits are robust, and stand so."""

from dataclasses import replace
from types import SimpleNamespace

from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.diagnosis.model_comparison import effect_refit, pair_search
from diffcal_ros.diagnosis.model_comparison.absence import has_doubtful_effect
from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.nominal_fit import fit_nominal
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.screening.candidates import candidates
import numpy as np
import pytest
from support.scenes import beam_scene
from support.watched import watched, with_step

# A silicone that a LIDAR looks into, four usual steps deep [m].
STEP = 0.020
# The step is read off hundreds of pixels; what modulus and offset may follow of it [m].
CLOSE = 0.0007


def _one_frame(observation: Observation) -> Observation:
    return replace(observation, frame_count=1, noise=float('nan'))


def _with_step_fitted(seen: Observation) -> tuple[Hypothesis, PatchEvaluator, Refit]:
    scene = replace(
        beam_scene((6, 2, 2), fit=('youngs_modulus', 'rigid_offset')),
        effects={'depth_bias_by_region': {'at': 0.5}, 'stiffness_contrast': {'at': 0.5}},
    )
    evaluator, nominal = fit_nominal(scene, [_one_frame(seen)], None)
    assert not evaluator.is_measured
    listed = candidates(evaluator.model.scene, (), None)
    (step,) = [c for c in listed if c.identifier == 'depth_bias_by_region']
    found = try_effects(evaluator, nominal, (step,), {})
    assert found is not None
    return found, evaluator, nominal


@pytest.mark.slow
def test_a_deep_step_is_not_drawn_to_nothing():
    found, _, nominal = _with_step_fitted(with_step(watched(seed=4), 0.5, -STEP))
    (amplitude,) = found.amplitudes(found.added[0])
    assert amplitude.value == pytest.approx(-1e3 * STEP, abs=1e3 * CLOSE)
    assert not has_doubtful_effect(found, nominal)


@pytest.mark.slow
def test_a_step_that_is_not_there_may_as_well_be_absent():
    found, _, nominal = _with_step_fitted(watched(seed=4))
    assert has_doubtful_effect(found, nominal)


@pytest.mark.slow
def test_noise_that_is_larger_than_stated_makes_an_amplitude_less_sure():
    found, _, _ = _with_step_fitted(with_step(watched(seed=4), 0.5, 0.002))
    (step,) = found.added
    chances = [found.chance_of_zero(step, scale) for scale in (0.1, 1.0, 10.0, 1e6)]
    assert chances[0] == chances[1] < chances[2] < chances[3]
    assert chances[3] == pytest.approx(1.0, abs=0.05)
    assert np.isfinite(found.log_evidence)


def _leaving(fit: Refit, residual: float) -> Refit:
    """Return a fit that leaves as much on every patch [m]."""
    groups = []
    for group in fit.groups:
        values = np.full_like(group.patches.values, residual)
        groups.append(replace(group, patches=replace(group.patches, values=values)))
    return replace(fit, groups=groups)


@pytest.mark.slow
def test_of_several_ends_the_one_that_meets_most_patches_is_kept(monkeypatch):
    """Squares in units of a guess would choose one that is 5 mm off everywhere."""
    found, evaluator, nominal = _with_step_fitted(with_step(watched(seed=4), 0.5, -STEP))
    begun = []
    ends = [
        replace(_leaving(found.fit, 0.005), log_evidence=-100.0),
        replace(_leaving(found.fit, 0.001), log_evidence=-900.0),
        replace(_leaving(found.fit, 0.004), log_evidence=-200.0),
    ]

    def end(evaluator, base, starts, *rest):
        begun.append(starts)
        return ends[len(begun) % len(ends)]

    monkeypatch.setattr(effect_refit, '_refit_from', end)
    kept = try_effects(evaluator, nominal, found.added, {})
    assert kept is not None
    assert kept.fit is ends[1]
    (name,) = found.added[0].names
    # One of them is where there is no step.
    assert begun[-1] == {name: 0.0}
    assert len(begun) > 2


@pytest.fixture(scope='module')
def one_and_two():
    """A fit with a step, and one with a tilt besides."""
    found, evaluator, nominal = _with_step_fitted(with_step(watched(seed=4), 0.5, -STEP))
    tilt = next(c for c in candidates(found.scene) if c.identifier == 'gravity_tilt')
    both = try_effects(evaluator, nominal, (*found.added, tilt), {})
    assert both is not None
    return found, both


@pytest.mark.parametrize(
    ('single_leaves', 'pair_leaves', 'asked'),
    [(0.004, 0.001, [('depth_bias_by_region',), ('gravity_tilt',)]), (0.001, 0.004, [])],
)
@pytest.mark.slow
def test_each_effect_of_a_better_pair_is_fitted_alone_from_where_the_pair_ended(
    one_and_two, single_leaves, pair_leaves, asked
):
    single, pair = (
        replace(own, fit=_leaving(own.fit, leaves))
        for own, leaves in zip(one_and_two, (single_leaves, pair_leaves), strict=True)
    )
    requests = []

    def refit_all(listed):
        requests.extend(listed)
        return [single] * len(listed)

    pool = SimpleNamespace(nominal=single.evaluator, refit_all=refit_all)
    halves = pair_search.halves(pool, [single], [pair], None)
    assert [tuple(c.identifier for c in own.added) for own in requests] == asked
    assert all(own.starts == pair.fit.values_by_name() for own in requests)
    assert halves == [single] * len(asked)
