# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What differs from frame to frame, found in the frames that no fit has seen as well.

Stamps that scatter say nothing of the next one. How late a frame is that is held out, every second
of its patches tells, on all of which it is one number; the others say whether the frame is
explained by it.
"""

from collections.abc import Sequence

from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.patch_gap import patch_gap, PatchGap
from diffcal_ros.diagnosis.patches.patch_group import moved, PatchGroup
from diffcal_ros.diagnosis.patches.patches import cell_places
from diffcal_ros.diagnosis.patches.whitened import Part
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


def told_frame_by_frame(groups: Sequence[PatchGroup], fit: Refit) -> list[PatchGroup]:
    """Return patches with what only frames that are held out tell found in those, to first order.

    Patches by which it was found are left out.

    Args:
        groups: of a fit.
        fit: of a model; what no fitted patch sees of it is where its prior has it.
    """
    unseen = _unseen(groups, fit)
    if not unseen:
        return list(groups)
    frames = {g.view for j in unseen for g in groups if g.patches.jacobian[:, j].any()}
    step = np.zeros(len(fit.coordinates))
    for index in unseen:
        step[index] = _found(groups, fit, index)
    return [g.chosen(~_used(g)) if g.view in frames else g for g in moved(groups, step)]


def gap_frame_by_frame(fit: Refit, part: Part = Part.REPORT) -> PatchGap:
    """Return the gap that a fit leaves on patches of a part; see `told_frame_by_frame`."""
    return patch_gap(told_frame_by_frame(fit.groups, fit), part)


def _unseen(groups: Sequence[PatchGroup], fit: Refit) -> list[int]:
    """Return places of parameters of single times that patches of held-out frames alone see."""
    return [
        index
        for index, own in enumerate(fit.parameters)
        if own.knot is not None
        and any(g.patches.jacobian[g.is_report, index].any() for g in groups)
        and not any(g.patches.jacobian[~g.is_report, index].any() for g in groups)
    ]


def _found(groups: Sequence[PatchGroup], fit: Refit, index: int) -> float:
    """Return what one parameter is by half of the patches that see it, and by its prior."""
    std = fit.parameters.parameters[index].quantity.prior_std
    told, precision = 0.0, 0.0 if std is None else 1.0 / std**2
    for group in groups:
        used, patches = _used(group), group.patches
        slope, weight = patches.jacobian[used, index], 1.0 / patches.variances[used]
        told += float(slope @ (weight * patches.values[used]))
        precision += float(slope @ (weight * slope))
    return told / precision


def _used(group: PatchGroup) -> BoolArray:
    """Tell by which patches something is found: every second one, as on a chessboard."""
    rows, columns = cell_places(group.patches.cells)
    return np.asarray((rows + columns) % 2 == 0) & group.is_report
