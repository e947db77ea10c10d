# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The clamp turns with the moment of the body on it, and shifts with its force."""

from dataclasses import replace

from diffcal_ros.effects.effect import Component, Effect, FloatArray, Numbers
from diffcal_ros.effects.site import Site
from diffcal_ros.fem.statics.force_changes import Change
from diffcal_ros.fem.terms.conditions import Conditions
import numpy as np

# Of a usual body, which turns it by its weight on its length.
_TURN = Component(
    'compliance', 'rad/(N m)', 0.0, 100.0, 5.0, 'rad/(N m)', 1.0, by_mass=-1, by_length=-1
)
_ABOUT_ONE = ('compliance_a', 'compliance_b')
_OF_SECTION = (*_ABOUT_ONE, 'compliance_ab')


class CompliantClamp(Effect):
    """A clamp that gives way."""

    identifier = 'compliant_clamp'
    group = 'boundary'
    components = (
        _TURN,
        Component(
            'shift_compliance', 'm/N', 0.0, 0.1, 0.005, 'mm/N', 1e3, by_mass=-1, by_length=1
        ),
        *(replace(_TURN, name=name) for name in _ABOUT_ONE),
        replace(_TURN, name='compliance_ab', lower=-_TURN.upper),
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
        *((name,) for name in _ABOUT_ONE),
        _OF_SECTION,
    )
    needs_implicit_steps = True
    # As with an offset in the clamp.
    most_along = 0.3
    # Under another load it gives way by another law: one that hardens, is worn or has play.
    most_by_pose = 1.0
    # One without any compliance in common is a clamp that was set anew in each pose.
    has_common_part = True

    def conditions(self, own: Numbers, site: Site) -> Conditions:
        """Return the clamp's compliance: alike about all axes, and about those of its section."""
        shift, turn = own.get('shift_compliance', 0.0), own.get('compliance', 0.0)
        compliance = np.diag(np.repeat([shift, turn], 3))
        a, b, ab = (own.get(name, 0.0) for name in _OF_SECTION)
        axes = site.axes.section[1:]
        compliance[3:, 3:] += axes.T @ np.array([[a, ab], [ab, b]]) @ axes
        return Conditions(clamp_compliance=compliance)

    def otherwise(self, site: Site) -> tuple[Change, ...]:
        """Return motions of the clamp: one that turns about a corner shifts, too."""
        return tuple(Change(conditions=Conditions(clamp_motion=row)) for row in np.eye(6))

    def frame(self, own: Numbers, site: Site) -> dict[str, FloatArray]:
        """`a` and `b` are axes in the object's frame, within the section where the clamp ends."""
        _, a, b = site.object_axes.section
        return {'a': a, 'b': b} if any(own.get(name, 0.0) for name in _OF_SECTION) else {}
