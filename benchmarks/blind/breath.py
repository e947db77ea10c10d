# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Breath on a sensor's window, which dries from its edge inwards."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.setups import Observation, Setup
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.wiping import wiped_share


def breath_share(
    rendering: Rendering, setup: Setup, observation: Observation, faults: Faults
) -> FloatArray:
    """Return how much of an error there is of what is seen through breath, shape (h, w, 1).

    Args:
        rendering: says which part of the image it is.
        setup: the camera.
        observation: the pose.
        faults: say where the breath's middle is, and how far it reaches from there in each pose.
    """
    reach = faults.depth_places[setup.pose_number(observation)]
    return 1.0 - wiped_share(rendering, setup, faults, reach)


def dried_reach(count: int, lasts: float) -> FloatArray:
    """Return how far breath reaches in each pose, over how far it does in the first, (count,).

    It dries as fast all over, so that as much of its area goes from pose to pose.

    Args:
        count: of poses, which are alike in time.
        lasts: how many poses it takes until nothing is left, more than there are.
    """
    return np.asarray(np.sqrt(1.0 - np.arange(count) / lasts))
