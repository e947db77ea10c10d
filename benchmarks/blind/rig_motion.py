# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What acts on a swinging body for a while, or changes as it swings.

A body on a rig that shakes is looked at from the rig: there it is drawn by its inertia.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.lurch import lurch_acceleration, lurch_shift
from benchmarks.blind.rotations import rigid, rotation
from benchmarks.blind.setups import GRAVITY, Observation
from benchmarks.blind.shapes import FloatArray

_KICK = 0.008  # How long a ledge that goes is in touch with the end face [s].


def acting(
    observation: Observation, faults: Faults, masses: FloatArray, end: FloatArray
) -> Callable[[float], FloatArray] | None:
    """Return forces on the nodes [N], shape (N, 3), by the time since the release [s].

    Args:
        observation: the pose.
        faults: say what there is.
        masses: of the nodes [kg], shape (N,).
        end: share of each node in what acts on the end face, shape (N,).
    """
    moved = faults.shaken or faults.kicked or faults.lurched
    if not (faults.tilt_time or faults.tilt_rate or moved):
        return None
    object_from_world = observation.world_from_object[:3, :3].T

    def forces(time: float) -> FloatArray:
        rig = rig_acceleration(faults, time) + lurch_acceleration(faults, time)
        drawn = object_from_world @ (leaned(faults, time) - rig)
        kick = faults.kicked * pulse(time) * np.array(faults.kicked_way)
        return np.asarray(masses[:, None] * drawn + end[:, None] * kick)

    return forces


def leaned(faults: Faults, time: float) -> FloatArray:
    """Return what a table that leans over or sways adds to gravity, world [m/s^2], shape (3,)."""
    share = _leaned_share(faults, time)
    if not share:
        return np.zeros(3)
    x, z = np.deg2rad(faults.gravity_tilt)
    down = np.array([0.0, -GRAVITY, 0.0])
    return np.asarray(rotation(share * np.array([x, 0.0, z])) @ down - down)


def _leaned_share(faults: Faults, time: float) -> float:
    """Return which share of its tilt a table has."""
    if faults.tilt_rate:
        return float(np.sin(2.0 * np.pi * faults.tilt_rate * time + faults.tilt_phase))
    if faults.tilt_form == 'toppling':
        return toppled(faults, time)
    # It leans over once the ledge bears nothing.
    is_leaning = bool(faults.tilt_time) and time > 0.0
    return float(-np.expm1(-time / faults.tilt_time)) if is_leaning else 0.0


def toppled(faults: Faults, time: float) -> float:
    """Return how far a table has toppled from one foot to another, by a time since the release.

    It stands on an edge that the ledge's going takes it over: it falls as a pendulum does that
    stands upside down, ever faster, and stays where it lands.
    """
    since = min(max(time, 0.0), faults.tilt_fall) / faults.tilt_time
    whole = faults.tilt_fall / faults.tilt_time
    return float(np.sinh(0.5 * since) ** 2 / np.sinh(0.5 * whole) ** 2)


def rig_shift(faults: Faults, time: float) -> FloatArray:
    """Return how far a rig that shakes is from its place, world frame [m], shape (3,)."""
    angle = 2.0 * np.pi * faults.shaken_rate * time + faults.shaken_phase
    return np.asarray(1e-3 * faults.shaken * np.sin(angle) * np.array(faults.shaken_way))


def rig_acceleration(faults: Faults, time: float) -> FloatArray:
    """Return the same twice differentiated by the time [m/s^2], shape (3,)."""
    return -((2.0 * np.pi * faults.shaken_rate) ** 2) * rig_shift(faults, time)


def rig_at(observation: Observation, faults: Faults, time: float) -> Observation:
    """Return a pose as it is at a time since the release [s]."""
    if not (faults.shaken or faults.lurched):
        return observation
    shift = rig_shift(faults, time) + lurch_shift(faults, time)
    moved = rigid(np.eye(3), shift) @ observation.world_from_object
    return replace(observation, world_from_object=moved)


def pulse(time: float) -> float:
    """Return half a wave of a sine whose integral over the time is 1 [1/s]."""
    if not 0.0 < time < _KICK:
        return 0.0
    return float(0.5 * np.pi / _KICK * np.sin(np.pi * time / _KICK))
