# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bodies that are no bars with one clamped end: hollow, slotted, branched, held amid or twice.

Their blocks have so many cells each, whatever their size: meshes scale along. Object frame: x runs
from a clamp outwards, and all that is held lies along it, z is the thinner way of flat ones.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from benchmarks.blind.shapes import FloatArray, Shape

Counts = tuple[tuple[int, ...], tuple[int, ...], tuple[int, ...]]
Box = tuple[tuple[float, float], tuple[float, float], tuple[float, float]]

_SAME = 1e-9  # Places that are as near are the same [m].


@dataclass(frozen=True)
class OtherShape(Shape):
    """A body of another kind.

    Attributes:
        counts: hexahedra of each block along x, y and z.
        tet_counts: cells of six tetrahedra, likewise.
        free: free length that sizes are shares of [m].
        held: boxes that are held, lowest and highest x, y and z [m].
        arms: where arc positions run to: `ahead` to the end, `both` ways from amid the body,
            `between` two clamps, 1 in the middle, or ahead from two `feet`.
        elbow: begin and end of a bend along x [m], and its angle, from x towards y [rad].
    """

    counts: Counts = ((1,), (1,), (1,))
    tet_counts: Counts = ((1,), (1,), (1,))
    free: float = 0.0
    held: tuple[Box, ...] = ()
    arms: str = 'ahead'
    elbow: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @property
    def section(self) -> tuple[float, float]:
        """Width along y and height along z of all of the body before it is bent [m]."""
        return self.breaks[1][-1] - self.breaks[1][0], self.breaks[2][-1] - self.breaks[2][0]

    @property
    def size(self) -> float:
        """Largest extent at rest [m]."""
        points = self.corners()
        return float((points.max(axis=0) - points.min(axis=0)).max())

    def corners(self) -> FloatArray:
        """Return corners of the cells of the body at rest [m], shape (P, 3)."""
        ways = [np.unique(np.linspace(low, high, 25)) for low, high in self._limits()]
        grid = np.stack(np.meshgrid(*ways, indexing='ij'), axis=-1).reshape(-1, 3)
        return self.place(grid)

    def _limits(self) -> list[tuple[float, float]]:
        return [(way[0], way[-1]) for way in self.breaks]

    def is_held(self, lattice: FloatArray) -> NDArray[np.bool_]:
        """Tell which lattice points are in a clamp, shape (...) of (..., 3)."""
        found = np.zeros(lattice.shape[:-1], dtype=bool)
        for box in self.held:
            low, high = np.array(box).T
            found |= ((lattice >= low - _SAME) & (lattice <= high + _SAME)).all(axis=-1)
        return found

    def goes_on(self, box: Box, axis: int, side: int) -> bool:
        """Tell whether there is more of a body beyond a side of a box, -1 or 1 along an axis."""
        within = [
            slice(*np.searchsorted(way, [low + _SAME, high - _SAME], 'right') - [1, 0])
            for way, (low, high) in zip(self.breaks, box, strict=True)
        ]
        beyond = within[axis].stop if side > 0 else within[axis].start - 1
        if not 0 <= beyond < self.solid.shape[axis]:
            return False
        within[axis] = slice(beyond, beyond + 1)
        return bool(self.solid[tuple(within)].any())

    def touches_itself(self, lattice: FloatArray, places: FloatArray) -> bool:
        """Tell whether parts that the lattice has far apart come near each other; none here do.

        Args:
            lattice: nodes before the map [m], shape (N, 3).
            places: where they are [m], shape (N, 3).
        """
        return False

    def arc_share(self, lattice: FloatArray) -> FloatArray:
        """Return the share of the free length at which lattice points lie, 0 in a clamp."""
        x, end = lattice[..., 0], self.length
        ahead = (x - self.clamp) / (end - self.clamp)
        if self.arms == 'both':
            # What is held begins at 0.
            ahead = np.maximum(ahead, x / self.breaks[0][0])
        if self.arms == 'between':
            half = 0.5 * end - self.clamp
            ahead = np.minimum(x - self.clamp, end - self.clamp - x) / half
        return np.clip(ahead, 0.0, 1.0)

    def place(self, lattice: FloatArray) -> FloatArray:
        """Map lattice points to the body at rest, object frame [m], shape (..., 3)."""
        return bent_elbow(super().place(lattice), *self.elbow)

    def finer(self, refinement: float) -> Counts:
        """Return the hexahedra of each block where they are so many times smaller."""
        x, y, z = (
            tuple(max(round(refinement * count), 1) for count in way) for way in self.counts
        )
        return x, y, z


