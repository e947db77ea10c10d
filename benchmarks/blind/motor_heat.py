# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A motor beside the clamp that warms up, and with it what it holds, farther in each pose.

Another source of heat, of which each pose tells as well, is a heat gun before the first of them.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.heat_gun import gun_heat
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
        faults: say where it is warm, how much softer it is there, and how far heat has come at
            first.
    """
    body, warm = specimen.body, HEATS[faults.contrast_mode]
    share = specimen.shares[body.cells] @ body.quadrature.values.T
    later, first = (warm(share, faults, each) for each in (number, 0))
    factor = np.exp(faults.contrast * (later - first))
    return replace(specimen, body=replace(body, numbers=softened(body.numbers, factor)))


# How warm a body is at shares of its free length in a pose, by what warms it.
HEATS: dict[str, Callable[[FloatArray, Faults, int], FloatArray]] = {
    'motor heat': lambda share, faults, number: heated_share(share, faults.contrast_width, number),
    'heat gun': gun_heat,
}
