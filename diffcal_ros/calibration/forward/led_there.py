# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Lead a model's bodies to coordinates that they do not come to at once.

A fit takes many small steps, and a body that is bent far by what was added on the way is not found
again from where it was without: Newton's method ends nowhere. By way of coordinates between it is
found, as loads that are applied in steps are (Allgower and Georg, *Numerical Continuation
Methods*, 1990: an embedding, with steps that are halved where one fails).
"""

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.errors import NotSimulatedError
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_FIRST, _SMALLEST, _GROWTH = 0.5, 0.02, 1.5


def lead_to(model: ForwardModel, coordinates: FloatArray) -> None:
    """Let the next evaluation of a model at some coordinates find its bodies there.

    Args:
        model: it begins where it was evaluated last, or where the model was that it comes from.
        coordinates: of its parameters, shape (k,).

    Raises:
        NotSimulatedError: where no way of that kind leads there. A motion is not led: it begins
            from rest whatever was known before.
    """
    try:
        model.at(coordinates)
        return
    except NotSimulatedError:
        if model.is_moving:
            raise
    begun = model.place
    done, step = 0.0, _FIRST
    while done < 1.0:
        share = done + step
        try:
            model.at(coordinates if share >= 1.0 else begun + share * (coordinates - begun))
        except NotSimulatedError:
            step *= 0.5
            if step < _SMALLEST:
                raise
            continue
        done = share
        step = min(_GROWTH * step, 1.0 - done)