def bent_elbow(points: FloatArray, begin: float, end: float, angle: float) -> FloatArray:
    """Bend a body to an arc between two places, and leave what is beyond straight.

    Args:
        points: object frame [m], shape (..., 3).
        begin: of the arc, along x [m].
        end: of it along the centre line.
        angle: from x towards y [rad].
    """
    if angle == 0.0:
        return points
    radius, along = (end - begin) / angle, points[..., 0] - begin
    turned = np.clip(along / radius, 0.0, angle)
    beyond = np.maximum(along - (end - begin), 0.0)
    inward = radius - points[..., 1]
    x = begin + np.minimum(along, 0.0) + inward * np.sin(turned) + beyond * np.cos(turned)
    y = radius - inward * np.cos(turned) + beyond * np.sin(turned)
    return np.stack([x, y, points[..., 2]], axis=-1)


def block_shape(
    make: type[OtherShape],
    family: str,
    breaks: tuple[list[float], list[float], list[float]],
    empty: tuple[tuple[int, int, int], ...],
    counts: Counts,
    tet_counts: Counts,
    **more: object,
) -> OtherShape:
    """Make a body from its blocks' faces, those that are empty and their cells.

    Unless more is said it is held up to the second face along x.
    """
    x, y, z = (tuple(float(place) for place in way) for way in breaks)
    solid = np.ones((len(x) - 1, len(y) - 1, len(z) - 1), dtype=bool)
    for block in empty:
        solid[block] = False
    known: dict[str, object] = {
        'clamp': x[1],
        'free': x[-1] - x[1],
        'held': (((x[0], x[1]), (y[0], y[-1]), (z[0], z[-1])),),
    }
    return make(
        family,
        (x, y, z),
        solid,
        counts=counts,
        tet_counts=tet_counts,
        **{**known, **more},  # type: ignore[arg-type]
    )


_shape = partial(block_shape, OtherShape)


def middle(width: float) -> list[float]:
    return [-0.5 * width, 0.5 * width]


def walls(width: float, wall: float) -> list[float]:
    half = 0.5 * width
    return [-half, wall - half, half - wall, half]


def _tube(size: float, random: np.random.Generator) -> OtherShape:
    """Draw a closed square tube, filled where it is held and closed by a cap."""
    width, clamp = random.uniform(0.16, 0.22) * size, random.uniform(0.16, 0.22) * size
    wall = random.uniform(0.14, 0.2) * width
    side = walls(width, wall)
    x = [0.0, clamp, size - 1.5 * wall, size]
    cells, tets = ((1, 12, 1), (1, 2, 1), (1, 2, 1)), ((2, 8, 1), (2, 2, 2), (2, 2, 2))
    return _shape('tube', (x, side, list(side)), ((1, 1, 1),), cells, tets)


def _slotted(size: float, random: np.random.Generator) -> OtherShape:
    """Draw a finger with five slots in its upper side."""
    width, height, clamp = (random.uniform(*ends) * size for ends in ((0.15, 0.22),) * 3)
    floor = random.uniform(0.35, 0.45) * height
    slot = random.uniform(0.4, 0.6) * (size - clamp) / 6.0
    rib = (size - clamp - 5.0 * slot) / 6.0
    steps = [clamp, rib, *([slot, rib] * 5)]
    x = [0.0, *(float(place) for place in np.cumsum(steps))]
    z = [-0.5 * height, floor - 0.5 * height, 0.5 * height]
    empty = tuple((block, 0, 1) for block in range(2, 12, 2))
    cells = ((1, 1, *((2, 1) * 5)), (3,), (2, 2))
    tets = ((2, 1, *((2, 1) * 5)), (4,), (2, 2))
    return _shape('slotted', (x, middle(width), z), empty, cells, tets)


