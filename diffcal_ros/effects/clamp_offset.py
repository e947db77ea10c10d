# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The body sits elsewhere in its clamp than the scene says."""

from diffcal_ros.effects.effect import DEGREE, Effect, FloatArray, Numbers
from diffcal_ros.effects.rigid import RIGID_AXES, rigid_components, ROLLED, SHIFT, TURN, twist_of
from diffcal_ros.effects.site import Site
from diffcal_ros.fem.body_axes import BodyAxes
from diffcal_ros.fem.terms.conditions import Conditions
from diffcal_ros.rigid_motion import moved


class ClampOffset(Effect):
    """A rigid motion of the clamp in the object's frame."""

    identifier = 'clamp_offset'
    group = 'boundary'
    components = rigid_components(0.005, 3.0 * DEGREE)
    sentence = 'the body sits elsewhere in the clamp than the scene says'
    settles = (ROLLED,)
    twins = ('camera_offset', 'rest_curvature')
    # As short, and as light, as one that is pushed farther in.
    outside_twins = ('a body that was cut shorter or longer than its mesh',)
    variants = (SHIFT, TURN, RIGID_AXES)
    # What moves the clamp moves the body by the body's own mechanics, and does not bend it.
    most_along = 0.3
    # A rig that stands elsewhere, or a camera that leans with it, moves the fixture as well.
    class_with_fixture = 'sensor'
    # It is clamped anew for each pose, or slips.
    most_by_pose = 1.0

    def conditions(self, own: Numbers, site: Site) -> Conditions:
        """Return the clamp's motion."""
        return Conditions(clamp_motion=_in_world(twist_of(own), site))

    def displaced(self, points: FloatArray, own: Numbers, axes: BodyAxes) -> FloatArray:
        """Return where the clamp's motion takes points, shape (n, 3)."""
        return moved(points, twist_of(own), axes.center)

    def frame(self, own: Numbers, site: Site) -> dict[str, FloatArray]:
        """It turns `about` a point in the object's frame."""
        return {'about': site.object_axes.center}


def _in_world(twist: FloatArray, site: Site) -> FloatArray:
    return site.to_world(twist.reshape(2, 3)).ravel()
