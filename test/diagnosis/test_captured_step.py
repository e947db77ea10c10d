# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The LIDAR looks into one of two real silicones: a diagnosis of one image says so."""

from pathlib import Path

from diffcal_ros.diagnosis.answers import Verdict
from diffcal_ros.diagnosis.diagnose import diagnose
import pytest
from support.captures import load_case

# A calibration that looks for the step by itself finds 23.5 +- 0.6 and 19.5 +- 2.1 mm.
SHALLOWEST, DEEPEST = 17.0, 25.0
# What may be left beside the step, in the median of patches that no fit has seen [mm].
MOST_LEFT = 1.2


@pytest.mark.slow
@pytest.mark.parametrize('case', ['h_em_c', 't_em_c'])
def test_the_step_between_two_silicones_has_its_name(diffcal_data: Path, case: str) -> None:
    scene, observations = load_case(diffcal_data, case, 'estimated')
    diagnosis = diagnose(scene, observations).diagnosis
    assert diagnosis.verdict is Verdict.DISAGREE
    assert diagnosis.ambiguity_set == ('depth_bias_by_region',)
    (step,) = diagnosis.effects
    assert SHALLOWEST < step.amplitude['bias'] < DEEPEST
    assert diagnosis.gap_mm.median_added < MOST_LEFT
    assert diagnosis.closure > 0.7