def _window(size: float, random: np.random.Generator) -> OtherShape:
    """Draw a frame: two webs beside a window through the body."""
    width, height = random.uniform(0.35, 0.5) * size, random.uniform(0.07, 0.1) * size
    web, clamp = random.uniform(0.2, 0.26) * width, random.uniform(0.14, 0.18) * size
    x = [0.0, clamp, clamp + 0.08 * size, size - web, size]
    cells, tets = ((1, 1, 9, 2), (2, 3, 2), (3,)), ((2, 1, 9, 2), (3, 3, 3), (2,))
    z = middle(height)
    return _shape('window', (x, walls(width, web), z), ((2, 1, 0),), cells, tets)


def _hand(size: float, random: np.random.Generator) -> OtherShape:
    """Draw a palm with three prongs, the middle one longer."""
    width, height = random.uniform(0.4, 0.55) * size, random.uniform(0.08, 0.11) * size
    gap, clamp = random.uniform(0.1, 0.15) * width, random.uniform(0.14, 0.18) * size
    prong = (width - 2.0 * gap) / 3.0
    y = [-0.5 * width, *np.cumsum([prong - 0.5 * width, gap, prong, gap]), 0.5 * width]
    x = [0.0, clamp, clamp + random.uniform(0.12, 0.2) * size, 0.86 * size, size]
    gaps = ((2, 1, 0), (2, 3, 0), (3, 1, 0), (3, 3, 0))
    cells, tets = ((1, 2, 7, 2), (2, 1, 2, 1, 2), (3,)), ((2, 2, 8, 2), (2, 1, 2, 1, 2), (2,))
    empty = (*gaps, (3, 0, 0), (3, 4, 0))
    return _shape('hand', (x, [float(v) for v in y], middle(height)), empty, cells, tets)


def _elbow(size: float, random: np.random.Generator) -> OtherShape:
    """Draw a bar whose centre line turns by 80 to 100 degrees."""
    line, angle = size / 0.645, float(np.deg2rad(random.uniform(80.0, 100.0)))
    width, height = random.uniform(0.1, 0.13, 2) * line
    x = [float(share) * line for share in (0.0, random.uniform(0.13, 0.17), 0.42, 0.68, 1.0)]
    cells, tets = ((1, 4, 7, 5), (3,), (3,)), ((2, 4, 8, 5), (4,), (3,))
    more = {'elbow': (x[2], x[3], angle)}
    return _shape('elbow', (x, middle(width), middle(height)), (), cells, tets, **more)


def _whip(size: float, random: np.random.Generator) -> OtherShape:
    """Draw a body that is twenty times as long as thick."""
    clamp = 0.14 * size
    side = middle((size - clamp) / 20.0 * random.uniform(0.95, 1.05))
    cells, tets = ((1, 26), (2,), (2,)), ((2, 36), (2,), (2,))
    return _shape('whip', ([0.0, clamp, size], side, list(side)), (), cells, tets)


def _stub(size: float, random: np.random.Generator) -> OtherShape:
    """Draw a body that is two and a half times as long as thick."""
    clamp = 0.28 * size
    width, height = (size - clamp) / 2.5 * random.uniform(0.92, 1.08, 2)
    cells, tets = ((1, 8), (4,), (4,)), ((3, 7), (5,), (5,))
    return _shape('stub', ([0.0, clamp, size], middle(width), middle(height)), (), cells, tets)


def _sheet(size: float, random: np.random.Generator) -> OtherShape:
    """Draw a sheet of 3 to 4 mm."""
    clamp, width = 0.18 * size, random.uniform(0.45, 0.7) * size
    height = random.uniform(0.003, 0.004)
    cells, tets = ((1, 13), (8,), (2,)), ((2, 12), (7,), (2,))
    return _shape('sheet', ([0.0, clamp, size], middle(width), middle(height)), (), cells, tets)


