# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bodies that are bent to and fro or out of their plane, branched, or held at two feet.

As in `other_bodies`, what is held lies along x, and z is the thinner way of flat ones.
"""

from dataclasses import replace
from functools import partial

import numpy as np

from benchmarks.blind.further_bodies import FURTHER_FAMILIES, of_size
from benchmarks.blind.later_shape import LaterShape
from benchmarks.blind.other_bodies import (
    block_shape,
    Family,
    middle,
    OTHER_FAMILIES,
    OtherShape,
    walls,
)

_shape = partial(block_shape, LaterShape)


def _zigzag(size: float, random: np.random.Generator) -> OtherShape:
    """Draw a bar with three corners, one way and the other in turn."""
    side, clamp = random.choice([-1.0, 1.0]), random.uniform(0.11, 0.14)
    angles = side * np.deg2rad([random.uniform(*ends) for ends in ((30, 50), (60, 85), (55, 85))])
    width, height = random.uniform(0.075, 0.095), random.uniform(0.08, 0.1)
    corners = np.array([0.27, 0.52, 0.77]) + random.uniform(-0.02, 0.02, 3)

    def make(line: float) -> OtherShape:
        bends = [(line * (at - 0.055), line * (at + 0.055)) for at in corners]
        x = [0.0, clamp * line, *(float(end) for bend in bends for end in bend), line]
        signs = (1.0, -1.0, 1.0)
        arcs = tuple(
            (float(begin), float(end), float(sign * angle))
            for (begin, end), sign, angle in reversed(list(zip(bends, signs, angles, strict=True)))
        )
        cells = ((1, 2, 3, 3, 3, 3, 3, 3), (3,), (3,))
        tets = ((2, 2, 5, 3, 5, 3, 5, 4), (3,), (3,))
        sides = (x, middle(width * line), middle(height * line))
        return _shape('zigzag', sides, (), cells, tets, arcs=arcs)

    return of_size(make, size)


def _coil(size: float, random: np.random.Generator) -> OtherShape:
    """Draw half a turn of a coil, whose pitch grows."""
    angle, side = np.deg2rad(random.uniform(150.0, 190.0)), random.choice([-1.0, 1.0])
    clamp, rise = random.uniform(0.1, 0.14), random.uniform(0.14, 0.22)
    width, height = random.uniform(0.08, 0.1, 2)

    def make(line: float) -> OtherShape:
        x, begin = [0.0, clamp * line, line], (clamp + 0.03) * line
        more = {
            'arcs': ((begin, line, float(angle)),),
            'rise': (begin, float(side * rise * line)),
        }
        cells, tets = ((1, 16), (3,), (3,)), ((2, 24), (3,), (3,))
        sides = (x, middle(width * line), middle(height * line))
        return _shape('coil', sides, (), cells, tets, **more)

    return of_size(make, size)


def _cane(size: float, random: np.random.Generator) -> OtherShape:
    """Draw a straight shank, and beyond it an arc of 150 to 190 degrees."""
    angle, side = np.deg2rad(random.uniform(150.0, 190.0)), random.choice([-1.0, 1.0])
    clamp, amid = random.uniform(0.12, 0.16), random.uniform(0.42, 0.5)
    width, height = random.uniform(0.075, 0.095), random.uniform(0.08, 0.1)

    def make(line: float) -> OtherShape:
        x = [0.0, clamp * line, amid * line, 0.95 * line, line]
        arc = (x[2], x[3], float(side * angle))
        cells, tets = ((1, 5, 11, 1), (3,), (3,)), ((2, 6, 16, 1), (3,), (3,))
        sides = (x, middle(width * line), middle(height * line))
        return _shape('cane', sides, (), cells, tets, arcs=(arc,))

    return of_size(make, size)


def _vault(size: float, random: np.random.Generator) -> OtherShape:
    """Draw a vault on two legs, whose feet are held at other heights."""
    broad, leg = random.uniform(0.8, 1.0), random.uniform(0.14, 0.17)
    clamp, higher, held = random.uniform((0.13, 0.08, 0.13), (0.17, 0.16, 0.17))
    vault, height = random.uniform(0.15, 0.25), random.uniform(0.1, 0.14)

    def make(line: float) -> OtherShape:
        ends = np.cumsum([clamp, higher, held]) * line
        x = [0.0, *(float(end) for end in ends), (1.0 - leg) * line, line]
        y, z = walls(broad * line, leg * broad * line), middle(height * line)
        feet = [((0.0, x[1]), (y[0], y[1])), ((x[2], x[3]), (y[2], y[3]))]
        more = {
            'held': tuple((along, across, (z[0], z[1])) for along, across in feet),
            'free': line - x[1] + 0.5 * y[3],
            'arms': 'feet',
            'feet': (y[2], x[3], x[4], vault * line),
        }
        empty = (*((block, 1, 0) for block in range(4)), (0, 2, 0), (1, 2, 0))
        cells, tets = ((1, 1, 1, 5, 2), (2, 6, 2), (3,)), ((2, 2, 2, 6, 2), (2, 8, 2), (3,))
        return _shape('vault', (x, y, z), empty, cells, tets, **more)

    return of_size(make, size)


def _comb(size: float, random: np.random.Generator) -> OtherShape:
    """Draw a spine with four teeth on one side, every other one shorter."""
    clamp, width = random.uniform(0.14, 0.18) * size, random.uniform(0.11, 0.14) * size
    short, long = random.uniform((0.18, 0.34), (0.26, 0.48)) * size
    gap, half, z = random.uniform(0.46, 0.54), 0.5 * width, middle(0.09 * size)
    steps = np.tile([gap, 1.0 - gap], 4) * (size - clamp) / 4.0
    x = [0.0, clamp, *(float(end) for end in clamp + np.cumsum(steps))]
    y = [-half, half, half + float(short), half + float(long)]
    empty = (
        *((block, way, 0) for block in (0, 1, 3, 5, 7) for way in (1, 2)),
        *((block, 2, 0) for block in (2, 6)),
    )
    cells, tets = ((1, *((2, 2) * 4)), (2, 3, 2), (2,)), ((2, *((2, 2) * 4)), (2, 4, 3), (2,))
    held = ((0.0, clamp), (-half, half), (z[0], z[1]))
    return _shape('comb', (x, y, z), empty, cells, tets, held=(held,))


def _wye(size: float, random: np.random.Generator) -> OtherShape:
    """Draw a stem that parts into two arms, which spread by other angles and are not as long."""
    clamp, fork = random.uniform(0.13, 0.16), random.uniform(0.36, 0.42)
    width, height = random.uniform(0.16, 0.2), random.uniform(0.08, 0.1)
    shorter, gap = random.uniform(0.84, 0.92), random.uniform(0.12, 0.18)
    angles = np.deg2rad(random.uniform((28.0, 46.0), (42.0, 62.0)))

    def make(line: float) -> OtherShape:
        x = [0.0, clamp * line, fork * line, shorter * line, line]
        half = 0.5 * width * line
        y, z = [-half, -gap * half, gap * half, half], middle(height * line)
        aside, begin = 0.5 * (1.0 + gap) * half, (fork + 0.02) * line
        empty = ((2, 1, 0), (3, 1, 0), (3, 2, 0))
        cells, tets = ((1, 4, 8, 2), (2, 1, 2), (2,)), ((2, 4, 10, 3), (3, 1, 3), (2,))
        spread = (begin, begin + 0.26 * line, aside, float(angles[0]), float(angles[1]))
        return _shape('wye', (x, y, z), empty, cells, tets, spread=spread)

    return of_size(make, size)


def _anew(family: Family, sizes: tuple[float, float], sag: float) -> Family:
    return replace(family, sizes=sizes, sags=(0.02, sag))


NEW_FAMILIES = {
    'zigzag': Family(_zigzag, (0.070, 0.280), (0.02, 0.15), is_flat=True),
    'coil': Family(_coil, (0.060, 0.220), (0.02, 0.15)),
    'cane': Family(_cane, (0.070, 0.260), (0.02, 0.30), is_flat=True),
    'vault': Family(_vault, (0.080, 0.300), (0.02, 0.10), is_flat=True),
    'comb': Family(_comb, (0.070, 0.280), (0.02, 0.15), is_flat=True),
    'wye': Family(_wye, (0.070, 0.280), (0.02, 0.15), is_flat=True),
}
LATER_FAMILIES = {
    **NEW_FAMILIES,
    'elbow': _anew(OTHER_FAMILIES['elbow'], (0.060, 0.260), 0.30),
    'ribbon': _anew(FURTHER_FAMILIES['ribbon'], (0.060, 0.200), 0.15),
    'crank': _anew(FURTHER_FAMILIES['crank'], (0.070, 0.260), 0.15),
    'horseshoe': _anew(FURTHER_FAMILIES['horseshoe'], (0.060, 0.200), 0.30),
}
