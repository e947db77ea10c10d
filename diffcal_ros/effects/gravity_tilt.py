# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Gravity is tilted against the rig, about two axes across it."""

from dataclasses import replace

from diffcal_ros.effects.effect import Component, DEGREE, Effect, FloatArray, Numbers
from diffcal_ros.effects.rigid import pair_of, ROLLED, tilt_components
from diffcal_ros.effects.site import Site
from diffcal_ros.fem.statics.force_changes import Change
from diffcal_ros.rigid_motion import tilt_axes
from diffcal_ros.rigid_transform import rotation_matrix
import numpy as np

# By what share gravity is more, in the course of a recording.
_HEAVIER = 'heavier'


class GravityTilt(Effect):
    """A rig that is not level; a nominal fit may have it too, under a tighter prior."""

    identifier = 'gravity_tilt'
    group = 'load'
    # A rig levelled by eye is off by two degrees.
    components = tuple(
        replace(part, nominal_std=2.0 * DEGREE) for part in tilt_components(8.0 * DEGREE)
    )
    sentence = 'the rig is not level, or something steady pushes the body sideways'
    settles = ('a spirit level', ROLLED)
    twins = ('camera_offset', 'clamp_offset')
    outside_twins = ('a steady push to the side',)
    kind = 'gravity_tilt'
    is_fitted_whole = needs_gravity = True
    # A table sways. What pushes for a while pushes along gravity as well as across it.
    of_course = (Component(_HEAVIER, '1', -0.5, 0.5, 8.0 * DEGREE, '%', 100.0),)
    varying = ('a', 'b', _HEAVIER)
    # Of four such courses in two sealed sets two were tilts, one a gust, one a mass that ran out.
    imitated_over_time = 'a gust, a mass that runs out, a rig that is accelerated'
    # Of 14 development cases with this name 10 were tilts, the others a steady side wind.
    most_confidence = 0.7
    # Of a steady force on every part in proportion to its mass a tilt is all that there is, but
    # only one that is steady in the world: what turns with the rig a rolled pose tells.
    imitated_by = (
        'a steady push to the side may look like this tilt: one that turns with the rig is '
        f'told by {ROLLED}, one that does not by a spirit level'
    )

    def gravity(self, own: Numbers, gravity: FloatArray) -> FloatArray:
        """Return the tilted gravity [m/s^2], shape (3,)."""
        turn = rotation_matrix(pair_of(own) @ np.stack(tilt_axes(gravity)))
        return np.asarray((1.0 + own.get(_HEAVIER, 0.0)) * (turn @ gravity))

    def weight_doubt(self, own: Numbers) -> float:
        """Return what a push adds, if it is one: along gravity as much as in each way across."""
        across = np.tan(np.linalg.norm(pair_of(own)))
        whole, along = np.hypot(1.0, across) - 1.0, across / np.sqrt(2.0)
        return float(np.sqrt(1.0 - self.most_confidence) * np.hypot(whole, along))

    def change(self, component: str, own: Numbers, site: Site) -> Change:
        """Return a turn of gravity, to first order in the tilt, which is a few degrees."""
        if component == _HEAVIER:
            return Change(gravity=site.gravity / (1.0 + own.get(_HEAVIER, 0.0)))
        axis = self.frame(own, site)[component]
        return Change(gravity=np.cross(axis, site.gravity))

    def frame(self, own: Numbers, site: Site) -> dict[str, FloatArray]:
        """It turns about `a` and `b` in the world."""
        return dict(zip(('a', 'b'), tilt_axes(site.stated_gravity), strict=True))
