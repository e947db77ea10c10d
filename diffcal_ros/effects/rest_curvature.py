# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The body is bent when nothing pulls on it, about two axes across it."""

from diffcal_ros.effects.along_body import at_share
from diffcal_ros.effects.effect import Component, Effect, FloatArray, Numbers
from diffcal_ros.effects.rigid import pair_of
from diffcal_ros.effects.site import Site
from diffcal_ros.fem.terms.conditions import Conditions
import numpy as np

# Parts of the free length in each of which the curvature may be another one.
_PARTS = 6
_WAYS = {
    'twist': 'of twist',
    **{
        f'{axis}_{part + 1}': f'about {axis}, {at_share((part + 0.5) / _PARTS)}'
        for part in range(_PARTS)
        for axis in 'ab'
    },
}


class RestCurvature(Effect):
    """A shape without stress that is an arc."""

    identifier = 'rest_curvature'
    group = 'shape'
    components = tuple(
        Component(a, '1/m', -20.0, 20.0, 2.0, '1/m', 1.0, by_length=-1) for a in ('a', 'b')
    )
    sentence = 'the body is bent when nothing pulls on it'
    settles = ('a pose with the body rolled by 180 degrees',)
    twins = ('clamp_offset', 'gravity_tilt')
    forms = tuple(
        Component(name, '1/m', -60.0, 60.0, 2.0, '1/m', 1.0, where=where, by_length=-1)
        for name, where in _WAYS.items()
    )

    form = 'its curvature is another one along the body, or it is twisted'

    def conditions(self, own: Numbers, site: Site) -> Conditions:
        """Return the curvature, and what it is more in parts of the length."""
        twist, *more = (own.get(part.name, 0.0) for part in self.forms)
        bends = None
        if twist or any(more):
            bends = np.column_stack([np.full(_PARTS, twist), np.reshape(more, (_PARTS, 2))])
        return Conditions(rest_curvature=pair_of(own), rest_bends=bends)

    def frame(self, own: Numbers, site: Site) -> dict[str, FloatArray]:
        """`a` and `b` are axes in the object's frame; they go along with a bent body."""
        return {'a': site.object_axes.at_root[1], 'b': site.object_axes.at_root[2]}
