# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The foam of a crate for eggs, which waves along two ways, as a penalty in the object frame."""

from collections.abc import Callable

import numpy as np

from benchmarks.blind.equilibrium import Potential, PotentialLaw
from benchmarks.blind.faults import Faults
from benchmarks.blind.setups import Observation
from benchmarks.blind.shapes import FloatArray

# How high a surface is over its crests at places of the world, and its two derivatives by these.
Waves = Callable[[FloatArray, Faults], tuple[FloatArray, FloatArray, FloatArray]]


def crate_tops(points: FloatArray, faults: Faults) -> FloatArray:
    """Return how high a crate's crests may lie before it touches each node [m], shape (N,).

    Args:
        points: in the world [m], shape (N, 3).
        faults: say where a crest is, how far from crest to crest, and how deep its troughs are.
    """
    return np.asarray(points[:, 1] - _waves(points, faults)[0])


def crate(observation: Observation, faults: Faults, stiffness: FloatArray) -> PotentialLaw:
    """Return a crate without friction.

    Args:
        observation: the pose.
        faults: as above, and how high its crests are.
        stiffness: force by dent, upright, at each node [N/m], shape (N,).
    """
    return waved(observation, faults, stiffness, _waves)


def waved(
    observation: Observation, faults: Faults, stiffness: FloatArray, waves: Waves
) -> PotentialLaw:
    """Return a surface that waves, without friction; the arguments are those of `crate`."""
    assert faults.contact_height is not None
    height, matrix = faults.contact_height, observation.world_from_object
    turn, shift = matrix[:3, :3], matrix[:3, 3]

    def penalty(positions: FloatArray) -> Potential:
        points = positions @ turn.T + shift
        high, slope, curve = waves(points, faults)
        dent = np.maximum(height + high - points[:, 1], 0.0)
        slope = (slope - np.array([0.0, 1.0, 0.0])) @ turn
        push, touched = stiffness * dent, stiffness * (dent > 0.0)
        outer = slope[:, :, None] * slope[:, None, :]
        return Potential(
            energy=0.5 * float((push * dent).sum()),
            gradient=push[:, None] * slope,
            diagonal=touched[:, None, None] * outer
            + push[:, None, None] * (turn.T @ curve @ turn),
        )

    return penalty


def _waves(points: FloatArray, faults: Faults) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return how high foam is over its crests [m], and its two derivatives by places.

    Args:
        points: in the world [m], shape (N, 3).
        faults: as above.

    Returns:
        Heights [m], shape (N,), slopes, shape (N, 3), and curvatures [1/m], shape (N, 3, 3).
    """
    rate, half = 2.0 * np.pi / faults.contact_wave, 0.5 * faults.contact_trough
    ahead = rate * (points[:, 0] - faults.contact_ahead)
    aside = rate * (points[:, 2] - faults.contact_at)
    crests, slope, curve = (
        np.cos(ahead) * np.cos(aside),
        np.zeros((len(points), 3)),
        np.zeros((len(points), 3, 3)),
    )
    slope[:, 0] = -half * rate * np.sin(ahead) * np.cos(aside)
    slope[:, 2] = -half * rate * np.cos(ahead) * np.sin(aside)
    curve[:, 0, 0] = curve[:, 2, 2] = -half * rate**2 * crests
    curve[:, 0, 2] = curve[:, 2, 0] = half * rate**2 * np.sin(ahead) * np.sin(aside)
    return np.asarray(half * (crests - 1.0)), slope, curve
