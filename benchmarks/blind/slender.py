# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How far a slender body's tip goes by what acts along it, where its section is not the same."""

import numpy as np

from benchmarks.blind.outside_forms import tip_sag
from benchmarks.blind.setups import GRAVITY, Setup
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.twelfth_forms import held_moment

SHARES = np.asarray((np.arange(200) + 0.5) / 200.0, dtype=np.float64)  # Of the free length.


def softness(setup: Setup) -> FloatArray:
    """Return how much more easily a section bends than that at the clamp, at `SHARES`, (200,)."""
    shape = setup.shape
    rim = np.zeros((len(SHARES), 3))
    rim[:, 0] = shape.clamp + SHARES * (shape.length - shape.clamp)
    # An arch lies across z, and leaves heights as they are.
    rim[:, 2] = 0.5 * shape.section[1]
    thinner = shape.place(rim)[:, 2] / rim[:, 2]
    return np.asarray(thinner**-4.0)


def even_sag(setup: Setup) -> float:
    """Return how far a tip sinks by the weight of a body that were an even bar as heavy [m].

    As heavy is what has the same moment about the middle of what is held: of a bar with a
    crossbar more, of one that tapers less.
    """
    shape = setup.shape
    width, height = shape.section
    per_length = setup.density * GRAVITY * width * height
    bar = 0.5 * per_length * shape.length * (shape.length - shape.clamp)
    return tip_sag(setup) * held_moment(setup) / bar


def towards(degrees: float, way: FloatArray) -> tuple[float, float]:
    """Return the tilt about the world's x and z that draws a way [deg].

    Args:
        degrees: how far it tilts.
        way: level, world, shape (3,).
    """
    # About the world's x gravity turns towards -z, about z towards x.
    return round(float(-degrees * way[2]), 4), round(float(degrees * way[0]), 4)


def borne_way(setup: Setup, compliance: FloatArray) -> float:
    """Return the tip's longest way by what a clamp gives to a body's weight [m].

    Args:
        setup: with its poses.
        compliance: shift and turn by force and moment, shape (6, 6).
    """
    moment, reach = held_moment(setup), setup.shape.length - 0.5 * setup.shape.clamp
    downs = -np.array([pose.world_from_object[1, :3] for pose in setup.observations])
    # All of the weight, amid the body, and its moment.
    moments = moment * np.cross([1.0, 0.0, 0.0], downs)
    loads = np.concatenate([moment / (0.5 * setup.shape.length) * downs, moments], axis=1)
    motions = loads @ compliance
    moves = motions[:, :3] + np.cross(motions[:, 3:], [reach, 0.0, 0.0])
    return float(np.linalg.norm(moves, axis=1).max())


def aside_give(setup: Setup, way: FloatArray) -> float:
    """Return by how much a body gives way across its sides at most, over that of its thinner one.

    By the inverse square of how thick it is that way.

    Args:
        setup: with its poses.
        way: of the push, world, shape (3,).
    """
    section = np.array(setup.shape.section)
    gives = (section.min() / section) ** 2
    return max(
        float(np.linalg.norm(gives * (pose.world_from_object[:3, 1:3].T @ way)))
        for pose in setup.observations
    )


def most_drawn(setup: Setup) -> float:
    """Return by how much the square of a length grows at most near an even bar's surface."""
    free = setup.shape.length - setup.shape.clamp
    return 4.0 * even_sag(setup) * min(setup.shape.section) / free**2


def side_stiffness(held: float, part: float, most: float) -> float:
    """Return how stiff a layer along one side is, over the rest, by which a body sags less.

    Args:
        held: share of its sag by which that is less.
        part: of the height, which the layer has.
        most: how stiff it may be.
    """
    stiff = np.linspace(0.0, most, 301)
    # Of a section whose outer part is stiffer, about its own middle of stiffness.
    middle = 0.5 * (1.0 - part)
    moved = stiff * part * middle / (1.0 + stiff * part)
    bears = 1.0 + 12.0 * (
        stiff * part * (middle**2 + part**2 / 12.0) - (1.0 + stiff * part) * moved**2
    )
    return float(np.interp(held, 1.0 - 1.0 / bears, stiff))


def levers(setup: Setup) -> FloatArray:
    """Return the tip's way by a load at `SHARES`, over that by as much, alike along it, (200,).

    That is 3/8 of what a load at the tip does, where all sections are the same.
    """
    beyond = np.maximum(SHARES[:, None] - SHARES, 0.0)
    turned = beyond @ ((1.0 - SHARES) * softness(setup)) / len(SHARES)
    return np.asarray(3.0 * turned / 0.375)
