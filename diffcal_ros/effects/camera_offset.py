# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The camera is elsewhere than its pose says: a rigid motion of the body in its frame.

Where the camera sees points belongs to every fit, under a name of longer standing, with the prior
of the scene; see `calibration.camera_offsets`.
"""

from collections.abc import Mapping

from diffcal_ros.effects.effect import Component, DEGREE, Effect, FloatArray, Numbers
from diffcal_ros.effects.rigid import RIGID_AXES, rigid_components, ROLLED, SHIFT, twist_of
from diffcal_ros.effects.site import Site
import numpy as np

# How a picture may be another one, see `calibration.parameters.lens`, and what moves the edge of
# a picture as far as a usual offset does.
LENS_MODES = {
    'focal': 0.15,
    'aspect': 0.15,
    'skew': 0.15,
    **dict.fromkeys(('x_xx', 'x_xy', 'x_yy', 'y_xx', 'y_xy', 'y_yy'), 0.5),
    'radial': 1.5,
}


class CameraOffset(Effect):
    """The body as the depth camera sees it is moved; the camera itself is off by the inverse."""

    identifier = 'camera_offset'
    group = 'sensor'
    components = rigid_components(0.020, 5.0 * DEGREE)
    sentence = 'the camera is not where, or not what, it is said to be'
    settles = (ROLLED, 'the clamp in view and as `fixture` in the scene')
    twins = ('clamp_offset', 'depth_affine', 'compliant_clamp')
    fit_name = kind = 'rigid_offset'
    is_fitted_whole = is_of_recording = True
    variants = (SHIFT, RIGID_AXES)
    across_picture = ('x', 'y')
    # It may be moved between two recordings.
    most_by_pose = 1.0
    # A turn about the clamp at any time follows whatever bends. A camera that moves shifts that.
    varying = SHIFT
    # What is seen is the same, but for the little that a body in a rig that moves lags behind.
    imitated_over_time = 'a rig that moves before the camera'
    # As whatever sees wrongly: not where it is said to be, or with another picture.
    forms = tuple(
        Component(name, '1', -20.0 * size, 20.0 * size, size, '1', 1.0)
        for name, size in LENS_MODES.items()
    )
    form_kind = 'lens'
    form = 'its focal length, centre or distortion are others'

    def frame(self, own: Numbers, site: Site) -> dict[str, FloatArray]:
        """It turns `about` a point in the depth camera's frame."""
        return {} if site.camera_pivot is None else {'about': site.camera_pivot}


def stated_offset(effects: Mapping[str, Numbers]) -> FloatArray:
    """Return the offset that a scene's effects state: shift [m] and turn [rad], shape (6,)."""
    return twist_of(effects.get(CameraOffset.identifier, {}))


def stated_lens(effects: Mapping[str, Numbers]) -> FloatArray:
    """Return by how much the picture is another one, of each of `LENS_MODES`, shape (m,)."""
    own = effects.get(CameraOffset.identifier, {})
    return np.array([own.get(name, 0.0) for name in LENS_MODES])
