# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where a jump of depth lies that is too small to be seen in the residual as it stands.

Modulus and pose follow a jump of a few millimetres, and what they leave is bent. Scores take out
what they may have followed; they need a floor that was measured.
"""

from collections.abc import Sequence
from dataclasses import replace

from diffcal_ros.diagnosis.detection.material_boundary import (
    faces_beyond,
    LEAST_STEP,
    outstanding_boundary,
)
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.boundary_strip import knows_boundary
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.patches.patch_group import PatchGroup
from diffcal_ros.diagnosis.patches.patches import averaged_by_cell, cell_numbers
from diffcal_ros.diagnosis.patches.regularised_prior import regularised_prior
from diffcal_ros.diagnosis.patches.whitened import Part, tangent_slack, whiten
from diffcal_ros.diagnosis.screening.projection import Projection
from diffcal_ros.effects.registry import seen_boundary
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

# A jump stands out when it explains so much chi-square, too.
_LEAST_GAIN = 30.0
# A modulus that has followed a higher jump may be so far off that tangents there mislead; such a
# jump is seen as it stands.
_HIGHEST = LEAST_STEP


def find_depth_discontinuity(evaluator: PatchEvaluator, nominal: Refit) -> float | None:
    """Return the share of the free length at which a jump of depth begins; None where none does.

    Args:
        evaluator: of the nominal model.
        nominal: its fit.
    """
    if knows_boundary(evaluator.model.scene) or not evaluator.is_measured:
        return None
    boundaries = faces_beyond(evaluator)
    groups = with_jumps(evaluator, nominal, list(boundaries.values()))
    gains, heights, whole = jump_gains(groups, nominal)
    at = outstanding_boundary(dict(zip(boundaries, (whole - gains).tolist(), strict=True)), whole)
    best = int(gains.argmax())
    return at if gains[best] >= _LEAST_GAIN and abs(heights[best]) <= _HIGHEST else None


def jump_gains(
    groups: Sequence[PatchGroup], nominal: Refit
) -> tuple[FloatArray, FloatArray, float]:
    """Return what each jump of depth explains of chi-square, its height [m], and all there is.

    Gains and heights have shape (s,). What modulus, pose and a bias of the whole body may have
    followed is taken out first.

    Args:
        groups: with the columns of `with_jumps`.
        nominal: fit, whose parameters have the columns before those.
    """
    count = len(nominal.coordinates)
    seen = whiten(groups, Part.FIT, tangent_slack(groups))
    _, precision = regularised_prior(nominal.parameters)
    # Of a bias of the whole body nothing is known beforehand.
    project = Projection(seen.jacobian[:, : count + 1], np.pad(precision, (0, 1)))
    residual, columns = project(seen.values), project(seen.jacobian[:, count + 1 :])
    (jump,) = seen_boundary().components
    heights = columns.T @ residual / ((columns**2).sum(axis=0) + 1.0 / jump.scale**2)
    return heights * (columns.T @ residual), heights, float(residual @ residual)


def with_jumps(
    evaluator: PatchEvaluator, nominal: Refit, beyond: Sequence[BoolArray]
) -> list[PatchGroup]:
    """Return a fit's patches with more columns: of the whole body's bias, then of each jump's.

    Args:
        evaluator: of the nominal model.
        nominal: its fit.
        beyond: triangles of the surface beyond each jump, shape (F,) each.
    """
    views = evaluator.model.views(nominal.coordinates)
    compared = evaluator.comparisons(nominal.coordinates)
    parts = [np.ones_like(beyond[0]), *beyond]
    groups = []
    for group in nominal.groups:
        fractions = np.zeros((len(group.patches.values), len(parts)))
        if group.kind == 'depth' and not group.is_rigid:
            depth = compared[group.view].depth
            shown = views[group.view].trace.faces.ravel()[depth.indices]
            numbers = cell_numbers(depth.pixels, evaluator.cell)
            on_part = np.stack([triangles[shown] for triangles in parts], axis=1)
            _, means, _, cells, _ = averaged_by_cell(
                depth, on_part.astype(np.float64), numbers, np.ones(len(numbers)), 0.0
            )
            fractions = means[np.searchsorted(cells, group.patches.cells)]
        wide = np.hstack([group.patches.jacobian, fractions])
        groups.append(replace(group, patches=replace(group.patches, jacobian=wide)))
    return groups
