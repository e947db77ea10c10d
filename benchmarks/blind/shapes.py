# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bodies as blocks of a lattice that a smooth map bends into shape.

Object frame: x runs from the clamp to the tip, the clamp holds 0 <= x <= `clamp`. The map leaves
the held section as it is. Both meshes, the generator's and the one that is handed out, are cut
from the same lattice with different counts.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.blind.bevelling import bevelling
from benchmarks.blind.clubbing import clubbing
from benchmarks.blind.doming import doming
from benchmarks.blind.jogging import jogging
from benchmarks.blind.keeling import keeling
from benchmarks.blind.mitring import mitring

FloatArray = NDArray[np.float64]

_RACKED = 0.15  # Share of the free length over which a racked mould leaves its square end.
_NECK = 0.15  # Share over which a body that was drawn grows thinner.
_HALF_NECK = 0.15  # Share from the middle of a neck to either of its ends.
_BRIM = 0.15  # Share over which a side that is not the stated one comes up from a clamp.


@dataclass(frozen=True)
class Shape:
    """A body.

    Attributes:
        family: name of the kind of shape.
        breaks: coordinates of the lattice's block faces along x, y and z [m].
        solid: which blocks are filled, shape (blocks x, blocks y, blocks z).
        clamp: end of the held section [m].
        taper: share by which width and height are smaller at the tip, shape (2,).
        waist: share by which the section is narrower in the middle.
        arch: curvature of the centre line about z [1/m].
        trimmed: length that is cut off at the tip: what is left keeps its shape [m].
        rack: shift along y over z, which comes up over the first part of the free length.
        drawn: share by which the free length was drawn longer, and its section smaller.
        neck: share by which the section is smaller in the middle of a neck.
        neck_at: share of the free length of that middle.
        dish: share of the height that is lacking amid the upper side, which is hollow.
        flat: share by which the section is wider at the tip, and as much thinner.
        slope: share of the height by which the upper side is higher at the side of positive y, and
            lower at the other.
        draft: share by which the section is wider at the upper side, and narrower at the lower.
        ribs: share by which the section is larger and smaller in waves, how many of these are on
            the free length, and their phase at the clamp [rad].
        rounds: share by which the section is not square but round.
        jog: by how much the outer part lies to one side [m], the share of the free length amid
            the bend where it goes over to that, and which way, from y towards z [deg].
        mitre: by how much the end is shorter at the side of positive y, or below 0 at the other
            one, evenly over all of the width [m].
        club: share by which the section is larger at the tip.
        lack: share of the height that the upper side lacks at the tip, evenly less to the clamp.
        dome: by how much the end's edges lie behind its middle [m].
        keel: by how much a ridge stands out amid the side of positive y [m].
        bevel: by how much the upper edge of positive y is planed off, beyond the clamp [m].
    """

    family: str
    breaks: tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...]]
    solid: NDArray[np.bool_]
    clamp: float
    taper: tuple[float, float] = (0.0, 0.0)
    waist: float = 0.0
    arch: float = 0.0
    trimmed: float = 0.0
    rack: float = 0.0
    drawn: float = 0.0
    neck: float = 0.0
    neck_at: float = 0.0
    dish: float = 0.0
    flat: float = 0.0
    slope: float = 0.0
    draft: float = 0.0
    ribs: tuple[float, float, float] = (0.0, 1.0, 0.0)
    rounds: float = 0.0
    jog: tuple[float, float, float] = (0.0, 0.0, 0.0)
    mitre: float = 0.0
    club: float = 0.0
    lack: float = 0.0
    dome: float = 0.0
    keel: float = 0.0
    bevel: float = 0.0

    @property
    def length(self) -> float:
        """Length along the centre line, held section and what is cut off included [m]."""
        return self.breaks[0][-1] + self.trimmed

    @property
    def section(self) -> tuple[float, float]:
        """Width along y and height along z of the held section [m]."""
        width = next(tuple(self.breaks[1])[i : i + 2] for i in np.flatnonzero(self.solid[0, :, 0]))
        return width[1] - width[0], self.breaks[2][-1] - self.breaks[2][0]

    def is_held(self, lattice: FloatArray) -> NDArray[np.bool_]:
        """Tell which lattice points are in a clamp, shape (...) of (..., 3)."""
        # To the end of the first block, which ends within the clamp where a body slid out.
        return np.asarray(lattice[..., 0] <= self.breaks[0][1] * (1.0 + 1e-9))

    def arc_share(self, lattice: FloatArray) -> FloatArray:
        """Return the share of the free length at which lattice points lie, 0 in the clamp."""
        free = self.length - self.clamp
        return np.clip((lattice[..., 0] - self.clamp) / free, 0.0, 1.0)

    def place(self, lattice: FloatArray) -> FloatArray:
        """Map lattice points to the body at rest, object frame [m], shape (..., 3)."""
        share = self.arc_share(lattice)
        narrow = 1.0 - self.waist * np.sin(np.pi * share) ** 2
        if self.drawn:
            narrow = narrow * (1.0 + self.drawn) ** (-0.5 * np.minimum(share / _NECK, 1.0))
        if self.neck:
            narrow = narrow * (1.0 - self.neck * necking(share, self.neck_at))
        if self.ribs[0]:
            narrow = narrow * (1.0 + self.ribs[0] * ribbing(share, *self.ribs[1:]))
        if self.club:
            narrow = narrow * (1.0 + self.club * clubbing(share))
        points = lattice.copy()
        if self.mitre:
            aside = points[..., 1] / max(abs(place) for place in self.breaks[1])
            points[..., 0] -= abs(self.mitre) * mitring(share, np.sign(self.mitre) * aside)
        points[..., 0] -= self.dome * doming(
            share, points[..., 1:] / (0.5 * np.array(self.section))
        )
        if self.rounds:
            across = points[..., 1:] / (0.5 * np.array(self.section))
            points[..., 1:] *= 1.0 - self.rounds * rounding(share, across)
        if self.dish:
            width, height = self.section
            lacking = self.dish * hollowing(share, points[..., 1] / (0.5 * width))
            points[..., 2] -= lacking * (points[..., 2] + 0.5 * height)
        if self.slope:
            width, height = self.section
            higher = self.slope * sloping(share, points[..., 1] / (0.5 * width))
            points[..., 2] += higher * (points[..., 2] + 0.5 * height)
        if self.lack:
            points[..., 2] -= self.lack * share * (points[..., 2] + 0.5 * self.section[1])
        out = points[..., 1:] / (0.5 * np.array(self.section))
        points[..., 1] += self.keel * keeling(share, out[..., 0], out[..., 1])
        points[..., 2] -= self.bevel * bevelling(share, out[..., 0], out[..., 1])
        if self.draft:
            half_width, half_height = (0.5 * side for side in self.section)
            high = points[..., 2] / half_height
            wider = self.draft * drafting(share, points[..., 1] / half_width, high)
            points[..., 1] += half_width * wider
        points[..., 1] *= (1.0 - self.taper[0] * share) * narrow
        points[..., 2] *= (1.0 - self.taper[1] * share) * narrow
        points[..., 1] *= 1.0 + self.flat * share
        points[..., 2] /= 1.0 + self.flat * share
        points[..., 1] += self.rack * np.minimum(share / _RACKED, 1.0) * points[..., 2]
        if self.jog[0]:
            points[..., 1:] += jogging(share, *self.jog)
        return bend(points, self.clamp, np.array([0.0, 0.0, self.arch]))


