# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body whose lattice is tapered, rounded, twisted or bent to arcs.

Its centre line, straight in the lattice, is bent in the plane of x and y, or of x and z.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from benchmarks.blind.other_bodies import bent_elbow, OtherShape
from benchmarks.blind.shapes import FloatArray, rounding

Arc = tuple[float, float, float]

_NEAR = 0.03  # Share of the size: places that are as near are to be near before a bend.
_NEAR_BEFORE = 5.0  # Over that.


@dataclass(frozen=True)
class FurtherShape(OtherShape):
    """A body whose lattice is tapered, rounded, twisted or bent.

    Attributes:
        arcs: begin and end along x [m] and angle, from x towards y [rad], the outer one first.
        back_arcs: the same of what lies behind a clamp, as if it lay ahead.
        is_upright: whether arcs go from x towards z.
        round: share by which the section is not square but round.
        level: whether the upper side stays level where the height falls.
        twist: turn about x at the far end [rad].
        disc: begin along x, half the width [m] and roundness of a square that becomes a disc.
        crossing: lowest and highest y of what is held of a cross [m].
    """

    arcs: tuple[Arc, ...] = ()
    back_arcs: tuple[Arc, ...] = ()
    is_upright: bool = False
    round: float = 0.0
    level: bool = False
    twist: float = 0.0
    disc: tuple[float, float, float] = (0.0, 1.0, 0.0)
    crossing: tuple[float, float] | None = None

    def arc_share(self, lattice: FloatArray) -> FloatArray:
        """Return the share of the free length at which lattice points lie, 0 in a clamp."""
        if self.crossing is None:
            return super().arc_share(lattice)
        (low, high), y = self.crossing, self.breaks[1]
        x, across = lattice[..., 0], lattice[..., 1]
        ahead = np.maximum((x - self.clamp) / (self.length - self.clamp), x / self.breaks[0][0])
        aside = np.maximum((across - high) / (y[-1] - high), (low - across) / (low - y[0]))
        return np.clip(np.maximum(ahead, aside), 0.0, 1.0)

    def place(self, lattice: FloatArray) -> FloatArray:
        """Map lattice points to the body at rest, object frame [m], shape (..., 3)."""
        share, points = self.arc_share(lattice), super().place(lattice)
        if self.level:
            points[..., 2] += 0.5 * self.taper[1] * share * self.section[1]
        if self.round:
            across = lattice[..., 1:] / (0.5 * np.array(self.section))
            points[..., 1:] *= 1.0 - self.round * rounding(share, across)
        if self.twist:
            y, z, turn = points[..., 1], points[..., 2], self.twist * share
            turned = (y * np.cos(turn) - z * np.sin(turn), y * np.sin(turn) + z * np.cos(turn))
            points = np.stack([points[..., 0], *turned], axis=-1)
        if self.disc[2]:
            points = _rounded(points, self.clamp, *self.disc)
        order = [0, 2, 1] if self.is_upright else [0, 1, 2]
        ahead, mirror = points[..., order], np.array([-1.0, 1.0, 1.0])
        behind = ahead * mirror + [self.clamp, 0.0, 0.0]
        for arc in self.arcs:
            ahead = curved(ahead, *arc)
        for arc in self.back_arcs:
            behind = curved(behind, *arc)
        behind = (behind - [self.clamp, 0.0, 0.0]) * mirror
        found = np.where(lattice[..., :1] < 0.0, behind, ahead)[..., order]
        return np.asarray(found)

    def touches_itself(self, lattice: FloatArray, places: FloatArray) -> bool:
        """Tell whether parts come near each other that the lattice has far apart."""
        near = _NEAR * self.size
        one, two = cKDTree(places).query_pairs(near, output_type='ndarray').T
        apart = np.linalg.norm(lattice[one] - lattice[two], axis=1)
        return bool((apart > _NEAR_BEFORE * near).any())


def curved(points: FloatArray, begin: float, end: float, angle: float) -> FloatArray:
    """Bend a body to an arc, from x towards y or, below 0, away from that."""
    sides = np.array([1.0, np.sign(angle), 1.0])
    return bent_elbow(points * sides, begin, end, abs(angle)) * sides


def _rounded(
    points: FloatArray, clamp: float, begin: float, half: float, roundness: float
) -> FloatArray:
    """Make a disc of a square, and let a stem before it go along [m], shape (..., 3)."""
    u = np.maximum((points[..., 0] - begin) / half - 1.0, -1.0)
    v = points[..., 1] / half
    largest, far = np.maximum(np.abs(u), np.abs(v)), np.maximum(np.hypot(u, v), 1e-12)
    ramp = np.clip((points[..., 0] - clamp) / (begin - clamp), 0.0, 1.0) ** 2
    factor = half * roundness * ramp * (largest / far - 1.0)
    return points + np.stack([factor * u, factor * v, 0.0 * factor], axis=-1)
