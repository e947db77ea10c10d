# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The depth camera reads (1 + scale) z + bias, or another bias over its picture."""

from diffcal_ros.effects.effect import Component, Effect, FloatArray
from diffcal_ros.effects.site import SeenPixels
import numpy as np

# Powers of x / z and y / z by which the bias may differ over the picture, and half of a usual
# picture: at its edge a usual amount is as much as a usual bias.
_POWERS = {
    'x' * across + 'y' * down: (across, down)
    for degree in (1, 2, 3)
    for down in range(degree + 1)
    for across in (degree - down,)
}
_EDGE = 0.3
_BIAS = Component('bias', 'm', -0.05, 0.05, 0.005, 'mm', 1e3)


def _over_picture(name: str, degree: int) -> Component:
    """Return an amount of a power, which may be ten times a usual one."""
    usual = _BIAS.scale / _EDGE**degree
    return Component(name, 'm', -10.0 * usual, 10.0 * usual, usual, 'mm', 1e3)


class DepthAffine(Effect):
    """An error of every depth, whatever it shows."""

    identifier = 'depth_affine'
    group = 'sensor'
    components = (
        Component('scale', '1', -0.1, 0.1, 0.03, '%', 100.0),
        _BIAS,
    )
    forms = tuple(_over_picture(name, sum(powers)) for name, powers in _POWERS.items())
    form = 'the error is another one over the picture'
    sentence = 'the depth camera reads too far or too near'
    settles = ('a rigid target at two known distances',)
    twins = ('camera_offset',)
    variants = (('bias',), ('scale',), ('scale', 'bias'))
    # A camera warms up.
    most_by_pose = 1.0

    def depth_error_mode(self, component: str, seen: SeenPixels) -> FloatArray:
        """Return the derivative by scale [m], bias or an amount of a power."""
        if component == 'scale':
            return seen.depth
        if component == 'bias':
            return np.ones_like(seen.depth)
        if seen.directions is None:
            return np.zeros_like(seen.depth)
        across, down = _POWERS[component]
        x, y = np.moveaxis(seen.directions, -1, 0)
        return np.asarray(x**across * y**down)