def necking(share: FloatArray, at: float) -> FloatArray:
    """Return a bell that is 1 in the middle of a neck and 0 at its ends, none in the clamp.

    Args:
        share: of the free length, any shape.
        at: that of the middle.
    """
    away = np.clip((share - at) / _HALF_NECK, -1.0, 1.0)
    return np.asarray(0.5 * (1.0 + np.cos(np.pi * away)))


def ribbing(share: FloatArray, waves: float, phase: float) -> FloatArray:
    """Return waves of a section's size, -1 to 1, none in the clamp.

    Args:
        share: of the free length, any shape.
        waves: number of them.
        phase: at the clamp [rad].
    """
    return np.asarray(np.minimum(share / _BRIM, 1.0) * np.sin(2.0 * np.pi * waves * share + phase))


def rounding(share: FloatArray, across: FloatArray) -> FloatArray:
    """Return by which shares a round section's places lie nearer to its middle, none in the clamp.

    A square becomes a disk where each place is nearer by the square of the other one (Fong 2015,
    Analytical methods for squaring the disc: the elliptical grid mapping).

    Args:
        share: of the free length, any shape.
        across: -1 and 1 at the sides along y and z; beyond, of a crossbar, it is as there;
            shape (..., 2).
    """
    squares = np.minimum(across[..., ::-1] ** 2, 1.0)
    return np.minimum(share / _BRIM, 1.0)[..., None] * (1.0 - np.sqrt(1.0 - 0.5 * squares))


def hollowing(share: FloatArray, across: FloatArray) -> FloatArray:
    """Return a parabola that is 1 amid a body and 0 at its sides, none in the clamp.

    Args:
        share: of the free length, any shape.
        across: -1 and 1 at the sides; beyond, of a crossbar, there is nothing; that shape.
    """
    return np.asarray(np.minimum(share / _BRIM, 1.0) * np.maximum(1.0 - across**2, 0.0))


def sloping(share: FloatArray, across: FloatArray) -> FloatArray:
    """Return how much higher a liquid stood in a mould that was not level, -1 to 1 at its sides.

    Args:
        share: of the free length, any shape.
        across: -1 and 1 at the sides; beyond, of a crossbar, it is as there; that shape.
    """
    return np.asarray(np.minimum(share / _BRIM, 1.0) * np.clip(across, -1.0, 1.0))


