# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A sensor that throws one pattern after another on what moves meanwhile.

Phases are then off by what went by between two of them, and the depth by a sine of the phase:
ripples along the fringes (Weise et al. 2007, CVPR).
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.smoothing import on_window


def rippled(views: Sequence[Rendering], near: float, faults: Faults) -> Rendering:
    """Return what is shown of what is there a moment before, then and a moment after.

    Args:
        views: of the three.
        near: time between two of them [s].
        faults: say by how much a depth errs.
    """
    before, then, after = views
    one, two = (on_window(view, then) for view in (before, after))
    is_seen = np.isfinite(one) & np.isfinite(two) & np.isfinite(then.depth)
    moved = np.where(is_seen, two, 0.0) - np.where(is_seen, one, 0.0)
    columns = then.column + np.arange(then.depth.shape[1])
    error = 1e-3 * faults.rippled * fringes(columns, faults)[:, None] * moved / (2.0 * near)
    return replace(then, depth=then.depth + error)


def fringes(columns: FloatArray, faults: Faults) -> FloatArray:
    """Return how much of the most a depth errs at columns of an image, any shape."""
    angle = 2.0 * np.pi * columns / faults.ripple_period + faults.ripple_phase
    return np.asarray(np.sin(angle))
