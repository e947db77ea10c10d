# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Oil that seeped into a body from its clamp's end, as a solvent does from a bath."""

import numpy as np
from scipy.special import erfc

from benchmarks.blind.shapes import FloatArray


def seeped_share(share: FloatArray, width: float) -> FloatArray:
    """Return how much oil is in a body, 1 at the clamp, by the complement of the error function.

    Args:
        share: of the free length, any shape.
        width: twice the root of diffusivity times time, as a share of the free length.
    """
    return np.asarray(erfc(np.maximum(share, 0.0) / width))
