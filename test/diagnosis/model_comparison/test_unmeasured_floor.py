# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effects in single images, whose noise nobody has measured: fits are robust, and stand so."""

from dataclasses import replace

from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.diagnosis.diagnose import fit_nominal
from diffcal_ros.diagnosis.model_comparison.absence import has_doubtful_effect
from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.patch_fits.refit import Refit
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


def _with_step_fitted(seen: Observation) -> tuple[Hypothesis, Refit]:
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
    return found, nominal


def test_a_deep_step_is_not_drawn_to_nothing():
    found, nominal = _with_step_fitted(with_step(watched(seed=4), 0.5, -STEP))
    (amplitude,) = found.amplitudes(found.added[0])
    assert amplitude.value == pytest.approx(-1e3 * STEP, abs=1e3 * CLOSE)
    assert not has_doubtful_effect(found, nominal)


def test_a_step_that_is_not_there_may_as_well_be_absent():
    found, nominal = _with_step_fitted(watched(seed=4))
    assert has_doubtful_effect(found, nominal)


def test_noise_that_is_larger_than_stated_makes_an_amplitude_less_sure():
    found, _ = _with_step_fitted(with_step(watched(seed=4), 0.5, 0.002))
    (step,) = found.added
    chances = [found.chance_of_zero(step, scale) for scale in (0.1, 1.0, 10.0, 1e6)]
    assert chances[0] == chances[1] < chances[2] < chances[3]
    assert chances[3] == pytest.approx(1.0, abs=0.05)
    assert np.isfinite(found.log_evidence)
