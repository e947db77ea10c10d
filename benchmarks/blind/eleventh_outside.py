# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Causes outside the library that the eleventh set alone has.

Their second and third size change what is seen of a body by some 5 and 10 mm.
"""

import numpy as np

from benchmarks.blind.amplitudes import Drawer, Effect, number, signed
from benchmarks.blind.outside_forms import depth_amid_body
from benchmarks.blind.setups import Setup

_MOST_RACKED = 0.6  # More, and cells are too oblique.


def racked(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw by how much a mould's upper side stood beside its lower one, its end aside."""
    share = min((0.002, 0.005, 0.010)[size] / setup.shape.section[1], _MOST_RACKED)
    slope = signed(share, random)
    return Effect('racked', {'slope': slope}, 'along y over z', {'racked': slope})


def jump(size: int, setup: Setup, random: np.random.Generator) -> Effect:
    """Draw by how much depths are longer beyond one where a sensor counts its waves anew."""
    amount = number((2.0, 5.0, 10.0)[size], random)
    between = depth_amid_body(setup, random)
    begin = round(between + float(random.uniform(-0.005, 0.005)), 5)
    amplitude: dict[str, float | str] = {'amount': amount, 'from': begin}
    return Effect('jump', amplitude, 'mm, m', {'jump': amount, 'jump_from': begin})


ELEVENTH_OUTSIDE: dict[str, Drawer] = {drawer.__name__: drawer for drawer in (racked, jump)}
