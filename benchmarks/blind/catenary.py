# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A cable that hangs slack between rig and body, as energies of nodes in the object frame."""

import numpy as np

from benchmarks.blind.equilibrium import Potential, PotentialLaw
from benchmarks.blind.faults import Faults
from benchmarks.blind.setups import GRAVITY, Observation
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.springs import around

_ROUNDS = 40  # Of Newton's steps to a catenary's shape, far more than it takes.
_LEVEL = 1e-9  # Least way aside at which a cable hangs from its anchor [m].


def slung(
    nodes: FloatArray,
    masses: FloatArray,
    shares: FloatArray,
    observation: Observation,
    faults: Faults,
) -> PotentialLaw:
    """Return a cable from an anchor that goes with the rig to one place of a body.

    Every node of that place has its own part of the cable, all of one length.

    Args:
        nodes: where nothing is loaded, object frame [m], shape (N, 3).
        masses: of nodes, by which they share the cable, shape (N,).
        shares: of the free length at which they lie, shape (N,).
        observation: the pose.
        faults: say how heavy the cable is, from where to where it hangs, and how slack.
    """
    anchor, up = 1e-3 * np.array(faults.mass_anchor), observation.world_from_object[1, :3]
    parts = around(1e-3 * faults.added_mass, faults.added_mass_at, masses, shares)
    tied = np.flatnonzero(parts)
    length = cable_length(nodes, parts, faults)
    weights = GRAVITY * parts[tied] / length

    def energy(positions: FloatArray) -> Potential:
        away = positions[tied] - anchor
        high = away @ up
        level = away - high[:, None] * up
        wide = np.maximum(np.linalg.norm(level, axis=1), _LEVEL)
        lifted, pull, curve = hanging(wide, high, length)
        way = level / wide[:, None]
        gradient = np.zeros(positions.shape)
        gradient[tied] = weights[:, None] * (pull[0][:, None] * way + pull[1][:, None] * up)
        diagonal = np.zeros((*positions.shape, 3))
        both = way[:, :, None] * way[:, None, :]
        mixed = way[:, :, None] * up + up[:, None] * way[:, None, :]
        across = np.eye(3) - np.outer(up, up) - both
        stiff = curve[0][:, None, None] * both + curve[1][:, None, None] * mixed
        stiff = stiff + curve[2][:, None, None] * np.outer(up, up)
        stiff = stiff + (pull[0] / wide)[:, None, None] * across
        diagonal[tied] = weights[:, None, None] * stiff
        return Potential(float((weights * lifted).sum()), gradient, diagonal)

    return energy


def cable_length(nodes: FloatArray, parts: FloatArray, faults: Faults) -> float:
    """Return how long a cable is [m]: by a share more than the way to where it ends.

    Args:
        nodes: where nothing is loaded [m], shape (N, 3).
        parts: of the cable that each bears, shape (N,).
        faults: say where its anchor is, and by how much longer it is.
    """
    way = parts @ nodes / parts.sum() - 1e-3 * np.array(faults.mass_anchor)
    return float((1.0 + faults.mass_longer) * np.linalg.norm(way))


def hanging(
    wide: FloatArray, high: FloatArray, length: float
) -> tuple[FloatArray, tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray, FloatArray]]:
    """Return a catenary's energy, and its two derivatives by where it ends, by weight per length.

    Its parameter a follows from sqrt(L^2 - v^2) = 2 a sinh(h / 2 a), its pull on an end is a to
    the side and (L + v coth(h / 2 a)) / 2 down (Irvine 1981, Cable Structures, sec. 1.2). Where
    it would be taut the energy is infinite: a line search turns back from there.

    Args:
        wide: h, from one end to the other, level [m], shape (N,).
        high: v, by how much higher the other end is [m], shape (N,).
        length: L [m].

    Returns:
        Energy over that of all at the first end's height [m^2], slopes by h and v [m], and
        curvatures by h twice, by both, and by v twice, shape (N,) each.
    """
    chord = np.sqrt(np.maximum(length**2 - high**2, 0.0))
    is_slack = chord > wide * (1.0 + 1e-9)
    q = _opening(np.where(is_slack, chord / wide, 1.5))
    a, steep = wide / (2.0 * q), 1.0 / np.tanh(q)
    middle = np.arctanh(np.clip(high / length, -0.999999, 0.999999))
    spread = 2.0 * q + np.cosh(2.0 * middle) * np.sinh(2.0 * q)
    energy = 0.5 * a**2 * spread - a * np.cosh(middle - q) * length
    # By how much q follows the ratio of chord and way.
    slope = q**2 / (q * np.cosh(q) - np.sinh(q))
    by_wide = -slope * chord / wide**2
    by_high = -slope * high / (np.maximum(chord, _LEVEL) * wide)
    curve = (
        (1.0 - wide / q * by_wide) / (2.0 * q),
        -wide / (2.0 * q**2) * by_high,
        0.5 * (steep - high / np.sinh(q) ** 2 * by_high),
    )
    return np.where(is_slack, energy, np.inf), (a, 0.5 * (length + high * steep)), curve


def _opening(ratio: FloatArray) -> FloatArray:
    """Return where sinh(q) / q is a ratio above 1, shape (N,)."""
    # Above where it is, for all ratios: Newton's steps come down to it.
    q = np.minimum(np.sqrt(6.0 * (ratio - 1.0)), 2.0 * np.log(2.0 * ratio) + 1.0)
    for _ in range(_ROUNDS):
        q = q - (np.sinh(q) - ratio * q) / (np.cosh(q) - ratio)
    return np.asarray(q)
