# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How far a model is off on patches, in metres, beside what sensor and mesh would give."""

from collections.abc import Sequence
from dataclasses import dataclass

from diffcal_ros.diagnosis.patches.patch_group import of_the_body, PatchGroup, PatchName
from diffcal_ros.diagnosis.patches.whitened import chosen_patches, Part
from diffcal_ros.median_spread import SPREAD_OVER_MEDIAN
import numpy as np

# A residual is clear of the floor from so many times that.
_CLEAR = 2.0
_MOST = 0.8
# Far from where they were taken, tangents hold to a share of the whole.
_TANGENT_ERROR = 0.15
# A single patch says no more about which of two models is nearer [m].
_MOST_TOLD = 0.005


@dataclass(frozen=True)
class PatchGap:
    """How far the model is off on some patches.

    Attributes:
        rms: of the residuals [m].
        median: of their sizes [m].
        most: what four fifths of their sizes stay below [m].
        floor: root mean square of what the sensor's noise alone would give [m].
        mesh: of what the mesh may add [m].
        count: patches.
    """

    rms: float
    median: float
    most: float
    floor: float
    mesh: float
    count: int

    @property
    def whole_floor(self) -> float:
        """What sensor and mesh together would give [m]."""
        return float(np.hypot(self.floor, self.mesh))

    def size(self, *, is_measured: bool) -> float:
        """Return one figure for how far the model is off [m].

        The root mean square where the noise was measured; else what most patches stay below,
        which the few that show a fixture in place of the body do not move.
        """
        return self.rms if is_measured else self.most


def closed_fraction(old: float, new: float, floor: float) -> float:
    """Return which share of a gap above its floor is closed; NaN where it is within the floor.

    Args:
        old: gap before [m].
        new: gap after [m]; below the floor there is nothing left to close.
        floor: what sensor and mesh would give [m].
    """
    if old <= floor:
        return float('nan')
    return (old - max(new, floor)) / (old - floor)


def excess_over(groups: Sequence[PatchGroup], best: Sequence[PatchGroup], part: Part) -> float:
    """Return how much farther off one model is than another, patch by patch [m].

    The mean over patches that both see, each counting for a few millimetres at most: what shows a
    fixture in place of the body is far off in both and says nothing, and a part of the body that
    only one of them meets is not outvoted by the rest, as it would be in a median.

    Args:
        groups: of the one.
        best: of the other.
        part: patches that are compared.
    """
    one, other = residuals_by_patch(groups, part), residuals_by_patch(best, part)
    shared = [name for name in one if name in other]
    if not shared:
        return float('nan')
    differences = np.array([abs(one[name]) - abs(other[name]) for name in shared])
    return float(np.clip(differences, -_MOST_TOLD, _MOST_TOLD).mean())


def residuals_by_patch(groups: Sequence[PatchGroup], part: Part) -> dict[PatchName, float]:
    """Return the residuals of the body's patches of one part [m], by their names."""
    return {
        (group.view, group.kind, int(group.patches.cells[index])): float(
            group.patches.values[index]
        )
        for group in of_the_body(groups)
        for index in chosen_patches(group, part)
    }


def patch_gap(groups: Sequence[PatchGroup], part: Part) -> PatchGap:
    """Measure the gap on the body's patches of one part."""
    groups = of_the_body(groups)
    chosen = [chosen_patches(group, part) for group in groups]
    values = np.concatenate([b.patches.values[w] for b, w in zip(groups, chosen, strict=True)])
    noise = np.concatenate([b.patches.variances[w] for b, w in zip(groups, chosen, strict=True)])
    mesh = np.concatenate([b.mesh[w] for b, w in zip(groups, chosen, strict=True)])
    if len(values) == 0:
        nothing = float('nan')
        return PatchGap(nothing, nothing, nothing, nothing, nothing, 0)
    return PatchGap(
        rms=float(np.sqrt(np.mean(values**2))),
        median=float(np.median(np.abs(values))),
        most=float(np.quantile(np.abs(values), _MOST)),
        floor=float(np.sqrt(np.mean(noise))),
        mesh=float(np.sqrt(np.mean(mesh**2))),
        count=len(values),
    )


def residual_size(groups: Sequence[PatchGroup], part: Part) -> float:
    """Return a robust root mean square of the residuals [m]; 0 within the noise."""
    gap = patch_gap(groups, part)
    size = SPREAD_OVER_MEDIAN * gap.median
    return size if size > _CLEAR * gap.whole_floor else 0.0


def tangent_slack(groups: Sequence[PatchGroup]) -> float:
    """Return the further error of each patch [m] that tangents at a fit must be allowed."""
    return _TANGENT_ERROR * residual_size(groups, Part.FIT)
