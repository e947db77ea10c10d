# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The beam before a ChArUco board, of which it covers a part."""

import json
from pathlib import Path

from diffcal_ros.synthetic.recorder import SyntheticRecording
import numpy as np

from support.recorded_beam import record_beam

# The board is 144 x 168 mm, its squares 30 px wide, a third behind the beam: measured up to 0.7 mm
# and 0.13 degrees.
SHIFT, TURN = 1e-3, np.deg2rad(0.3)
_BOARD = {
    'board': {'columns': 6, 'rows': 7, 'square': 0.024},
    'dictionary': 'DICT_4X4_50',
    'side': 0.018,
    'placement': {'translation': [-0.03, -0.03, -0.08]},
}


def record_board_beam(folder: Path) -> SyntheticRecording:
    """Film the beam and the board behind it into `folder`/recorded."""
    return record_beam(folder, {'marker': _BOARD})


def pose_error(recorded: SyntheticRecording, depth_from_world: np.ndarray) -> tuple[float, float]:
    """Tell how far [m] and by what angle [rad] a found camera is off."""
    truth = json.loads(recorded.truth.read_text())['observations']
    (expected,) = (np.array(own['depth_from_world']) for own in truth.values())
    error = depth_from_world @ np.linalg.inv(expected)
    cosine = np.clip((np.trace(error[:3, :3]) - 1.0) / 2.0, -1.0, 1.0)
    return float(np.linalg.norm(error[:3, 3])), float(np.arccos(cosine))
