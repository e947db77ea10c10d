# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What rests on single poses is in doubt, and what is seen is not."""

from types import SimpleNamespace

from diffcal_ros.diagnosis.model_comparison.choice import _as_near_by_poses
import pytest

BEST = SimpleNamespace(identifiers=('compliant_clamp',), level=-200.0, chi_square=143.0)


@pytest.mark.parametrize(
    ('level', 'chi_square', 'owed', 'is_near'),
    [
        (-213.0, 141.0, 360.0, True),
        (-213.0, 141.0, 60.0, False),
        (-213.0, 141.0, 0.0, False),
        (-202.0, 141.0, 0.0, False),
        (-213.0, 160.0, 360.0, False),
        (-243.0, 141.0, 360.0, False),
    ],
)
def test_who_leaves_as_little_and_is_behind_by_what_is_believed_is_near(
    level, chi_square, owed, is_near
):
    rival = SimpleNamespace(identifiers=('clamp_offset',), level=level, chi_square=chi_square)
    found = _as_near_by_poses(BEST, [BEST, rival], 0.1 * owed, 5.0)
    assert found == ({('clamp_offset',)} if is_near else set())
