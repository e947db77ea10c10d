# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where a step of depth lies that is too small to be seen in the residual as it stands.

Modulus and pose follow a step of a few millimetres, and what they leave is bent. Scores take out
what they may have followed; they need a floor that was measured.
"""

from collections.abc import Sequence
from dataclasses import replace

from diffcal_ros.diagnosis.detection.material_boundary import (
    faces_beyond,
    knows_border,
    outstanding_border,
)
from diffcal_ros.diagnosis.model_comparison.refit import Refit
from diffcal_ros.diagnosis.patches.evidence import Evidence
from diffcal_ros.diagnosis.patches.patch_group import Block
from diffcal_ros.diagnosis.patches.patches import averaged_by_cell, cell_numbers
from diffcal_ros.diagnosis.patches.whitened import Part, tangent_slack, whiten
from diffcal_ros.diagnosis.screening.regularised_prior import full_prior
from diffcal_ros.diagnosis.screening.screening import Projection
from diffcal_ros.effects.registry import seen_border
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

# A step stands out when it explains so much chi-square, too.
_LEAST_GAIN = 30.0
# A modulus that has followed a higher step is so far off that tangents there mislead [m].
_HIGHEST = 0.003


def small_step(evidence: Evidence, nominal: Refit) -> float | None:
    """Return the share of the free length at which a step of depth begins; None where none does.

    Args:
        evidence: of the nominal model.
        nominal: its fit.
    """
    if knows_border(evidence.model.scene) or not evidence.is_measured:
        return None
    borders = faces_beyond(evidence)
    blocks = with_steps(evidence, nominal, list(borders.values()))
    gains, heights, whole = step_gains(blocks, nominal)
    at = outstanding_border(dict(zip(borders, (whole - gains).tolist(), strict=True)), whole)
    best = int(gains.argmax())
    return at if gains[best] >= _LEAST_GAIN and abs(heights[best]) <= _HIGHEST else None


def step_gains(blocks: Sequence[Block], nominal: Refit) -> tuple[FloatArray, FloatArray, float]:
    """Return what each step of depth explains of chi-square, its height [m], and all there is.

    Gains and heights have shape (s,). What modulus, pose and a bias of the whole body may have
    followed is taken out first.

    Args:
        blocks: with the columns of `with_steps`.
        nominal: fit, whose parameters have the columns before those.
    """
    count = len(nominal.coordinates)
    seen = whiten(blocks, Part.FIT, tangent_slack(blocks))
    _, precision = full_prior(nominal.parameters)
    # Of a bias of the whole body nothing is known beforehand.
    project = Projection(seen.jacobian[:, : count + 1], np.pad(precision, (0, 1)))
    residual, columns = project(seen.values), project(seen.jacobian[:, count + 1 :])
    (step,) = seen_border().components
    heights = columns.T @ residual / ((columns**2).sum(axis=0) + 1.0 / step.scale**2)
    return heights * (columns.T @ residual), heights, float(residual @ residual)


def with_steps(evidence: Evidence, nominal: Refit, beyond: Sequence[BoolArray]) -> list[Block]:
    """Return a fit's patches with more columns: of the whole body's bias, then of each step's.

    Args:
        evidence: of the nominal model.
        nominal: its fit.
        beyond: triangles of the surface beyond each step, shape (F,) each.
    """
    views = evidence.model.views(nominal.coordinates)
    compared = evidence.comparisons(nominal.coordinates)
    parts = [np.ones_like(beyond[0]), *beyond]
    blocks = []
    for block in nominal.blocks:
        shares = np.zeros((len(block.patches.values), len(parts)))
        if block.kind == 'depth' and not block.is_rigid:
            depth = compared[block.view].depth
            shown = views[block.view].trace.faces.ravel()[depth.places]
            numbers = cell_numbers(depth.pixels, evidence.cell)
            on_part = np.stack([triangles[shown] for triangles in parts], axis=1)
            _, means, _, cells, _ = averaged_by_cell(
                depth, on_part.astype(np.float64), numbers, np.ones(len(numbers)), 0.0
            )
            shares = means[np.searchsorted(cells, block.patches.cells)]
        wide = np.hstack([block.patches.jacobian, shares])
        blocks.append(replace(block, patches=replace(block.patches, jacobian=wide)))
    return blocks
