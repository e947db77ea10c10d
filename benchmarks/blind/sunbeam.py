# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Sun that comes through a slit between curtains, and wanders over an image from pose to pose."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.peeling import ways_aslant
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
    wandered = faults.depth_wander * setup.pose_number(observation)
    away = ways_aslant(rendering, setup, faults) - wandered
    return np.asarray(np.exp(-((away / faults.depth_width) ** 2)))[..., None]
