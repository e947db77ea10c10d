# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The depth camera reads (1 + scale) z + bias."""

from diffcal_ros.effects.effect import Component, Effect, FloatArray
from diffcal_ros.effects.site import SeenPixels
import numpy as np


class DepthAffine(Effect):
    """An error of every depth, whatever it shows."""

    identifier = 'depth_affine'
    group = 'sensor'
    components = (
        Component('scale', '1', -0.1, 0.1, 0.03, '%', 100.0),
        Component('bias', 'm', -0.05, 0.05, 0.005, 'mm', 1e3),
    )
    sentence = 'the depth camera reads too far or too near'
    settles = ('a rigid target at two known distances',)
    twins = ('camera_offset',)
    variants = (('bias',), ('scale',), ('scale', 'bias'))
    # A camera warms up.
    most_by_pose = 1.0

    def depth_error_mode(self, component: str, seen: SeenPixels) -> FloatArray:
        """Return the derivative by scale [m] or bias."""
        return seen.depth if component == 'scale' else np.ones_like(seen.depth)
