# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A motor beside the clamp that warms up, and with it what it holds, farther in each pose."""

from dataclasses import replace

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.material import softened
from benchmarks.blind.seeping import seeped_share
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.specimen import Specimen


def heated_share(share: FloatArray, width: float, number: int) -> FloatArray:
    """Return how warm a body is in a pose, 1 at the clamp, by the error function's complement.

    Heat goes on by the root of the time since the motor was switched on, and poses are alike in
    time.

    Args:
        share: of the free length, any shape.
        width: twice the root of diffusivity times time of the first pose, as such a share.
        number: of the pose, from 0.
    """
    return seeped_share(share, width * float(np.sqrt(1.0 + number)))


def heated_on(specimen: Specimen, number: int, faults: Faults) -> Specimen:
    """Return a body as warm as it is in a pose, from how it is in the first.

    Args:
        specimen: in the first pose.
        number: of the pose, from 0.
        faults: say how much softer it is at the clamp, and how far heat has come at first.
    """
    body, width = specimen.body, faults.contrast_width
    share = specimen.shares[body.cells] @ body.quadrature.values.T
    later, first = (heated_share(share, width, each) for each in (number, 0))
    factor = np.exp(faults.contrast * (later - first))
    return replace(specimen, body=replace(body, numbers=softened(body.numbers, factor)))
