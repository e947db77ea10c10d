# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What tests of blind forms draw, and the steps of their differences."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.forms import BY_KEY
from benchmarks.blind.setups import draw_setup, Setup

STEPS = (1e-5, 1e-6, 1e-7)
# Bodies of the sealed sets.
SEALED = ['arch', 'waist', 'fin', 'tee']


def draw_faults(key: str, setup: Setup, size: int = 2) -> Faults:
    """Return what a form does, `effect/form`, in one of its sizes."""
    return Faults(**BY_KEY[key].draw(size, setup, np.random.default_rng(8)))


def draw_sealed(family: str) -> Setup:
    """Return a sealed set's body of a family in four poses."""
    return draw_setup(family, is_sealed=True, poses=4, random=np.random.default_rng(3))
