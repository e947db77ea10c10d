# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which pixels of the beam show its second region."""

from functools import cache

from diffcal_ros.calibration.calibrate import Calibration
import numpy as np

from support.scenes import beam_scene, observation, true_depth


@cache
def second_material() -> np.ndarray:
    """Tell which pixels show the outer half of the beam as it hangs, shape (H, W)."""
    seen = observation(true_depth())
    calibration = Calibration(beam_scene((8, 2, 2), region_count=2), [seen])
    comparer = calibration.likelihood('a test').comparers[0]
    (view,) = calibration.model.views(calibration.parameters.start())
    is_second = np.zeros(seen.depth.shape, dtype=bool)
    window = is_second[view.trace.rows, view.trace.columns]
    window[:] = comparer.is_second(view.trace) & np.isfinite(view.trace.depth)
    return is_second
