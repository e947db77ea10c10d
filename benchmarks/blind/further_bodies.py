# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""More bodies that are no bars with one clamped end: bent, tapered, twisted, pierced or crossed.

As in `other_bodies`, what is held lies along x, and z is the thinner way of flat ones.
"""

from collections.abc import Callable
from functools import partial

import numpy as np

from benchmarks.blind.further_shape import FurtherShape
from benchmarks.blind.other_bodies import block_shape, Family, middle, OtherShape, walls

_shape = partial(block_shape, FurtherShape)


def of_size(make: Callable[[float], OtherShape], size: float) -> OtherShape:
    """Return a body of a size [m], by one that makes it by the length of its line."""
    return make(size / make(1.0).size)


def _horseshoe(size: float, random: np.random.Generator) -> OtherShape:
    """Draw an arch of 140 to 170 degrees that is held at one foot."""
    angle, clamp = np.deg2rad(random.uniform(140.0, 170.0)), random.uniform(0.11, 0.15)
    width, height = random.uniform(0.08, 0.11), random.uniform(0.08, 0.12)

    def make(line: float) -> OtherShape:
        x, begin = [0.0, clamp * line, line], (clamp + 0.03) * line
        cells, tets = ((1, 16), (3,), (3,)), ((2, 24), (3,), (3,))
        more = {'arcs': ((begin, line, float(angle)),)}
        sides = (x, middle(width * line), middle(height * line))
        return _shape('horseshoe', sides, (), cells, tets, **more)

    return of_size(make, size)


def _ribbon(size: float, random: np.random.Generator) -> OtherShape:
    """Draw a ribbon like an S, whose arcs are not alike."""
    inner, outer = np.deg2rad(random.uniform(55.0, 95.0, 2))
    clamp, amid = random.uniform(0.12, 0.15), random.uniform(0.48, 0.6)
    width, height = random.uniform(0.2, 0.32), random.uniform(0.06, 0.08)

    def make(line: float) -> OtherShape:
        x, y, z = [0.0, clamp * line, line], middle(width * line), middle(height * line)
        arcs = (
            ((amid + 0.01) * line, line, -float(outer)),
            ((clamp + 0.03) * line, (amid - 0.01) * line, float(inner)),
        )
        cells, tets = ((1, 18), (4,), (2,)), ((2, 24), (4,), (2,))
        more = {'arcs': arcs, 'is_upright': True}
        return _shape('ribbon', (x, y, z), (), cells, tets, **more)

    return of_size(make, size)


def _tentacle(size: float, random: np.random.Generator) -> OtherShape:
    """Draw a round body that is a third as thick at its tip, and curls."""
    angle, clamp = np.deg2rad(random.uniform(30.0, 75.0)), random.uniform(0.13, 0.17)
    taper, width = random.uniform(0.6, 0.72), random.uniform(0.14, 0.18)

    def make(line: float) -> OtherShape:
        x, side = [0.0, clamp * line, line], middle(width * line)
        cells, tets = ((1, 15), (3,), (3,)), ((2, 20), (4,), (4,))
        more = {
            'arcs': (((clamp + 0.1) * line, line, float(angle)),),
            'round': 0.6,
            'taper': (taper, taper),
        }
        return _shape('tentacle', (x, side, list(side)), (), cells, tets, **more)

    return of_size(make, size)


def _ring(size: float, random: np.random.Generator) -> OtherShape:
    """Draw a disc with a round hole on a stem."""
    clamp, neck = random.uniform(0.14, 0.18) * size, random.uniform(0.28, 0.36) * size
    height, half = random.uniform(0.07, 0.1) * size, 0.5 * (size - neck)
    web = random.uniform(0.38, 0.46) * half
    x = [0.0, clamp, neck, neck + web, size - web, size]
    y = walls(2.0 * half, web)
    empty = (*((block, side, 0) for block in (0, 1) for side in (0, 2)), (3, 1, 0))
    cells, tets = ((1, 3, 2, 5, 2), (2, 4, 2), (2,)), ((2, 3, 3, 6, 3), (2, 4, 2), (2,))
    z = middle(height)
    more = {
        'held': (((0.0, clamp), (y[1], y[2]), (z[0], z[1])),),
        'disc': (neck, half, 0.8),
    }
    return _shape('ring', (x, y, z), empty, cells, tets, **more)


def _bellows(size: float, random: np.random.Generator) -> OtherShape:
    """Draw a finger of five thick parts and, between them, thin ones."""
    clamp, width = random.uniform(0.15, 0.2) * size, random.uniform(0.2, 0.26) * size
    wall, thin = random.uniform(0.2, 0.26) * width, random.uniform(0.35, 0.5)
    steps = [clamp, *([thin, 1.0 - thin] * 5)]
    x = [0.0, clamp, *(clamp + np.cumsum(steps[1:]) / 5.0 * (size - clamp))]
    side = walls(width, wall)
    empty = tuple(
        (block, one, two)
        for block in range(1, 11, 2)
        for one in range(3)
        for two in range(3)
        if (one, two) != (1, 1)
    )
    cells = ((1, *((2, 1) * 5)), (1, 2, 1), (1, 2, 1))
    tets = ((2, *((2, 2) * 5)), (1, 2, 1), (1, 2, 1))
    return _shape('bellows', (x, side, list(side)), empty, cells, tets)


def _fork(size: float, random: np.random.Generator) -> OtherShape:
    """Draw a fork of two prongs, one shorter and thinner than the other."""
    width, height = random.uniform(0.3, 0.42) * size, random.uniform(0.08, 0.11) * size
    broad, gap = random.uniform(0.4, 0.48) * width, random.uniform(0.2, 0.28) * width
    clamp, palm = random.uniform(0.14, 0.18) * size, random.uniform(0.32, 0.4) * size
    x = [0.0, clamp, palm, random.uniform(0.75, 0.88) * size, size]
    y = [-0.5 * width, broad - 0.5 * width, broad + gap - 0.5 * width, 0.5 * width]
    empty = ((2, 1, 0), (3, 1, 0), (3, 2, 0))
    cells, tets = ((1, 2, 7, 3), (3, 2, 2), (3,)), ((2, 2, 9, 3), (3, 2, 2), (2,))
    return _shape('fork', (x, y, middle(height)), empty, cells, tets)


def _wedge(size: float, random: np.random.Generator) -> OtherShape:
    """Draw a thick wedge with one side that is level."""
    clamp, width = 0.2 * size, random.uniform(0.16, 0.3) * size
    height, thinner = random.uniform(0.2, 0.28) * size, random.uniform(0.6, 0.8)
    x, cells, tets = [0.0, clamp, size], ((1, 9), (4,), (4,)), ((3, 9), (4,), (4,))
    more = {'taper': (0.0, thinner), 'level': True}
    return _shape('wedge', (x, middle(width), middle(height)), (), cells, tets, **more)


def _cross(size: float, random: np.random.Generator) -> OtherShape:
    """Draw a cross that is held amid, with four arms of which none is as long as another."""
    clamp, width = random.uniform(0.16, 0.2) * size, random.uniform(0.14, 0.18) * size
    shares, left = np.array([0.44, 0.56]), np.array([0.46, 0.5])
    arms, sides = (size - clamp) * shares, (size - width) * left * random.uniform(0.75, 0.9)
    x = [-float(arms[0]), 0.0, clamp, clamp + float(arms[1])]
    half = 0.5 * width
    y = [-half - float(sides[0]), -half, half, half + float(sides[1])]
    z = middle(random.uniform(0.06, 0.08) * size)
    more = {
        'clamp': clamp,
        'free': float(arms[1]),
        'held': (((0.0, clamp), (-half, half), (z[0], z[1])),),
        'arms': 'all',
        'crossing': (-half, half),
    }
    empty = tuple((block, side, 0) for block in (0, 2) for side in (0, 2))
    cells, tets = ((6, 2, 7), (6, 2, 6), (3,)), ((7, 3, 8), (6, 3, 7), (2,))
    return _shape('cross', (x, y, z), empty, cells, tets, **more)


def _crescent(size: float, random: np.random.Generator) -> OtherShape:
    """Draw a C that is held amid its back, with two arms that are not as long."""
    angles = np.deg2rad(random.uniform(75.0, 110.0, 2))
    clamp, arm = random.uniform(0.12, 0.15), random.uniform(0.36, 0.4)
    width, height = random.uniform(0.08, 0.1), random.uniform(0.08, 0.11)

    def make(line: float) -> OtherShape:
        x = [-arm * line, 0.0, clamp * line, (1.0 - arm) * line]
        y, z, begin = middle(width * line), middle(height * line), (clamp + 0.02) * line
        more = {
            'clamp': x[2],
            'free': x[3] - x[2],
            'held': (((0.0, x[2]), (y[0], y[1]), (z[0], z[1])),),
            'arms': 'both',
            'arcs': ((begin, x[3], float(angles[0])),),
            'back_arcs': ((begin, (clamp + arm) * line, float(angles[1])),),
        }
        cells, tets = ((9, 1, 11), (3,), (3,)), ((11, 2, 12), (3,), (3,))
        return _shape('crescent', (x, y, z), (), cells, tets, **more)

    return of_size(make, size)


def _twisted(size: float, random: np.random.Generator) -> OtherShape:
    """Draw a strip that turns about its length by 70 to 150 degrees."""
    clamp, width = random.uniform(0.13, 0.17) * size, random.uniform(0.16, 0.22) * size
    side, height = random.choice([-1.0, 1.0]), random.uniform(0.07, 0.095) * size
    turn = float(side * np.deg2rad(random.uniform(70.0, 150.0)))
    x, cells, tets = [0.0, clamp, size], ((1, 16), (4,), (2,)), ((2, 22), (4,), (2,))
    more = {'twist': turn}
    return _shape('twisted', (x, middle(width), middle(height)), (), cells, tets, **more)


def _crank(size: float, random: np.random.Generator) -> OtherShape:
    """Draw a bar that is shifted aside by a riser amid its length."""
    clamp, width = random.uniform(0.14, 0.18) * size, random.uniform(0.1, 0.13) * size
    height, riser = random.uniform(0.1, 0.13) * size, random.uniform(0.11, 0.14) * size
    half, aside = 0.5 * width, random.uniform(0.3, 0.45) * size
    amid = random.uniform(0.45, 0.55) * size
    x = [0.0, clamp, amid, amid + riser, size]
    y, z = [-half, half, aside - half, aside + half], middle(height)
    more = {
        'free': size - clamp + 0.5 * aside,
        'held': (((0.0, clamp), (-half, half), (z[0], z[1])),),
    }
    empty = tuple((block, side, 0) for block, ways in _CRANKED for side in ways)
    cells, tets = ((1, 5, 2, 6), (2, 4, 2), (3,)), ((2, 7, 2, 8), (2, 5, 2), (3,))
    return _shape('crank', (x, y, z), empty, cells, tets, **more)


_CRANKED = ((0, (1, 2)), (1, (1, 2)), (3, (0, 1)))  # Empty blocks of a crank, by those along x.
FURTHER_FAMILIES = {
    'horseshoe': Family(_horseshoe, (0.050, 0.220), (0.02, 0.15), is_flat=True),
    'ribbon': Family(_ribbon, (0.050, 0.160), (0.02, 0.15)),
    'tentacle': Family(_tentacle, (0.060, 0.300), (0.02, 0.15)),
    'ring': Family(_ring, (0.060, 0.260), (0.02, 0.15), is_flat=True),
    'bellows': Family(_bellows, (0.055, 0.300), (0.02, 0.15)),
    'fork': Family(_fork, (0.060, 0.280), (0.02, 0.15), is_flat=True),
    'wedge': Family(_wedge, (0.060, 0.300), (0.02, 0.15)),
    'cross': Family(_cross, (0.090, 0.300), (0.02, 0.15), is_flat=True),
    'crescent': Family(_crescent, (0.080, 0.260), (0.02, 0.15), is_flat=True),
    'twisted': Family(_twisted, (0.060, 0.240), (0.02, 0.15)),
    'crank': Family(_crank, (0.060, 0.280), (0.02, 0.15), is_flat=True),
}
