# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a motion depends on, directions in that space, and derivatives by it."""

from collections.abc import Callable
from dataclasses import dataclass, fields

from diffcal_ros.damping import Damping
from diffcal_ros.errors import NotSimulatedError
from diffcal_ros.fem.statics.force_changes import Change, StaticGradient
from diffcal_ros.fem.terms.conditions import Conditions, NO_CONDITIONS
from diffcal_ros.material import Material
from diffcal_ros.time_knot import TimeKnot
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]
# Positions of the held vertices [m], shape (h, 3), at a time [s].
HeldMotion = Callable[[float], FloatArray]
# What gravity is more around knots [m/s^2], shape (3,) each.
GravityCourse = tuple[tuple[TimeKnot, FloatArray], ...]


class MotionError(NotSimulatedError):
    """No motion was found; the message says what to change."""


@dataclass(frozen=True)
class Release:
    """A support that is taken away.

    Attributes:
        supported_vertices: mesh vertices held besides the clamp until then, shape (s,).
        time: of the release [s], on the axis of the stamps.
        support_positions: where the support holds them [m], world frame, shape (s, 3); None: at
            rest.
    """

    supported_vertices: IntArray
    time: float
    support_positions: FloatArray | None = None


@dataclass(frozen=True)
class MotionInputs:
    """What forces on a moving body depend on.

    Attributes:
        material: one value per tetrahedron.
        damping: one value per tetrahedron.
        gravity: acceleration in the world frame [m/s^2], shape (3,).
        conditions: effects on the body.
        gravity_course: what gravity is more in the course of time, since the start.
    """

    material: Material
    damping: Damping
    gravity: FloatArray
    conditions: Conditions = NO_CONDITIONS
    gravity_course: GravityCourse = ()

    def gravity_at(self, time: float) -> FloatArray:
        """Return gravity at a time since the start [s]."""
        return gravity_in(self.gravity_course, self.gravity, time)


def gravity_in(course: GravityCourse, gravity: FloatArray, time: float) -> FloatArray:
    """Return gravity at a time on the axis of its course [m/s^2], shape (3,).

    Args:
        course: what it is more around knots.
        gravity: what it is in all, shape (3,).
        time: [s].
    """
    more = [float(knot.weights(time)) * own for knot, own in course]
    return gravity + np.sum(more, axis=0) if more else gravity


@dataclass(frozen=True)
class MotionChange(Change):
    """A direction in the space of parameters of a motion; parts left out do not change.

    Only a `MotionGradient` knows them.

    Attributes:
        damping: strain-rate damping [Pa s] per unit of the parameter, shape (T,).
        mass_damping: [1/s].
        release_time: [s].
        time_offset: by which stamps are late [s].
        knot: the time around which alone its gravity and lateness count, on the axis of the
            stamps; None: at all times. A gradient does not know of it.
    """

    damping: FloatArray | None = None
    mass_damping: float = 0.0
    release_time: float = 0.0
    time_offset: float = 0.0
    knot: TimeKnot | None = None

    def weights(self, times: FloatArray | float) -> FloatArray:
        """Return by how much its gravity and lateness count at some times [s], as `times`."""
        return np.ones_like(times) if self.knot is None else self.knot.weights(times)


def in_course(change: Change, knot: TimeKnot) -> MotionChange:
    """Return a change of gravity or lateness that counts around a time alone.

    Raises:
        ValueError: for a change of anything else, which has no course.
    """
    values = {own.name: getattr(change, own.name) for own in fields(change)}
    known = {name: values.pop(name) for name in ('gravity', 'time_offset') if name in values}
    others = [name for name, own in values.items() if own is not None and np.any(own)]
    if others:
        raise ValueError(
            f'{", ".join(others)} cannot be others in the course of time: gravity and lateness can'
        )
    return MotionChange(**known, knot=knot)


@dataclass(frozen=True)
class MotionGradient(StaticGradient):
    """Derivative of a scalar by every input of a motion.

    Attributes:
        damping: by each tetrahedron's own strain-rate damping [1/(Pa s)], shape (T,).
        mass_damping: [s].
        release_time: [1/s].
        time_offset: [1/s].
    """

    damping: FloatArray
    mass_damping: float
    release_time: float
    time_offset: float = 0.0

    def along(self, change: Change) -> float:
        """Return the derivative along a change of the inputs.

        Raises:
            NotImplementedError: for a change of effects, or in the course of time.
        """
        if isinstance(change, MotionChange) and change.knot is not None:
            raise NotImplementedError(
                'this gradient does not know changes in the course of time: use `tangents`, which '
                'follow every change'
            )
        total = super().along(change)
        if isinstance(change, MotionChange):
            total += self.mass_damping * change.mass_damping
            total += self.release_time * change.release_time
            total += self.time_offset * change.time_offset
            if change.damping is not None:
                total += float(self.damping @ change.damping)
        return total
