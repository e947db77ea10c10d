# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where along a body of one region another material begins and ends, and begins again.

Borders are settings of the effects of two materials: `at` and `until` of the first stretch of the
second material, `at_2` and `until_2` of the next, and so on. One that is at the tip is none.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

MOST_BANDS = 4
_TIP = 1.0
NAMES = tuple(
    f'{end}_{number}' if number > 1 else end
    for number in range(1, MOST_BANDS + 1)
    for end in ('at', 'until')
)
# Without a word the second material has the outer half.
SETTINGS = {name: 0.5 if name == 'at' else _TIP for name in NAMES}


def borders(settings: Mapping[str, float]) -> tuple[float, ...]:
    """Return where materials end, as shares of the free length from the clamp on."""
    stated = {**SETTINGS, **settings}
    return tuple(sorted(stated[name] for name in NAMES if stated[name] < _TIP))


def band_settings(places: Sequence[float]) -> dict[str, float]:
    """Return the settings of borders, shares of the free length; of one that is `at` alone.

    Raises:
        ValueError: of more borders than there are settings.
    """
    if len(places) > len(NAMES):
        raise ValueError(f'{len(places)} borders: at most {len(NAMES)} can be stated')
    return dict(zip(NAMES, sorted(places), strict=False))


def without_unused(numbers: Mapping[str, float]) -> dict[str, float]:
    """Return an effect's numbers without borders at the tip."""
    return {k: v for k, v in numbers.items() if k == 'at' or k not in NAMES or v < _TIP}


def is_second(shares: FloatArray, settings: Mapping[str, float]) -> NDArray[np.bool_]:
    """Tell which shares of the free length are of the second material, as `shares`."""
    return is_between(shares, borders(settings))


def is_between(shares: FloatArray, places: Sequence[float]) -> NDArray[np.bool_]:
    """Tell the same by the borders themselves, ascending."""
    return np.asarray(np.searchsorted(places, shares) % 2 == 1)


def in_words(settings: Mapping[str, float]) -> str:
    """Say where the second material is, such as `0.36 to 0.46 and 0.6 to the tip`."""
    places = borders(settings)
    ends = [*(f'{place:g}' for place in places[1::2]), 'the tip']
    bands = [f'{place:g} to {end}' for place, end in zip(places[::2], ends, strict=False)]
    return ' and '.join(filter(None, (', '.join(bands[:-1]), bands[-1]))) if bands else 'nowhere'
