# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The stamps of the depth images are late."""

from diffcal_ros.effects.effect import Component, Effect, Numbers
from diffcal_ros.effects.site import Site
from diffcal_ros.fem.motion.inputs import MotionChange
from diffcal_ros.fem.statics.force_changes import Change


class TimeOffset(Effect):
    """Every frame shows the body sooner than its stamp says."""

    identifier = 'time_offset'
    group = 'sensor'
    components = (Component('late', 's', -0.2, 0.2, 0.010, 'ms', 1e3),)
    sentence = 'the stamps of the depth images are late'
    settles = ('a signal that the camera sees and the release clock stamps, such as a light',)
    twins = ('air_drag',)
    needs_motion = True
    hides_in_release = True
    varying = ('late',)
    scatters_in_time = True

    def lateness(self, own: Numbers) -> float:
        """Return by how much the stamps are late [s]."""
        return own.get('late', 0.0)

    def change(self, component: str, own: Numbers, site: Site) -> Change:
        """Return a change of the lateness."""
        return MotionChange(time_offset=1.0)
