# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that are drawn beside other forms of its effects.

Forces and shapes are as large as move the tip by some 1, 3 and 10 mm, by the formulas of a
slender beam: of the body's least height, at its modulus.
"""

import numpy as np

from benchmarks.blind.amplitudes import Drawer, Effect, number, signed, weight_moment
from benchmarks.blind.pulls import MAGNETIC_FROM
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import Setup
from benchmarks.blind.shapes import FloatArray

MOVES = (0.001, 0.003, 0.010)  # Of the tip [m].
# Of a magnet's pull, over what the formula asks: it comes from another side in every pose.
_MORE = 1.6


def magnet(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw a magnet beyond the tip, to one side."""
    distance = float(random.uniform(0.13, 0.16))
    point, aside = _beyond_tip(setup, distance, 0.8, random)
    # Its force acts at the middle of what is drawn.
    at = 0.5 * (1.0 + MAGNETIC_FROM)
    lever = at**2 * (1.5 - 0.5 * at) * aside
    force = number(_MORE * MOVES[size] * tip_stiffness(setup) / lever, random)
    changes = {'magnet': force, 'pull_point': point, 'pull_distance': round(distance, 5)}
    return Effect('magnet', {'force': force, **_place(point)}, 'N at first, m', changes)


def tether(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw a soft spring from the tip to a point mostly beside it."""
    distance = float(random.uniform(0.11, 0.15))
    point, aside = _beyond_tip(setup, distance, 0.3, random)
    force = number(MOVES[size] * tip_stiffness(setup) / aside, random)
    slack = round(float(random.uniform(0.4, 0.7)), 4)
    changes = {
        'tether': force,
        'tether_slack': slack,
        'pull_point': point,
        'pull_distance': round(distance, 5),
    }
    amplitude = {'force': force, 'slack': slack, **_place(point)}
    return Effect('tether', amplitude, 'N at first, of the distance, m', changes)


def heat(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw how much the upper side grows, and which share of that in each pose."""
    free = setup.shape.length - setup.shape.clamp
    # A bend of growth / height turns and carries the tip.
    growth = 100.0 * MOVES[size] * 2.0 * setup.shape.section[1] / free**2
    upper = signed(growth, random)
    shares = tuple(round(float(random.uniform(0.3, 1.0)), 4) for _ in setup.observations)
    told = {f'share_{number}': share for number, share in enumerate(shares)}
    changes = {'heat': upper, 'heat_shares': shares}
    return Effect('heat', {'growth': upper, **told}, '%, of that by pose', changes)


def cone(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw by how much the section is smaller at the tip than stated."""
    share = signed((0.04, 0.10, 0.25)[size], random)
    return Effect('cone', {'share': share}, 'of the section', {'cone': share})


def torn(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw how deep a body is torn, near its clamp."""
    depth = number((0.10, 0.20, 0.48)[size], random)
    at = round(float(random.uniform(0.12, 0.3)), 4)
    amplitude = {'depth': depth, 'at': at}
    return Effect(
        'torn', amplitude, 'of the height, of the free length', {'torn': depth, 'torn_at': at}
    )


def wiggle(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw an error of depth that swings as the depth grows."""
    amount = number((1.0, 2.0, 5.0)[size], random)
    period = round(float(random.uniform(40.0, 60.0)), 3)
    phase = round(float(random.uniform(0.0, 2.0 * np.pi)), 4)
    changes = {'wiggle': amount, 'wiggle_period': period, 'wiggle_phase': phase}
    amplitude = {'amount': amount, 'period': period, 'phase': phase}
    return Effect('wiggle', amplitude, 'mm, mm, rad', changes)


def tip_stiffness(setup: Setup) -> float:
    """Return the force at the tip by how far it gives way [N/m]."""
    low, high = sorted(setup.shape.section)
    free = setup.shape.length - setup.shape.clamp
    return float(setup.youngs_modulus * high * low**3 / (4.0 * free**3))


def tip_sag(setup: Setup) -> float:
    """Return how far a tip sinks by the weight of a slender beam [m]."""
    mass, _ = weight_moment(setup)
    return 0.375 * 9.81 * mass / tip_stiffness(setup)


def depth_amid_body(setup: Setup, random: np.random.Generator) -> float:
    """Draw a pose that is neither the nearest nor the farthest; return its middle's depth [m]."""
    shape = setup.shape
    middle = shape.place(np.array([[0.5 * (shape.clamp + shape.length), 0.0, 0.0]]))
    depths = sorted(
        float(applied(setup.depth_from_world @ pose.world_from_object, middle)[0, 2])
        for pose in setup.observations
    )
    return depths[(len(depths) - int(random.integers(2))) // 2]


def _beyond_tip(
    setup: Setup, distance: float, outward: float, random: np.random.Generator
) -> tuple[tuple[float, float, float], float]:
    """Draw a point of the world at a distance from where the tip rests at first.

    Returns:
        The point [m], and the share of its direction that is across the body.
    """
    world = setup.observations[0].world_from_object
    tip = applied(world, setup.shape.place(np.array([[setup.shape.length, 0.0, 0.0]])))[0]
    aside = float(np.sqrt(1.0 - outward**2))
    angle = random.uniform(0.0, 2.0 * np.pi)
    along: FloatArray = world[:3, :3] @ np.array(
        [outward, aside * np.cos(angle), aside * np.sin(angle)]
    )
    x, y, z = (round(float(value), 6) for value in tip + distance * along)
    return (x, y, z), aside


def _place(point: tuple[float, float, float]) -> dict[str, float | str]:
    return {f'from_{axis}': value for axis, value in zip('xyz', point, strict=True)}


FURTHER_OUTSIDE: dict[str, Drawer] = {
    drawer.__name__: drawer for drawer in (magnet, tether, heat, cone, torn, wiggle)
}
