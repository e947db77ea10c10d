# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Two parts of a rubber that were stirred too little, and lie beside each other in swirls."""

import numpy as np

from benchmarks.blind.shapes import FloatArray

_WAVES = 24  # That a swirl is put together of.


def marbled_value(share: FloatArray, across: FloatArray, wave: float, seed: int) -> FloatArray:
    """Return a smooth value of mean 0 and variance 1 that a seed decides.

    It has waves of about one length along the body, and of about its width and height across.

    Args:
        share: of the free length, any shape.
        across: places over the half width and the half height, that shape and 2 more in front.
        wave: length of its waves, as a share of the free length.
        seed: of the waves.
    """
    random = np.random.default_rng(seed)
    rates = random.standard_normal((_WAVES, 3)) * np.array([2.0 * np.pi / wave, np.pi, np.pi])
    phases = random.uniform(0.0, 2.0 * np.pi, _WAVES)
    whole = np.zeros(np.shape(share))
    for rate, phase in zip(rates, phases, strict=True):
        whole += np.cos(rate[0] * share + rate[1] * across[0] + rate[2] * across[1] + phase)
    return np.asarray(np.sqrt(2.0 / _WAVES) * whole)
