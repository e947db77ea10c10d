# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where the blind generator's bodies come to rest, in coarse cells."""

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.setups import Setup
from benchmarks.blind.simulation import make_specimen, settle

COARSE = 0.5


def rest_of(setup: Setup, faults: Faults, pose: int = 0) -> np.ndarray:
    """Return node positions in a pose, object frame [m], shape (N, 3)."""
    return settle(make_specimen(setup, faults, COARSE), setup, setup.observations[pose], faults)
