# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the thirty-first set alone has.

Their second and third size change what is seen of a body by some 4 and 10 mm.
"""

import numpy as np

from benchmarks.blind.amplitudes import Drawer, Effect, number, signed
from benchmarks.blind.setups import Setup

_SIZES = (2.0, 4.0, 10.0)  # [mm].


def domed(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw how high the dome is that a body has for an end."""
    high = number(_SIZES[size], random)
    return Effect('domed', {'height': high}, 'mm', {'domed': high})


def crosstalk(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw an error of depth of all that a column sees, which adds up on its wire."""
    error = signed(_SIZES[size], random)
    return Effect('crosstalk', {'error': error}, 'mm', {'crosstalk': error})


THIRTYFIRST_OUTSIDE: dict[str, Drawer] = {drawer.__name__: drawer for drawer in (domed, crosstalk)}
