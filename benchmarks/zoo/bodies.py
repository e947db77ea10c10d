# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The animals: bodies from ten to thirteen centimetres, from code alone."""

from collections.abc import Callable, Sequence

import numpy as np

from benchmarks.zoo.solids import FloatArray, Solid

_CORNERS = 12  # Of the tube's section.


def beam() -> Solid:
    """A bar of uniform section, which may slide along itself."""
    x, y, z = (0.0, 0.024, 0.124), (-0.009, 0.009), (-0.007, 0.007)
    return _blocks('beam', x, y, z, ((2, 14), (3,), (3,)))


def plate() -> Solid:
    """A thin sheet."""
    x, y, z = (0.0, 0.020, 0.120), (-0.025, 0.025), (-0.003, 0.003)
    return _blocks('plate', x, y, z, ((2, 16), (8,), (1,)))


def tube() -> Solid:
    """A hollow bar with twelve sides."""
    x = np.array([0.0, 0.022, 0.122])
    return Solid(
        name='tube',
        x=x,
        y=_same((0.0075, 0.0110), len(x)),
        z=_same(range(_CORNERS + 1), len(x)),
        filled=np.ones((2, 1, _CORNERS), dtype=bool),
        cells=((2, 14), (1,), (1,) * _CORNERS),
        clamp=0.022,
        is_round=True,
    )


def notched_finger() -> Solid:
    """A strip with six chambers' walls on it and slots between them."""
    x, kinds = _row(0.022, [(0.004, 'slot'), (0.010, 'chamber')] * 6)
    counts = (2, *([1, 2] * 6))
    solid = _blocks(
        'notched_finger', x, (-0.010, 0.010), (-0.009, -0.003, 0.011), (counts, (3,), (1, 2))
    )
    solid.filled[np.array(kinds) == 'slot', :, 1] = False
    return solid


def spine() -> Solid:
    """Seven vertebrae with a process each, and thin necks between them."""
    x, kinds = _row(0.020, [(0.006, 'neck'), (0.009, 'vertebra')] * 7)
    y, z = (-0.014, -0.005, 0.005, 0.014), (-0.010, -0.005, 0.005, 0.020)
    counts = (2, *([2, 1] * 7))
    solid = _blocks('spine', x, y, z, (counts, (1, 2, 1), (1, 2, 1)))
    solid.filled[:, [0, 2], 2] = False
    is_neck = np.array(kinds) == 'neck'
    solid.filled[is_neck] = False
    solid.filled[is_neck, 1, 1] = True
    return solid


def fin_ray() -> Solid:
    """Two walls that meet at the tip, and ribs between them."""
    x, kinds = _row(
        0.020, [*[(0.0145, 'gap'), (0.0028, 'rib')] * 5, (0.012, 'gap'), (0.008, 'tip')]
    )
    along = np.clip((x - 0.020) / (x[-1] - 0.020), 0.0, 1.0)
    half, wall = 0.020 - 0.0145 * along, np.full(len(x), 0.0028)
    counts = (2, *([3, 1] * 5), 2, 2)
    solid = Solid(
        name='fin_ray',
        x=x,
        # The walls are of one thickness; what is between them narrows.
        y=np.stack([-half, wall - half, half - wall, half], axis=1),
        z=_same((-0.009, 0.009), len(x)),
        filled=np.ones((len(x) - 1, 3, 1), dtype=bool),
        cells=(counts, (1, 2, 1), (2,)),
        clamp=0.020,
    )
    solid.filled[np.array(kinds) == 'gap', 1] = False
    return solid


def dragon() -> Solid:
    """A lumpy body that winds, with limbs on one side more than on the other, held at its tail."""
    x = np.array([0.0, 0.020, 0.032, 0.044, 0.054, 0.066, 0.078, 0.088, 0.100, 0.116])
    half = 1e-3 * np.array([8.0, 8.0, 6.0, 9.0, 11.0, 10.5, 8.0, 5.5, 8.5, 5.0])
    high = 1e-3 * np.array([7.0, 7.0, 5.5, 8.0, 9.5, 9.0, 7.0, 5.5, 7.5, 4.0])
    side = 1e-3 * np.array([0.0, 0.0, 1.5, 3.0, 2.0, -1.0, -3.0, -2.0, 2.0, 5.0])
    lift = 1e-3 * np.array([0.0, 0.0, 1.0, 0.5, 1.5, 3.0, 5.5, 8.0, 9.0, 8.0])
    solid = Solid(
        name='dragon',
        x=x,
        y=np.stack([side - half - 0.018, side - half, side + half, side + half + 0.012], axis=1),
        z=np.stack([lift - high - 0.013, lift - high, lift + high, lift + high + 0.008], axis=1),
        filled=np.zeros((len(x) - 1, 3, 3), dtype=bool),
        cells=((2, 2, 2, 2, 2, 2, 2, 2, 2), (2, 2, 2), (2, 2, 2)),
        clamp=0.020,
    )
    solid.filled[:, 1, 1] = True
    # Wing and arm, legs, the left one with a foot, crests, horns.
    for block in ((3, 0, 1), (6, 0, 1), (6, 0, 0), (4, 2, 1), (3, 1, 0), (6, 1, 0), (2, 1, 2)):
        solid.filled[block] = True
    solid.filled[4, 1, 2] = solid.filled[8, 1, 2] = True
    return solid


BODIES: dict[str, Callable[[], Solid]] = {
    make.__name__: make for make in (notched_finger, spine, dragon, fin_ray, tube, plate, beam)
}


def _blocks(
    name: str,
    x: Sequence[float] | FloatArray,
    y: Sequence[float],
    z: Sequence[float],
    cells: tuple[tuple[int, ...], tuple[int, ...], tuple[int, ...]],
) -> Solid:
    """Fill all blocks between faces that do not change along x; the first section is held."""
    breaks = np.asarray(x, dtype=np.float64)
    filled = np.ones((len(breaks) - 1, len(y) - 1, len(z) - 1), dtype=bool)
    tables = _same(y, len(breaks)), _same(z, len(breaks))
    return Solid(name, breaks, *tables, filled, cells, float(breaks[1]))


def _row(clamp: float, pieces: Sequence[tuple[float, str]]) -> tuple[FloatArray, tuple[str, ...]]:
    """Put pieces of a length [m] and a kind one after the other, behind the held section."""
    lengths = [clamp, *(length for length, _ in pieces)]
    return np.concatenate([[0.0], np.cumsum(lengths)]), ('clamp', *(kind for _, kind in pieces))


def _same(faces: Sequence[float], count: int) -> FloatArray:
    return np.tile(np.asarray(faces, dtype=np.float64), (count, 1))
