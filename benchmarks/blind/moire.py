# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A moire of a projector's grid with that of the imager, which beats along two ways."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.setups import Setup
from benchmarks.blind.shapes import FloatArray


def moire_error(rendering: Rendering, setup: Setup, faults: Faults) -> FloatArray | float:
    """Return an error that is the product of two waves across the image [m], shape (h, w, 1).

    Args:
        rendering: says which part of the image it is.
        setup: the camera.
        faults: say how large the error is, how long the waves are, and which way they go.
    """
    if not faults.moire:
        return 0.0
    height, width = rendering.depth.shape[:2]
    rows = rendering.row + np.arange(height)[:, None] - setup.camera.cy
    columns = rendering.column + np.arange(width)[None] - setup.camera.cx
    slant = np.deg2rad(faults.moire_slant)
    ways = (
        np.cos(slant) * columns + np.sin(slant) * rows,
        np.cos(slant) * rows - np.sin(slant) * columns,
    )
    one, other = (
        np.cos(2.0 * np.pi * way / period + phase)
        for way, period, phase in zip(ways, faults.moire_periods, faults.moire_phases, strict=True)
    )
    return np.asarray(1e-3 * faults.moire * one * other)[..., None]
