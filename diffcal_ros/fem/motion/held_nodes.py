# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where the clamp takes the held nodes over time, and how that follows the parameters.

The motion is given in the world frame; all else is in the body's own.
"""

from dataclasses import dataclass

from diffcal_ros.fem.motion.inputs import HeldMotion, MotionChange
from diffcal_ros.fem.statics.force_changes import Change
from diffcal_ros.fem.statics.static_body import StaticBody
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Half the interval of differences in time [s]: a clamp turning at 10 rad/s is met to 1e-9.
_INTERVAL = 1e-5


@dataclass(frozen=True)
class HeldState:
    """Held nodes at one time: positions [m] and velocities [m/s], shape (H, 3)."""

    positions: FloatArray
    velocities: FloatArray


class HeldNodes:
    """Held nodes of a body under a prescribed motion."""

    def __init__(self, body: StaticBody, motion: HeldMotion | None, clamp_motion: FloatArray):
        self._body = body
        self._motion = motion
        self._clamp_motion = clamp_motion
        self._still: HeldState | None = None

    @property
    def moves(self) -> bool:
        """Tell whether there is a prescribed motion."""
        return self._motion is not None

    def vertices_at(self, time: float) -> FloatArray:
        """Return held vertices [m], shape (h, 3)."""
        return self._place(self._nominal(time))

    def at(self, time: float) -> HeldState:
        """Return the state at a time [s]."""
        if self._motion is not None:
            return HeldState(self._nodes_at(time), self._rate(time))
        if self._still is None:
            positions = self._nodes_at(time)
            self._still = HeldState(positions, np.zeros_like(positions))
        return self._still

    def change(self, time: float, change: Change) -> HeldState | None:
        """Return how the state follows a change of the inputs at fixed time since the start."""
        effects = change.conditions
        direction = effects.clamp_motion if effects and effects.clamp_motion.any() else None
        shift = change.release_time if isinstance(change, MotionChange) else 0.0
        if direction is None and (shift == 0.0 or self._motion is None):
            return None
        positions = self._change_at(time, direction, shift)
        if self._motion is None:
            return HeldState(positions, np.zeros_like(positions))
        later = self._change_at(time + _INTERVAL, direction, shift)
        sooner = self._change_at(time - _INTERVAL, direction, shift)
        return HeldState(positions, (later - sooner) / (2.0 * _INTERVAL))

    def _change_at(self, time: float, direction: FloatArray | None, shift: float) -> FloatArray:
        change = np.zeros((len(self._body.held_nodes), 3))
        if direction is not None:
            nominal = self._body.held.spread(self._nominal(time))
            change += self._body.clamp.change(nominal, self._clamp_motion, direction)
        if shift != 0.0 and self._motion is not None:
            change += shift * self._rate(time)
        return change

    def _rate(self, time: float) -> FloatArray:
        later, sooner = self._nodes_at(time + _INTERVAL), self._nodes_at(time - _INTERVAL)
        return (later - sooner) / (2.0 * _INTERVAL)

    def _nodes_at(self, time: float) -> FloatArray:
        return self._body.held.spread(self.vertices_at(time))

    def _nominal(self, time: float) -> FloatArray:
        if self._motion is None:
            return self._body.own_mesh.rest_positions[self._body.held_vertices]
        return np.asarray(self._motion(time), dtype=np.float64) - self._body.origin

    def _place(self, points: FloatArray) -> FloatArray:
        if not self._clamp_motion.any():
            return points
        return self._body.clamp.place(points, self._clamp_motion)
