# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A fitted field as a file for ParaView and its like."""

from pathlib import Path

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.field.fit import FieldFit
from diffcal_ros.rigid_transform import apply, inverse
from diffcal_ros.scene.sections.modulus_field import write_modulus_field
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def write_field(path: Path, calibration: Calibration, field: FieldFit) -> None:
    """Write mesh and field as VTK's unstructured grid, whole or not at all.

    Points are the body at rest in the object frame [m]. Cells have `youngs_modulus` [Pa],
    `log_std_error`, the standard error of its logarithm, and `relative_modulus`, which a scene
    reads: the modulus over its region's, effects of the model left aside. Points have
    `displacement_<posture>` [m], turned to the object frame.

    Args:
        path: .vtu file.
        calibration: with the field in its model.
        field: that was fitted.

    Raises:
        InputError: when the file cannot be written.
    """
    write_modulus_field(
        path,
        calibration.scene.mesh,
        field.relative_modulus,
        cells={'youngs_modulus': field.youngs_modulus, 'log_std_error': field.log_std},
        points=_displacements(calibration),
    )


def _displacements(calibration: Calibration) -> dict[str, FloatArray]:
    scene, model = calibration.scene, calibration.model
    moved = {}
    for index, states in model.at(calibration.coordinates).states.items():
        setup = scene.observations[index]
        vertices = states.positions[0][: scene.mesh.vertex_count]
        here = apply(inverse(setup.world_from_object), vertices)
        moved[f'displacement_{setup.name}'] = here - scene.mesh.rest_positions
    return moved
