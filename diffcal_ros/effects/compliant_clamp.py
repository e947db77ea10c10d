# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The clamp turns with the moment of the body on it, and shifts with its force."""

from diffcal_ros.effects.effect import Component, Effect, FloatArray, Numbers
from diffcal_ros.effects.site import Site
from diffcal_ros.fem.conditions import Conditions
import numpy as np

_TURN = ('rad/(N m)', 0.0, 100.0, 5.0, 'rad/(N m)', 1.0)
_ACROSS = ('compliance_a', 'compliance_b')


class CompliantClamp(Effect):
    """A clamp that gives way."""

    identifier = 'compliant_clamp'
    group = 'boundary'
    components = (
        Component('compliance', *_TURN),
        Component('shift_compliance', 'm/N', 0.0, 0.1, 0.005, 'mm/N', 1e3),
        *(Component(name, *_TURN) for name in _ACROSS),
    )
    sentence = 'the clamp gives way under the load'
    settles = ('a second load', 'a pose that loads the clamp otherwise')
    # A shift under the weight is the same in the world in every pose, as a camera's often is.
    twins = ('clamp_offset', 'stiffness_contrast', 'camera_offset')
    # Two jaws give way about the axis along them, and hardly about the other one.
    variants = (
        ('compliance',),
        ('shift_compliance',),
        ('compliance', 'shift_compliance'),
        *((name,) for name in _ACROSS),
        _ACROSS,
    )
    is_at_rest_only = True

    def conditions(self, own: Numbers, site: Site) -> Conditions:
        """Return the clamp's compliance: alike about all axes, and about two across the body."""
        shift, turn = own.get('shift_compliance', 0.0), own.get('compliance', 0.0)
        compliance = np.diag(np.repeat([shift, turn], 3))
        for name, axis in zip(_ACROSS, site.axes.axes[1:], strict=True):
            compliance[3:, 3:] += own.get(name, 0.0) * np.outer(axis, axis)
        return Conditions(clamp_compliance=compliance)

    def frame(self, own: Numbers, site: Site) -> dict[str, FloatArray]:
        """`compliance_a` and `compliance_b` are about axes in the object's frame."""
        axes = site.object_axes.axes
        return {name: axes[1 + n] for n, name in enumerate(_ACROSS) if own.get(name, 0.0)}
