# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body that is clamped otherwise in each pose: named, and its modulus comes right."""

from diffcal_ros.diagnosis.answers import Verdict
from diffcal_ros.diagnosis.diagnose import diagnose
import pytest
from support.clamped_anew import clamped_anew
from support.scenes import MODULUS


@pytest.mark.slow
def test_a_body_that_is_clamped_anew_in_each_pose_has_its_name_and_its_modulus():
    trace = diagnose(*clamped_anew())
    diagnosis = trace.diagnosis
    assert diagnosis.verdict is Verdict.DISAGREE
    assert [effect.identifier for effect in diagnosis.effects] == ['clamp_offset']
    gap = diagnosis.gap_mm
    assert gap.nominal > 1.0
    assert gap.added < gap.floor_numerics
    assert any('clamp_offset is another one in each pose' in note for note in diagnosis.notes)
    before, after = (diagnosis.parameters[when]['youngs_modulus'] for when in ('before', 'after'))
    assert abs(before['value'] - MODULUS) > 10.0 * before['std_error'], 'it was drawn'
    assert after['value'] == pytest.approx(MODULUS, rel=0.03)
    assert abs(after['value'] - MODULUS) < 3.0 * after['std_error']
