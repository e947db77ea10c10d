# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the seventh set alone has."""

import numpy as np

from benchmarks.blind.amplitudes import Drawer, Effect, number
from benchmarks.blind.outside_forms import MOVES, tip_stiffness
from benchmarks.blind.setups import Observation, Setup
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.springs import nearby

_JET_REACH = 0.06  # Half the share of the free length over which a jet of air presses.


def hollow(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw how long a cavity below the upper side is, and where its middle lies."""
    length = number((0.05, 0.1, 0.35)[size], random)
    at = round(float(random.uniform(0.08, 0.2)) + 0.5 * length, 4)
    amplitude: dict[str, float | str] = {'length': length, 'at': at}
    changes = {'hollow': length, 'hollow_at': at}
    return Effect('hollow', amplitude, 'of the free length', changes)


def jet(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw a jet of air against a broad side, and which share of it each pose meets."""
    at = round(float(random.uniform(0.5, 0.75)), 4)
    # The tip goes on by the slope of the place that is pushed.
    lever = 0.5 * at**2 * (3.0 - at)
    force = number(MOVES[size] * tip_stiffness(setup) / lever, random)
    width, height = setup.shape.section
    side = float(random.choice([-1.0, 1.0]))
    normal = (0.0, side, 0.0) if width < height else (0.0, 0.0, side)
    shares = tuple(round(float(random.uniform(0.3, 1.0)), 4) for _ in setup.observations)
    told = {f'share_{number}': share for number, share in enumerate(shares)}
    amplitude: dict[str, float | str] = {
        'force': force,
        'at': at,
        'y': normal[1],
        'z': normal[2],
        **told,
    }
    changes = {'jet': force, 'jet_at': at, 'jet_normal': normal, 'jet_shares': shares}
    return Effect('jet', amplitude, 'N, of the free length, of that by pose', changes)


def stripes(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw an error of depth that swings over the columns of the image."""
    amount = number((1.0, 2.0, 5.0)[size], random)
    period = round(float(random.uniform(30.0, 60.0)), 3)
    phase = round(float(random.uniform(0.0, 2.0 * np.pi)), 4)
    changes = {'stripes': amount, 'stripes_period': period, 'stripes_phase': phase}
    amplitude: dict[str, float | str] = {'amount': amount, 'period': period, 'phase': phase}
    return Effect('stripes', amplitude, 'mm, px, rad', changes)


def warming(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw by how much the body has become softer by the last pose."""
    softer = number((0.08, 0.2, 0.5)[size], random)
    return Effect('warming', {'log_ratio': softer}, 'log E, first less last', {'warming': softer})


def pressed(
    amount: float,
    at: float,
    normal: tuple[float, float, float],
    share: float,
    masses: FloatArray,
    shares: FloatArray,
) -> FloatArray:
    """Return forces of nodes that a jet of air presses on [N], shape (N, 3).

    Args:
        amount: of the force [N].
        at: share of the free length where it comes to the body.
        normal: its direction, object frame.
        share: of it that a pose meets.
        masses: of nodes, by which nodes share it, shape (N,).
        shares: of the free length at which they lie, shape (N,).
    """
    weights = nearby(at, _JET_REACH, masses, shares)
    return share * amount * (weights / weights.sum())[:, None] * np.array(normal)


def warmed(setup: Setup, observation: Observation, amount: float) -> float:
    """Return modulus over that of the first pose where log E falls by an amount to the last."""
    last = max(len(setup.observations) - 1, 1)
    return float(np.exp(-amount * setup.pose_number(observation) / last))


SEVENTH_OUTSIDE: dict[str, Drawer] = {
    drawer.__name__: drawer for drawer in (hollow, jet, stripes, warming)
}
