# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the tenth set alone has.

Their second and third size change what is seen of a body by some 5 and 10 mm.
"""

import numpy as np

from benchmarks.blind.amplitudes import Drawer, Effect, number
from benchmarks.blind.outside_forms import tip_stiffness
from benchmarks.blind.setups import Setup


def screen(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw a charged screen behind the body that draws it by the exponential of the distance."""
    # Of an even load a tip goes three eighths as far as of one on it; some poses are nearer.
    force = number((0.0014, 0.0035, 0.007)[size] * tip_stiffness(setup) / 0.375, random)
    reach = round(float(random.uniform(0.06, 0.09)), 4)
    amplitude: dict[str, float | str] = {'force': force, 'reach': reach}
    changes = {'screen': force, 'screen_reach': reach}
    return Effect('screen', amplitude, 'N where the camera looks, m', changes)


def coarse(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw the step of a sensor that was left to tell depths by a coarse unit."""
    step = number((4.0, 10.0, 20.0)[size], random)
    return Effect('coarse', {'step': step}, 'mm', {'coarse': step})


TENTH_OUTSIDE: dict[str, Drawer] = {drawer.__name__: drawer for drawer in (screen, coarse)}
