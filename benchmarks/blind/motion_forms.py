# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What shows only over time, in mathematical forms that are not the library's.

Normal drag is as large as that of the library's form where the wide faces lie across the motion:
it is told by its area all the same, not for comparison.
"""

from typing import Any

import numpy as np

from benchmarks.blind.amplitudes import number, signed
from benchmarks.blind.form import Form
from benchmarks.blind.setups import Setup

_DRAG, _LATE, _CREEP = (150.0, 450.0, 1200.0), (2.0, 5.0, 12.0), (0.08, 0.2, 0.4)


def _drag(name: str) -> Form:
    def draw(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
        return {'drag_form': name, 'drag_area': number(_DRAG[size], random)}

    return Form('air_drag', name, draw)


def _late(name: str) -> Form:
    def draw(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
        return {'stamps_form': name, 'stamps_late': signed(_LATE[size], random)}

    return Form('time_offset', name, draw)


def _creep(name: str) -> Form:
    def draw(size: int, setup: Setup, random: np.random.Generator) -> dict[str, Any]:
        time = round(float(random.uniform(2.0, 6.0)), 2)
        share = number(_CREEP[size], random)
        return {'creep_form': name, 'creep_share': share, 'creep_time': time}

    return Form('creep', name, draw)


MOTION_FORMS = (_drag('linear'), _drag('normal'), _late('drift'), _late('jitter'), _creep('two'))
