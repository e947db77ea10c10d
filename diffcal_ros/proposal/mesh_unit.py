# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The unit of a mesh file, which the file does not tell: by the size that a camera sees."""

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.scene.sections.mesh_files import UNITS_PER_METRE
import numpy as np
from numpy.typing import NDArray

# A body that is filmed takes up between these shares of the image's longer side.
_SMALLEST, _LARGEST = 0.07, 1.4
# Bodies that are calibrated by a camera are this large at most times [m].
_USUAL = (0.03, 1.0)


def fitting_units(
    size: float, depth: NDArray[np.float32], camera: PinholeCamera
) -> tuple[str, ...]:
    """Return the units in which a body may be what a camera sees.

    Args:
        size: longest side of the body's bounding box, in the file's unit.
        depth: z [m], shape (H, W), NaN where invalid.
        camera: of the image.

    Returns:
        Units, keys of `UNITS_PER_METRE`; several where the size does not tell.
    """
    seen = depth[np.isfinite(depth)]
    near, far = np.percentile(seen, [5.0, 95.0])
    longer = max(camera.width, camera.height)

    def fits(unit: str) -> bool:
        metres = size / UNITS_PER_METRE[unit]
        shares = metres * camera.fx / np.array([far, near]) / longer
        return bool(
            shares[1] >= _SMALLEST and shares[0] <= _LARGEST and _USUAL[0] <= metres <= _USUAL[1]
        )

    return tuple(unit for unit in UNITS_PER_METRE if fits(unit))


def sizes(size: float) -> str:
    """Say how large a body would be in each unit."""
    return ', '.join(f'in {unit} {size / per:.3g} m' for unit, per in UNITS_PER_METRE.items())
