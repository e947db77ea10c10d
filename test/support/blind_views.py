# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the blind generator's cameras see of a body with faults, beside one without."""

import numpy as np
from numpy.typing import NDArray

from benchmarks.blind.faults import Faults
from benchmarks.blind.observe import true_rendering
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.setups import Setup
from benchmarks.blind.specimen import Specimen


def with_and_without(
    plain: Specimen, setup: Setup, faults: Faults, pose: int, rest: np.ndarray
) -> tuple[Rendering, Rendering, NDArray[np.bool_]]:
    """Return a view with faults of the camera, one without, and which samples see something.

    Fails where the two do not see the same.

    Args:
        plain: the body.
        setup: with its cameras.
        faults: that move no node.
        pose: number.
        rest: nodes, object frame [m], shape (N, 3).
    """
    view, right = (
        true_rendering(plain, setup, setup.observations[pose], each, rest)
        for each in (faults, Faults())
    )
    there = np.isfinite(right.depth)
    assert np.array_equal(there, np.isfinite(view.depth))
    return view, right, there
