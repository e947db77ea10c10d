# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Jaws that are pitched about a level hinge behind the body, by other angles than stated."""

from collections.abc import Iterable

import numpy as np

from benchmarks.blind.rotations import rotation
from benchmarks.blind.setups import Setup
from benchmarks.blind.shapes import FloatArray


def stated_pitches(setup: Setup) -> FloatArray:
    """Return by how much a body points up in each pose [rad], shape (P,)."""
    return np.array([np.arcsin(pose.world_from_object[1, 0]) for pose in setup.observations])


def pitched_on(setup: Setup, angles: Iterable[float]) -> tuple[tuple[float, ...], ...]:
    """Return shift [mm] and turn [deg] of a clamp in each pose, whose jaws are pitched farther up.

    Args:
        setup: with its poses; the hinge goes through the object's origin.
        angles: by which they are, in each pose [rad].
    """
    turns = []
    for pose, angle in zip(setup.observations, angles, strict=True):
        # From ahead towards up.
        level = np.cross(pose.world_from_object[:3, 0], [0.0, 1.0, 0.0])
        axis = pose.world_from_object[:3, :3].T @ level / np.linalg.norm(level)
        turns.append(angle * axis)
    return turned_on(setup, turns)


def turned_on(setup: Setup, turns: Iterable[FloatArray]) -> tuple[tuple[float, ...], ...]:
    """Return shift [mm] and turn [deg] of a clamp in each pose that turns about its inner end.

    Args:
        setup: the rig; the inner end is at the object's origin.
        turns: rotation vector of each pose, object frame [rad], shape (3,) each.
    """
    middle, found = 500.0 * setup.shape.clamp * np.array([1.0, 0.0, 0.0]), []
    for turn in turns:
        shift = rotation(turn) @ middle - middle
        found.append(tuple(round(float(value), 4) for value in (*shift, *np.rad2deg(turn))))
    return tuple(found)


def key_turns(angle: float, first: float, count: int) -> list[FloatArray]:
    """Return how a body is turned in each pose whose chuck has three jaws, tightened singly.

    In each pose the key was put into the next jaw, a third of a turn on about the object's x; at
    the mouth that presses the body to the other side, while its inner end stays on the stop.

    Args:
        angle: by which it is [rad].
        first: where the jaw of the first pose is, from the object's y towards z [rad].
        count: of poses.

    Returns:
        Rotation vectors, object frame [rad], shape (3,) each.
    """
    jaws = first + 2.0 / 3.0 * np.pi * np.arange(count)
    # From x to where it is pressed, which is opposite a jaw.
    return [angle * np.array([0.0, np.sin(jaw), -np.cos(jaw)]) for jaw in jaws]


def eccentric_errors(pitches: FloatArray, phase: float) -> FloatArray:
    """Return how far a dial is off whose disc does not turn about its middle, shape (P,).

    By the sine of the angle, over the way from one to the other as a share of its radius; it was
    set to 0 where the first pose is.

    Args:
        pitches: that are read [rad], shape (P,).
        phase: which way its middle is off where 0 is read [rad].
    """
    swung = np.sin(pitches + phase)
    return np.asarray(swung - swung[0])


def joint_errors(pitches: FloatArray, phase: float, bent: float) -> FloatArray:
    """Return how far jaws go on or lag that a shaft turns through a universal joint, shape (P,).

    Hooke's joint: the tangent of the driven angle is that of the driving one over the cosine of
    how far the shafts are bent off each other. It was set to 0 where the first pose is.

    Args:
        pitches: by which the driving shaft turns [rad], shape (P,).
        phase: of its fork where that is 0 [rad].
        bent: angle between both shafts [rad].
    """
    driving = pitches + phase
    off = np.arctan2(np.sin(driving), np.cos(bent) * np.cos(driving)) - driving
    errors = (off + np.pi) % (2.0 * np.pi) - np.pi
    return np.asarray(errors - errors[0])


def tangent_errors(pitches: FloatArray, crank: float) -> FloatArray:
    """Return how far jaws lag that a nut on a straight screw pitches by an arm, shape (P,).

    The nut goes on in proportion to what is asked for, and the arm by the arc tangent of that. It
    was set to 0 where the first pose is.

    Args:
        pitches: that are asked for [rad], shape (P,).
        crank: way of the nut by a radian, over its distance from the hinge.
    """
    errors = np.arctan(crank * pitches) / crank - pitches
    return np.asarray(errors - errors[0])


def belt_errors(pitches: FloatArray) -> FloatArray:
    """Return how far down jaws are by all turns so far, whose belt slips by a share of each, (P,).

    Whichever way it turns them, it slips to the side of the weight, and what it has slipped it
    stays off. It was set to 0 where the first pose is.

    Args:
        pitches: that are asked for [rad], shape (P,).

    Returns:
        Errors over that share [rad], 0 or less.
    """
    return -np.cumsum(np.abs(np.diff(pitches, prepend=pitches[:1])))
