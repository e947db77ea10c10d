# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The film on a new sensor's window, which peels off from one side, and ways aslant an image."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.setups import Observation, Setup
from benchmarks.blind.shapes import FloatArray


def film_share(
    rendering: Rendering, setup: Setup, observation: Observation, faults: Faults
) -> FloatArray:
    """Return how much of an error there is of what is seen through a film, shape (h, w, 1).

    The film's edge lies far before what a lens is focused on, so that it is blurred.

    Args:
        rendering: says which part of the image it is.
        setup: the camera and the poses.
        observation: the pose.
        faults: say how far its edge has come in each pose, which way, and how much it is blurred.
    """
    edge = faults.depth_places[setup.pose_number(observation)]
    beyond = (ways_aslant(rendering, setup, faults) - edge) / faults.depth_width
    return np.asarray(0.5 * (1.0 + np.tanh(beyond)))[..., None]


def ways_aslant(rendering: Rendering, setup: Setup, faults: Faults) -> FloatArray:
    """Return how far pixels lie from a spot in a way aslant the image [px], shape (h, w).

    Args:
        rendering: says which part of the image it is.
        setup: the camera.
        faults: say where the spot is from the principal point, and which way.
    """
    height, width = rendering.depth.shape[:2]
    across, down = faults.depth_spot
    angle = np.deg2rad(faults.depth_slant)
    rows = rendering.row + np.arange(height)[:, None] - (setup.camera.cy + down)
    columns = rendering.column + np.arange(width)[None] - (setup.camera.cx + across)
    return np.asarray(np.cos(angle) * columns + np.sin(angle) * rows)
