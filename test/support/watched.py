# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Observations of a beam that were watched for several frames, from another mesh."""

from dataclasses import replace

from diffcal_ros.calibration.observation import Observation
import numpy as np
from scipy.ndimage import gaussian_filter

from support.scenes import noisy, observation, true_depth

_FRAMES = 8


def watched(*, seed: int, tilt: float = 0.0, bias: float = 0.0) -> Observation:
    """Look at the beam for eight frames.

    Args:
        seed: of noise and of the sensor's smooth error.
        tilt: of gravity about the axis towards the camera [rad].
        bias: of the depth camera [m].
    """
    random = np.random.default_rng(seed)
    gravity = 9.8 * np.array([0.0, -np.cos(tilt), np.sin(tilt)])
    exact = true_depth(gravity=gravity) + bias
    smooth = gaussian_filter(random.normal(size=exact.shape), 40.0)
    exact = exact + 0.00012 * smooth / smooth.std()
    depth = np.median([noisy(exact, random) for _ in range(_FRAMES)], axis=0)
    noise = 0.00014 * np.sqrt(np.pi / (2.0 * _FRAMES))
    return replace(observation(depth), frame_count=_FRAMES, noise=float(noise))