def drafting(share: FloatArray, across: FloatArray, high: FloatArray) -> FloatArray:
    """Return how far out a place lies in a mould with flaring walls, over half the width.

    Args:
        share: of the free length, any shape.
        across: -1 and 1 at the sides; beyond, of a crossbar, it is as there; that shape.
        high: -1 at the lower side and 1 at the upper one, that shape.
    """
    return np.asarray(np.minimum(share / _BRIM, 1.0) * np.clip(across, -1.0, 1.0) * high)


def bend(points: FloatArray, start: float, curvature: FloatArray) -> FloatArray:
    """Bend what lies beyond x = start to a circular arc.

    Args:
        points: object frame [m], shape (..., 3).
        start: where the arc begins [m]; the centre line is y = z = 0.
        curvature: turn per length as a rotation vector [1/m], shape (3,), x component 0.
    """
    size = float(np.linalg.norm(curvature))
    if size == 0.0:
        return points
    axis = curvature / size
    along = np.maximum(points[..., 0] - start, 0.0)
    angle = size * along
    # The section plane's directions: x turns towards `side`, the axis stays.
    ahead = np.array([1.0, 0.0, 0.0])
    side = np.cross(axis, ahead)
    offset = points[..., 1:] @ np.stack([side[1:], axis[1:]], axis=1)
    center = (np.sin(angle) / size)[..., None] * ahead
    center = center + ((1.0 - np.cos(angle)) / size)[..., None] * side
    turned = np.cos(angle)[..., None] * side - np.sin(angle)[..., None] * ahead
    bent = center + offset[..., :1] * turned + offset[..., 1:] * axis
    bent[..., 0] += points[..., 0] - along
    return bent


def _bar(
    family: str, length: float, clamp: float, width: float, height: float, **bending: object
) -> Shape:
    breaks = (
        (0.0, clamp, clamp + length),
        (-0.5 * width, 0.5 * width),
        (-0.5 * height, 0.5 * height),
    )
    return Shape(family, breaks, np.ones((2, 1, 1), dtype=bool), clamp, **bending)  # type: ignore[arg-type]


def _branched(
    family: str,
    length: float,
    clamp: float,
    width: float,
    height: float,
    arms: tuple[float, float],
) -> Shape:
    """Make a bar with a crossbar at its tip: an L with one arm, a T with two."""
    low, high = arms
    y = [-0.5 * width, 0.5 * width]
    main = 0
    if low:
        y.insert(0, -0.5 * width - low)
        main = 1
    if high:
        y.append(0.5 * width + high)
    x = (0.0, clamp, clamp + length - width, clamp + length)
    solid = np.zeros((3, len(y) - 1, 1), dtype=bool)
    solid[:, main] = True
    solid[2] = True
    return Shape(family, (x, tuple(y), (-0.5 * height, 0.5 * height)), solid, clamp)


def draw_shape(family: str, random: np.random.Generator) -> Shape:
    """Draw a shape of a family.

    Args:
        family: one of `FAMILIES`.
        random: source of the sizes.
    """
    length = random.uniform(0.085, 0.120)
    clamp = random.uniform(0.020, 0.028)
    width, height = random.uniform(0.014, 0.022, size=2)
    size = (length, clamp, width, height)
    if family == 'beam':
        return _bar(family, *size)
    if family == 'taper':
        taper = (random.uniform(0.25, 0.45), random.uniform(0.15, 0.40))
        return _bar(family, *size, taper=taper)
    if family == 'plate':
        return _bar(
            family, length, clamp, random.uniform(0.040, 0.055), random.uniform(0.007, 0.010)
        )
    if family == 'hook':
        return _branched(family, *size, (0.0, random.uniform(0.022, 0.034)))
    if family == 'arch':
        return _bar(
            family, *size, arch=float(random.choice([-1.0, 1.0]) * random.uniform(2.5, 5.0))
        )
    if family == 'waist':
        return _bar(family, *size, waist=random.uniform(0.15, 0.30))
    if family == 'fin':
        wide = (random.uniform(0.036, 0.050), random.uniform(0.008, 0.012))
        taper = (random.uniform(0.35, 0.55), random.uniform(0.05, 0.20))
        return _bar(family, length, clamp, *wide, taper=taper)
    if family == 'tee':
        return _branched(
            family, *size, (random.uniform(0.014, 0.020), random.uniform(0.014, 0.02))
        )
    raise ValueError(f'shape family is {family!r}: {", ".join(FAMILIES)}')


FAMILIES = ('beam', 'taper', 'plate', 'hook', 'arch', 'waist', 'fin', 'tee')
DEVELOPMENT_FAMILIES = FAMILIES[:4]
SEALED_FAMILIES = FAMILIES[4:]