def _wings(size: float, random: np.random.Generator) -> OtherShape:
    """Draw a bar that is held amid its length, with two arms that are not as long."""
    clamp, arm = 0.2 * size, random.uniform(0.34, 0.39) * size
    width, height = random.uniform(0.12, 0.16) * size, random.uniform(0.1, 0.14) * size
    x, y, z = [-arm, 0.0, clamp, size - arm], middle(width), middle(height)
    held = (((0.0, clamp), (y[0], y[1]), (z[0], z[1])),)
    cells, tets = ((10, 1, 10), (3,), (3,)), ((9, 2, 9), (4,), (3,))
    more = {'clamp': clamp, 'free': size - arm - clamp, 'held': held, 'arms': 'both'}
    return _shape('wings', (x, y, z), (), cells, tets, **more)


def _portal(size: float, random: np.random.Generator) -> OtherShape:
    """Draw two legs that are held at their feet, and a beam from one to the other."""
    width, height = random.uniform(0.8, 1.0) * size, random.uniform(0.1, 0.14) * size
    leg, clamp = random.uniform(0.14, 0.18) * width, random.uniform(0.15, 0.2) * size
    x, y, z = [0.0, clamp, size - leg, size], walls(width, leg), middle(height)
    feet = [((0.0, clamp), ends, (z[0], z[1])) for ends in ((y[0], y[1]), (y[2], y[3]))]
    cells, tets = ((1, 8, 2), (2, 6, 2), (3,)), ((2, 8, 2), (2, 8, 2), (3,))
    more = {'held': tuple(feet), 'free': size - clamp + 0.5 * width}
    return _shape('portal', (x, y, z), ((0, 1, 0), (1, 1, 0)), cells, tets, **more)


def _bridge(size: float, random: np.random.Generator) -> OtherShape:
    """Draw a bar that is held at both ends."""
    clamp, width = random.uniform(0.12, 0.16) * size, random.uniform(0.1, 0.14) * size
    x, y = [0.0, clamp, size - clamp, size], middle(width)
    z = middle(random.uniform(0.045, 0.07) * size)
    ends = [(along, (y[0], y[1]), (z[0], z[1])) for along in ((0.0, clamp), (x[2], x[3]))]
    cells, tets = ((1, 20, 1), (3,), (3,)), ((2, 22, 2), (3,), (2,))
    more = {'held': tuple(ends), 'free': x[2] - x[1], 'arms': 'between'}
    return _shape('bridge', (x, y, z), (), cells, tets, **more)


@dataclass(frozen=True)
class Family:
    """A kind of body.

    Attributes:
        draw: by its size [m].
        sizes: smallest and largest [m].
        sags: share of its free length by which it sags, least and most.
        is_flat: whether z is to be seen by the camera.
    """

    draw: Callable[[float, np.random.Generator], OtherShape]
    sizes: tuple[float, float]
    sags: tuple[float, float]
    is_flat: bool = False


OTHER_FAMILIES = {
    'tube': Family(_tube, (0.060, 0.400), (0.04, 0.20)),
    'slotted': Family(_slotted, (0.045, 0.350), (0.04, 0.25)),
    'window': Family(_window, (0.060, 0.300), (0.04, 0.25), is_flat=True),
    'hand': Family(_hand, (0.060, 0.260), (0.04, 0.25), is_flat=True),
    'elbow': Family(_elbow, (0.045, 0.400), (0.04, 0.25)),
    # A long one that is thin must be of a stiff rubber.
    'whip': Family(_whip, (0.140, 0.260), (0.10, 0.25)),
    'stub': Family(_stub, (0.045, 0.250), (0.03, 0.20)),
    'sheet': Family(_sheet, (0.055, 0.110), (0.08, 0.25), is_flat=True),
    'wings': Family(_wings, (0.060, 0.400), (0.04, 0.25)),
    'portal': Family(_portal, (0.060, 0.300), (0.03, 0.15), is_flat=True),
    'bridge': Family(_bridge, (0.090, 0.400), (0.03, 0.08)),
}


def draw_other_shape(
    family: str, random: np.random.Generator, families: Mapping[str, Family] = OTHER_FAMILIES
) -> OtherShape:
    """Draw a body of a family, whose sizes are alike by their logarithms."""
    kind = families[family]
    return kind.draw(float(np.exp(random.uniform(*np.log(kind.sizes)))), random)
