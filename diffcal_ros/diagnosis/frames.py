# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the numbers of an effect refer to: a point turned about, axes, a normal."""

from diffcal_ros.calibration.forward_model import ForwardModel
from diffcal_ros.effects.library import EFFECTS
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Frame = dict[str, list[float]]


def frame_of(identifier: str, model: ForwardModel, coordinates: FloatArray) -> Frame:
    """Return points [m] and unit vectors, each of three numbers, by name.

    Args:
        identifier: of the effect.
        model: that has it.
        coordinates: of the model's parameters, shape (k,).
    """
    own = model.effects.amplitudes(coordinates).get(identifier, {})
    site = model.effects.site(0, camera_pivot=model.cameras.offset_pivot)
    vectors = EFFECTS[identifier].frame(own, site)
    return {name: [round(float(x), 9) for x in vector] for name, vector in vectors.items()}
