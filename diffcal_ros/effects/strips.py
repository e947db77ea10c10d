# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which part across a body of one region is of another material: a strip, a face, a sticker.

Limits are settings beside those of `bands`, as shares of the body's width from one side to the
other by its axes across it, `a` and `b`: `a_from` 0 and `a_until` 1 are all of it.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

SETTINGS = {'a_from': 0.0, 'a_until': 1.0, 'b_from': 0.0, 'b_until': 1.0}


def limits(settings: Mapping[str, float]) -> FloatArray | None:
    """Return from where to where it is across both axes, in half widths from the middle, (2, 2).

    None: all across.
    """
    stated = [settings.get(name, usual) for name, usual in SETTINGS.items()]
    if stated == list(SETTINGS.values()):
        return None
    found = 2.0 * np.reshape(stated, (2, 2)) - 1.0
    # What is at a side is beyond no limit there.
    return np.where(found <= -1.0, -np.inf, np.where(found >= 1.0, np.inf, found))


def is_within(across: FloatArray, own: FloatArray) -> NDArray[np.bool_]:
    """Tell which points are within limits, shape (...,).

    Args:
        across: how far across they are, in half widths, see `BodyAxes.on_surface`, shape (..., 2).
        own: limits, shape (2, 2).
    """
    return np.asarray(((across > own[:, 0]) & (across <= own[:, 1])).all(axis=-1))


def strip_settings(own: FloatArray) -> dict[str, float]:
    """Return the settings of limits, shape (2, 2); of what goes on to a side none."""
    shares = np.clip(0.5 * (own + 1.0), 0.0, 1.0).round(4).ravel().tolist()
    found = dict(zip(SETTINGS, shares, strict=True))
    return {name: share for name, share in found.items() if share != SETTINGS[name]}


def without_unused(numbers: Mapping[str, float]) -> dict[str, float]:
    """Return an effect's numbers without limits that leave nothing out."""
    return {k: v for k, v in numbers.items() if k not in SETTINGS or v != SETTINGS[k]}


def in_words(settings: Mapping[str, float]) -> str:
    """Say which part across it is, such as `b 0 to 0.6`; empty: all of it."""
    stated = {**SETTINGS, **settings}
    parts = []
    for axis in 'ab':
        ends = stated[f'{axis}_from'], stated[f'{axis}_until']
        if ends != (0.0, 1.0):
            parts.append(f'{axis} {ends[0]:g} to {ends[1]:g}')
    return ', '.join(parts)
