# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Light that strays in a lens, and lies as a veil over the phases of all pixels."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.shapes import FloatArray

_DARKEST = 1.0 / 3.0  # Cosine of the angle from which on a surface is not darker.


def veiled(seen: FloatArray, facing: FloatArray, distance: float, faults: Faults) -> FloatArray:
    """Return the error of depths that are mixed with a veil's, by the light of each [m].

    A pixel tells the mean of its own depth and the veil's, weighted by light: what is dark, as
    it is far or met aslant, errs most.

    Args:
        seen: true depths [m], any shape.
        facing: cosine of the angle between ray and surface, the same shape.
        distance: where the camera looks at [m].
        faults: say which depth the veil has, and by how much it spoils what is met squarely there.
    """
    error, away = 1e-3 * faults.depth_bias, faults.depth_veil - distance
    veil = error / (away - error)
    light = np.maximum(facing, _DARKEST) * (distance / seen) ** 2
    return np.asarray(veil / (light + veil) * (faults.depth_veil - seen))
