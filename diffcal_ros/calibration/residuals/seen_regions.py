# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Refuse to fit the modulus of a part of the body that no camera sees."""

from diffcal_ros.calibration.parameters.parameters import Kind
from diffcal_ros.calibration.residuals.objective import RobustObjective
from diffcal_ros.errors import InputError
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def require_seen_regions(objective: RobustObjective, coordinates: FloatArray) -> None:
    """Check that unmasked pixels show every region whose modulus is fitted.

    Args:
        objective: compares the views.
        coordinates: where the body is looked at, shape (k,).

    Raises:
        InputError: when a region is in no view.
    """
    model = objective.model
    regions = model.scene.regions
    fitted = [p.target for p in model.parameters if p.kind is Kind.YOUNGS_MODULUS]
    if len(regions) == 1 or not fitted:
        return
    pixels = _pixels(objective, coordinates)
    for number in fitted:
        if pixels[number] == 0:
            name = regions[number].name
            raise InputError(
                f"the modulus of region '{name}' is fitted, and no pixel shows that region: it is "
                'masked, hidden or out of view; film it from where it is seen, or fit only '
                + ', '.join(f'youngs_modulus.{regions[k].name}' for k in fitted if pixels[k] > 0)
            )


def _pixels(objective: RobustObjective, coordinates: FloatArray) -> NDArray[np.int64]:
    """Return how many unmasked pixels show each region, shape (R,)."""
    model = objective.model
    mesh, regions = model.scene.mesh, model.scene.regions
    region = np.zeros(mesh.tet_count, dtype=np.int64)
    for number, part in enumerate(regions):
        region[part.tets] = number
    pixels = np.zeros(len(regions), dtype=np.int64)
    for number, view in enumerate(model.views(coordinates)):
        counted, _ = objective.comparers[number].pixels(view)
        # A face of the mesh is one triangle of the linear, four of the quadratic element.
        fraction = len(model.tracers[number].triangles) // len(mesh.surface_tets)
        owners = region[mesh.surface_tets].repeat(fraction)
        pixels += np.bincount(owners[view.trace.faces[counted]], minlength=len(regions))
    return pixels
