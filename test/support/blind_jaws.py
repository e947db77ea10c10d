# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How jaws that are pitched otherwise than stated hold blind bodies."""

import numpy as np
import pytest

from benchmarks.blind.rotations import rotation
from benchmarks.blind.setups import Setup
from support.blind_draws import draw_faults


def pitched_in_poses(key: str, drawn: Setup, size: int) -> tuple[np.ndarray, np.ndarray]:
    """Return how a body is pitched in each pose as stated, and as it is [rad], shape (4,) each.

    It turns up or down about what is at the hinge, and not aside.

    Args:
        key: of the form, `effect/form`.
        drawn: the rig.
        size: of the form.
    """
    center = np.array([0.5 * drawn.shape.clamp, 0.0, 0.0])
    scatter = np.array(draw_faults(key, drawn, size).clamp_scatter)
    pitches = []
    for motion, pose in zip(scatter, drawn.observations, strict=True):
        turn = rotation(np.deg2rad(motion[3:]))
        assert center - turn @ center + 1e-3 * motion[:3] == pytest.approx(0.0, abs=1e-6)
        ways = [pose.world_from_object[:3, :3] @ each[:, 0] for each in (np.eye(3), turn)]
        assert np.cross(*ways)[1] == pytest.approx(0.0, abs=1e-4)
        yaws = [np.arctan2(way[2], way[0]) for way in ways]
        assert yaws[1] == pytest.approx(yaws[0], abs=1e-4)
        pitches.append([np.arctan2(way[1], np.hypot(way[0], way[2])) for way in ways])
    before, after = np.transpose(pitches)
    return before, after
