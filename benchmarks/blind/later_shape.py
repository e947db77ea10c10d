# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body whose lattice rises beside its plane, spreads to two arms, or stands on two feet."""

from dataclasses import dataclass

import numpy as np

from benchmarks.blind.further_shape import curved, FurtherShape
from benchmarks.blind.shapes import FloatArray


@dataclass(frozen=True)
class LaterShape(FurtherShape):
    """A body that is bent in two planes, branched, or held at two feet.

    Attributes:
        rise: begin along x and way along z at the far end [m]; it grows with the square of the
            place.
        spread: begin and end along x of the arcs by which two prongs spread, how far aside their
            middle lies [m], and the angles of those of positive and negative y [rad].
        feet: how far aside the inner wall of two legs lies, where along x what is held of that
            of positive y ends, where a beam begins, and by how much that is vaulted amid [m].
    """

    rise: tuple[float, float] = (0.0, 0.0)
    spread: tuple[float, float, float, float, float] = (0.0, 1.0, 0.0, 0.0, 0.0)
    feet: tuple[float, float, float, float] | None = None

    def arc_share(self, lattice: FloatArray) -> FloatArray:
        """Return the share of the free length at which lattice points lie, 0 in a clamp."""
        if self.feet is None:
            return super().arc_share(lattice)
        aside, held = self.feet[:2]
        begin = np.interp(lattice[..., 1], [-aside, aside], [self.clamp, held])
        return np.clip((lattice[..., 0] - begin) / (self.length - begin), 0.0, 1.0)

    def place(self, lattice: FloatArray) -> FloatArray:
        """Map lattice points to the body at rest, object frame [m], shape (..., 3)."""
        points, x = np.array(super().place(lattice)), lattice[..., 0]
        begin, way = self.rise
        points[..., 2] += way * np.clip((x - begin) / (self.length - begin), 0.0, 1.0) ** 2
        if self.feet is not None:
            _, held, beam, vault = self.feet
            amid = 1.0 - (lattice[..., 1] / self.breaks[1][-1]) ** 2
            points[..., 0] += vault * np.clip((x - held) / (beam - held), 0.0, 1.0) * amid
        begin, end, aside, one, other = self.spread
        for sign, angle in ((1.0, one), (-1.0, -other)) if aside else ():
            middle = np.array([0.0, sign * aside, 0.0])
            spread = curved(points - middle, begin, end, angle) + middle
            points = np.where(sign * lattice[..., 1:2] > 0.0, spread, points)
        return points
