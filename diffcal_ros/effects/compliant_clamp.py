# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The clamp turns with the moment of the body on it."""

from diffcal_ros.effects.effect import Component, Effect, Numbers
from diffcal_ros.effects.site import Site
from diffcal_ros.fem.conditions import Conditions


class CompliantClamp(Effect):
    """A clamp that gives way."""

    identifier = 'compliant_clamp'
    group = 'boundary'
    components = (Component('compliance', 'rad/(N m)', 0.0, 100.0, 5.0, 'rad/(N m)', 1.0),)
    sentence = 'the clamp gives way under the load'
    settles = ('a second load', 'a pose that loads the clamp otherwise')
    twins = ('clamp_offset', 'stiffness_contrast')
    is_at_rest_only = True

    def conditions(self, own: Numbers, site: Site) -> Conditions:
        """Return the clamp's compliance."""
        return Conditions(clamp_compliance=own['compliance'])
