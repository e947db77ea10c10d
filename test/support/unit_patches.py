# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Patches of one view whose noise is one, for tests of what is made of them."""

from diffcal_ros.diagnosis.patches.noise_model import CommonError
from diffcal_ros.diagnosis.patches.patch_group import PatchGroup
from diffcal_ros.diagnosis.patches.patches import Patches
import numpy as np


def unit_group(values, cells=None):
    """Return patches that are off by some values, in cells of the report."""
    values = np.asarray(values)
    count = len(values)
    patches = Patches(
        values=values,
        jacobian=np.zeros((count, 0)),
        covariance=np.eye(count),
        centers=np.zeros((count, 2)),
        cells=np.arange(count) if cells is None else np.asarray(cells),
        weights=np.ones(count),
        common=CommonError(np.zeros(count), 1.0),
    )
    return PatchGroup(0, 'depth', 0, patches, np.zeros(count), np.ones(count, dtype=bool))
