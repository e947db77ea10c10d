# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What patches of a model are evaluated by, found around a fit of it."""

from collections import Counter

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.observations.observation import pose_owners
from diffcal_ros.calibration.residuals.robust_residual import make_comparers
from diffcal_ros.diagnosis.patches.boundary_strip import BoundaryStrip, knows_boundary
from diffcal_ros.diagnosis.patches.discretisation_error import find_discretisation_error
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.patches.patch_group import strange_patches
from diffcal_ros.diagnosis.patches.patches import cell_size
from diffcal_ros.diagnosis.patches.rigid_reference import make_references
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def make_patch_evaluator(model: ForwardModel, coordinates: FloatArray) -> PatchEvaluator:
    """Prepare to evaluate patches around a nominal fit."""
    comparers = make_comparers(model)
    discretisation_error = find_discretisation_error(model, coordinates)
    views = model.views(coordinates)
    pixels = [int(np.isfinite(view.trace.depth).sum()) for view in views]
    frames = max(Counter(pose_owners(model.observations)).values())
    cell = cell_size(int(np.median(pixels)), frames)
    evaluator = PatchEvaluator(
        model,
        comparers,
        discretisation_error,
        cell,
        references=make_references(model),
        strip=BoundaryStrip(model, comparers) if knows_boundary(model.scene) else None,
    )
    evaluator = evaluator.without(strange_patches(evaluator.groups(coordinates)))
    return evaluator.with_measured_noise(coordinates)
