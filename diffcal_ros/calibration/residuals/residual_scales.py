# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How residuals are weighed: the width of the robust cost, noise, and how many say the same."""

from collections.abc import Sequence
from dataclasses import dataclass

from diffcal_ros.calibration.residuals.robust_residual import Reach, ResidualKind, Residuals
from diffcal_ros.median_spread import median_spread
import numpy as np

# Structure that no model explains is taken for this coarse [px] until the residuals tell.
LONGEST_CORRELATION = 30.0
# Robust widths shrink to this: the structured bias of a LIDAR on a soft body [m].
FINAL_WIDTH = 0.0015
_WIDEST = 0.020
_NARROWING = 0.5
# The widths follow this quantile of the residuals: an outline that is off moves few of them.
_BULK = 0.8
# Width of the robust weights in units of the noise, once that is known (95 % efficiency).
_CAUCHY = 2.385
WIDE_REACH = Reach(depth=0.060, edge_depth=0.060, edge_pixels=80)


@dataclass(frozen=True)
class Scale:
    """How residuals of one kind are weighed.

    Attributes:
        width: residuals well beyond this weigh little [m].
        noise: standard deviation of one residual [m].
        correlation: length over which residuals say the same [px].
        repeats: frames of a recording that say the same.
    """

    width: float = _WIDEST
    noise: float = _WIDEST
    correlation: float = LONGEST_CORRELATION
    repeats: float = 1.0

    def patch(self, dimension: int) -> float:
        """Return how many residuals are worth one independent residual.

        Args:
            dimension: 2 for pixels, 1 for segments of outline.
        """
        return float(self.repeats * self.correlation**dimension)

    def annealed(self, groups: Sequence[Residuals]) -> 'Scale':
        """Return a scale that follows the residuals down to the final width.

        Args:
            groups: of residuals; the group that is off most decides. Frames of a motion that fit
                already, such as those before the release, say nothing of the others.
        """
        bulk = max((_bulk(group) for group in groups), default=0.0)
        width = max(FINAL_WIDTH, min(bulk, _NARROWING * self.width))
        return Scale(width=width, noise=width, correlation=self.correlation)

    def refined(self, noise: float, correlation: float, repeats: float) -> 'Scale':
        """Return the scale of residuals whose noise and correlation are known."""
        return Scale(
            width=_CAUCHY * noise,
            noise=noise,
            correlation=min(self.correlation, correlation),
            repeats=repeats,
        )


@dataclass(frozen=True)
class Scales:
    """Scales of both kinds, how far to look, and how firmly placements hold.

    Attributes:
        depth: of depths.
        edge: of outlines.
        reach: how far from the simulated body the measured one is looked for.
        leeway: standard deviations of placement and camera poses count so many times, until
            residuals have told their noise.
    """

    depth: Scale = Scale()
    edge: Scale = Scale()
    reach: Reach = WIDE_REACH
    leeway: float = 1.0

    def of(self, kind: ResidualKind) -> Scale:
        """Return how residuals of one kind are weighed."""
        return self.depth if kind is ResidualKind.DEPTH else self.edge

    @property
    def are_final(self) -> bool:
        """Tell whether the widths have shrunk to the end."""
        return max(self.depth.noise, self.edge.noise) <= FINAL_WIDTH


def spread(residuals: Residuals) -> float:
    """Return the robust standard deviation around zero [m]."""
    if len(residuals.values) == 0:
        return 0.0
    return median_spread(residuals.values)


def _bulk(residuals: Residuals) -> float:
    if len(residuals.values) == 0:
        return 0.0
    return float(np.quantile(np.abs(residuals.values), _BULK))
