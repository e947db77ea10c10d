# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The clamp turns with the moment of the body on it, and shifts with its force."""

from diffcal_ros.effects.effect import Component, Effect, Numbers
from diffcal_ros.effects.site import Site
from diffcal_ros.fem.conditions import Conditions


class CompliantClamp(Effect):
    """A clamp that gives way."""

    identifier = 'compliant_clamp'
    group = 'boundary'
    components = (
        Component('compliance', 'rad/(N m)', 0.0, 100.0, 5.0, 'rad/(N m)', 1.0),
        Component('shift_compliance', 'm/N', 0.0, 0.1, 0.005, 'mm/N', 1e3),
    )
    sentence = 'the clamp gives way under the load'
    settles = ('a second load', 'a pose that loads the clamp otherwise')
    # A shift under the weight is the same in the world in every pose, as a camera's often is.
    twins = ('clamp_offset', 'stiffness_contrast', 'camera_offset')
    variants = (('compliance',), ('shift_compliance',), ('compliance', 'shift_compliance'))
    is_at_rest_only = True

    def conditions(self, own: Numbers, site: Site) -> Conditions:
        """Return the clamp's compliances."""
        return Conditions(
            clamp_compliance=own.get('compliance', 0.0),
            clamp_shift_compliance=own.get('shift_compliance', 0.0),
        )
