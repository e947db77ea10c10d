# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The synthetic twin: data from another mesh, twenty noise draws, honest intervals."""

from diffcal_ros.calibration.calibrate import calibrate
import numpy as np
import pytest
from support.scenes import beam_scene, MODULUS, noisy, observation, true_depth

_DRAWS = 20


@pytest.mark.slow
@pytest.mark.parametrize('fit', [('youngs_modulus',), ('youngs_modulus', 'rigid_offset')])
def test_truth_lies_in_the_interval(fit) -> None:
    depth = true_depth(counts=(14, 4, 4))
    scene = beam_scene(modulus=1.3 * MODULUS, fit=fit)
    hits, widths = 0, []
    for draw in range(_DRAWS):
        seen = noisy(depth, np.random.default_rng(draw))
        modulus = calibrate(scene, [observation(seen)])['youngs_modulus']
        width = 1.96 * modulus.std_error
        hits += abs(modulus.value - MODULUS) <= width
        widths.append(width / modulus.value)
    assert hits >= 18
    assert max(widths) <= 0.15
