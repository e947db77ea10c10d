# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The camera is elsewhere than its pose says: a rigid motion of the body in its frame.

Where the camera sees points belongs to every fit, under a name of longer standing, with the prior
of the scene; see `calibration.camera_offsets`.
"""

from collections.abc import Mapping

from diffcal_ros.effects.effect import DEGREE, Effect, FloatArray, Numbers
from diffcal_ros.effects.rigid import RIGID_AXES, rigid_components, ROLLED, SHIFT, twist_of
from diffcal_ros.effects.site import Site


class CameraOffset(Effect):
    """The body as the depth camera sees it is moved; the camera itself is off by the inverse."""

    identifier = 'camera_offset'
    group = 'sensor'
    components = rigid_components(0.020, 5.0 * DEGREE)
    sentence = 'the camera is not where it is said to be'
    settles = (ROLLED, 'the clamp in view and as `fixture` in the scene')
    twins = ('clamp_offset', 'depth_affine', 'compliant_clamp')
    fit_name = kind = 'rigid_offset'
    is_fitted_whole = is_of_recording = True
    variants = (SHIFT, RIGID_AXES)
    across_picture = ('x', 'y')
    # It may be moved between two recordings.
    most_by_pose = 1.0

    def frame(self, own: Numbers, site: Site) -> dict[str, FloatArray]:
        """It turns `about` a point in the depth camera's frame."""
        return {} if site.camera_pivot is None else {'about': site.camera_pivot}


def stated_offset(effects: Mapping[str, Numbers]) -> FloatArray:
    """Return the offset that a scene's effects state: shift [m] and turn [rad], shape (6,)."""
    return twist_of(effects.get(CameraOffset.identifier, {}))
