# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The air holds the moving body back."""

from diffcal_ros.effects.effect import Component, Effect, Numbers
from diffcal_ros.effects.site import Site
from diffcal_ros.fem.terms.conditions import Conditions


class AirDrag(Effect):
    """Drag coefficient times area."""

    identifier = 'air_drag'
    group = 'dynamics'
    components = (Component('area', 'm^2', 0.0, 50.0, 0.020, 'cm^2', 1e4, by_length=2),)
    sentence = 'the air holds the moving body back'
    settles = ('a second release with half the swing',)
    twins = ('time_offset',)
    outside_twins = ('something that rubs on the body',)
    # One swing of what rubs on a body was explained to the noise by an area of air's drag.
    imitated_by = (
        'something that rubs on the body may hold it back as the air does: told by a second '
        'release with half the swing, of which the air takes less'
    )
    needs_motion = True

    def conditions(self, own: Numbers, site: Site) -> Conditions:
        """Return the drag."""
        return Conditions(air_drag=own['area'])
