# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A fitted field as a file for ParaView and its like."""

from pathlib import Path

from diffcal_ros.atomic_file import replacing
from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.field.fit import FieldFit
from diffcal_ros.rigid_transform import apply, inverse
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def write_field(path: Path, calibration: Calibration, field: FieldFit) -> None:
    """Write mesh and field as VTK's unstructured grid, whole or not at all.

    Points are the body at rest in the object frame [m]. Cells have `youngs_modulus` [Pa] and
    `log_std_error`, the standard error of its logarithm. Points have `displacement_<posture>`
    [m], turned to the object frame.

    Args:
        path: .vtu file.
        calibration: with the field in its model.
        field: that was fitted.

    Raises:
        InputError: when the file cannot be written.
    """
    import meshio

    mesh = calibration.scene.mesh
    content = meshio.Mesh(
        mesh.rest_positions,
        [('tetra', mesh.tets)],
        point_data=_displacements(calibration),
        cell_data={'youngs_modulus': [field.youngs_modulus], 'log_std_error': [field.log_std]},
    )
    with replacing(path) as fresh:
        meshio.vtu.write(str(fresh), content)


def _displacements(calibration: Calibration) -> dict[str, FloatArray]:
    scene, model = calibration.scene, calibration.model
    model.views(calibration.coordinates)
    moved = {}
    for index, posture in model.bodies.items():
        setup = scene.observations[index]
        vertices = posture.positions(0)[: scene.mesh.vertex_count]
        here = apply(inverse(setup.world_from_object), vertices)
        moved[f'displacement_{setup.name}'] = here - scene.mesh.rest_positions
    return moved
