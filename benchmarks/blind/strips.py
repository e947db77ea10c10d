# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Errors by the columns of an image: of strips that are read out, or of fringes that close up."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.setups import Setup
from benchmarks.blind.shapes import FloatArray


def sawtooth_error(rendering: Rendering, faults: Faults) -> FloatArray | float:
    """Return an error that rises evenly over each strip of columns and falls back [m], (w, 1).

    Args:
        rendering: says which part of the image it is.
        faults: say how large it is at a strip's end, how wide strips are, and where one begins.
    """
    if not faults.sawtoothed:
        return 0.0
    columns = rendering.column + np.arange(rendering.depth.shape[1])
    along = (columns - faults.sawtoothed_from) / faults.sawtoothed_strip % 1.0
    return np.asarray(1e-3 * faults.sawtoothed * (2.0 * along - 1.0))[None, :, None]


def chirp_error(rendering: Rendering, setup: Setup, faults: Faults) -> FloatArray | float:
    """Return an error by the sine of the square of the way across an image [m], (w, 1).

    Args:
        rendering: says which part of the image it is.
        setup: the camera.
        faults: say how large it is, from which column on, and over how many columns the first
            wave goes.
    """
    if not faults.chirped:
        return 0.0
    columns = rendering.column + np.arange(rendering.depth.shape[1])
    waves = ((columns - setup.camera.cx - faults.chirped_at) / faults.chirped_wave) ** 2
    return np.asarray(1e-3 * faults.chirped * np.sin(2.0 * np.pi * waves))[None, :, None]
