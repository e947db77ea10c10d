# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The depth camera reads (1 + scale) z + bias, or another bias over its picture or by angle.

Beyond an edge in its picture it may read otherwise at once: see `picture_edge`.

What falls on a lens or in front of it, a smudge, a beam of light, what a wall throws back, is
somewhere in the picture, and follows no polynomial of it.

What is met aslant throws back less light, and cameras that time light or see its phase read other
depths from what is darker (Lindner, Schiller, Kolb and Koch, *Time-of-Flight sensor calibration
for accurate range sensing*, Computer Vision and Image Understanding 114, 2010).
"""

from dataclasses import replace

from diffcal_ros.effects import picture_edge
from diffcal_ros.effects.along_body import hat
from diffcal_ros.effects.effect import Component, Effect, FloatArray, Numbers
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
# Places in the picture, x / z and y / z, at which it may be another one, and is to all sides in
# proportion to the next ones; beyond the outermost as there.
_ACROSS, _DOWN = np.linspace(-0.45, 0.45, 7), np.linspace(-0.3, 0.3, 5)
_PLACES = {
    f'spot_{len(_ACROSS) * down + across + 1}': (across + 1, down + 1)
    for down in range(len(_DOWN))
    for across in range(len(_ACROSS))
}
# Powers of one less the cosine of the angle at which a surface is met, which is a half where it is
# met at 60 degrees: there a usual amount is as much as a usual bias.
_ASLANT = {'aslant': 1, 'aslant_2': 2}
_HALF = 0.5
_BIAS = Component('bias', 'm', -0.05, 0.05, 0.005, 'mm', 1e3)
# By how much more it reads too far beyond an edge.
_BEYOND = 'beyond'


def _power(name: str, degree: int, edge: float, where: str) -> Component:
    """Return an amount of a power, which may be ten times a usual one; it is shown at an edge."""
    whole = edge**degree
    usual, shown = _BIAS.scale / whole, _BIAS.shown_factor * whole
    most = 10.0 * usual
    return Component(name, 'm', -most, most, usual, _BIAS.shown_unit, shown, where=where)


def _spot(name: str) -> Component:
    """Return an amount of a bias around a place in the picture."""
    column, row = _PLACES[name]
    where = f'around x / z = {_ACROSS[column - 1]:.2f}, y / z = {_DOWN[row - 1]:.2f}'
    return replace(_BIAS, name=name, where=where)


class DepthAffine(Effect):
    """An error of every depth, whatever it shows."""

    identifier = 'depth_affine'
    group = 'sensor'
    components = (
        Component('scale', '1', -0.1, 0.1, 0.03, '%', 100.0),
        _BIAS,
        replace(_BIAS, name=_BEYOND),
    )
    settings = picture_edge.SETTINGS
    map_pattern = picture_edge.PATTERN
    has_edge = True
    forms = (
        *(
            _power(name, sum(powers), _EDGE, f'by {name} at the edge of the picture')
            for name, powers in _POWERS.items()
        ),
        *(
            _power(name, degree, _HALF, 'where a surface is met at 60 degrees')
            for name, degree in _ASLANT.items()
        ),
        *map(_spot, _PLACES),
    )
    form = 'the error is another one over the picture, or by the angle at which a surface is met'
    sentence = 'the depth camera reads too far or too near'
    settles = ('a rigid target at two known distances',)
    twins = ('camera_offset',)
    variants = (('bias',), ('scale',), ('scale', 'bias'))
    # A camera warms up.
    most_by_pose = 1.0
    varying = ('scale', 'bias')

    def components_in(self, settings: Numbers) -> tuple[Component, ...]:
        """Return its amplitudes; without an edge nothing is beyond it."""
        is_there = picture_edge.has_edge(settings)
        return tuple(part for part in self.components if is_there or part.name != _BEYOND)

    def variants_in(self, settings: Numbers) -> tuple[tuple[str, ...], ...]:
        """Return what is tried, with what is beyond an edge where there is one."""
        if not picture_edge.has_edge(settings):
            return self.variants
        return (*self.variants, (_BEYOND,), ('bias', _BEYOND))

    def limits_of(self, setting: str) -> tuple[float, float]:
        """Return what a setting may be."""
        return picture_edge.setting_limits(setting)

    def depth_error_mode(self, component: str, seen: SeenPixels) -> FloatArray:
        """Return the derivative by scale [m], bias or an amount of a power."""
        if component == 'scale':
            return seen.depth
        if component == 'bias':
            return np.ones_like(seen.depth)
        if component == _BEYOND:
            return np.zeros_like(seen.depth) if seen.beyond is None else seen.beyond
        if component in _ASLANT:
            aslant = np.zeros_like(seen.depth) if seen.facing is None else 1.0 - seen.facing
            return aslant ** _ASLANT[component]
        if seen.directions is None:
            return np.zeros_like(seen.depth)
        x, y = np.moveaxis(seen.directions, -1, 0)
        if component in _PLACES:
            column, row = _PLACES[component]
            return np.asarray(hat(x, _ACROSS, column) * hat(y, _DOWN, row))
        across, down = _POWERS[component]
        return np.asarray(x**across * y**down)
