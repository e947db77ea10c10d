# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Sun that comes through a slit between curtains, and wanders over an image from pose to pose."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.setups import Observation, Setup
from benchmarks.blind.shapes import FloatArray


def sunbeam_share(
    rendering: Rendering, setup: Setup, observation: Observation, faults: Faults
) -> FloatArray:
    """Return how much of an error is there, 1 amid a beam, pixel by pixel, shape (h, w, 1).

    It falls by the exponential of the square of the way to the beam's middle line.

    Args:
        rendering: says which part of the image it is.
        setup: the camera and the poses.
        observation: the pose.
        faults: say where the beam is at first, which way it wanders and how far, and its width.
    """
    height, width = rendering.depth.shape[:2]
    across, down = faults.depth_spot
    angle = np.deg2rad(faults.depth_slant)
    rows = rendering.row + np.arange(height)[:, None] - (setup.camera.cy + down)
    columns = rendering.column + np.arange(width)[None] - (setup.camera.cx + across)
    wandered = faults.depth_wander * setup.pose_number(observation)
    away = np.cos(angle) * columns + np.sin(angle) * rows - wandered
    return np.asarray(np.exp(-((away / faults.depth_width) ** 2)))[..., None]
