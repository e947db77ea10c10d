# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a named effect is in each frame of a recording: a panel for each amplitude."""

from collections.abc import Sequence
from typing import Any

from diffcal_ros.diagnosis.verdict.verdict import NamedEffect
from diffcal_ros.report import palette
from diffcal_ros.report.figures.figure_png import new_figure
import numpy as np

_WIDTH, _HEIGHT = 8.0, 2.4  # Of a panel [inch].


def course_figure(effect: NamedEffect, times: Sequence[float], is_held_out: Sequence[bool]) -> Any:
    """Draw amplitudes over time; frames that no fit has seen are hollow.

    Args:
        effect: with a course.
        times: of the frames, after the first one [s].
        is_held_out: which of them no fit has seen.
    """
    figure = new_figure(_WIDTH, _HEIGHT * len(effect.course))
    panels = figure.subplots(len(effect.course), 1, sharex=True, squeeze=False)[:, 0]
    kept, when = np.array(is_held_out), np.array(times)
    for panel, (name, values) in zip(panels, effect.course.items(), strict=True):
        shown = np.array(values)
        panel.plot(when, shown, color=palette.FITTED, linewidth=1.5)
        panel.plot(when[~kept], shown[~kept], 'o', color=palette.FITTED)
        panel.plot(when[kept], shown[kept], 'o', color=palette.FITTED, markerfacecolor='white')
        panel.axhline(0.0, color=palette.MEASURED, linestyle=':', linewidth=1.0)
        panel.grid(color='#e5e7eb', linewidth=0.7)
        panel.set_ylabel(f'{name} [{effect.unit[name]}]')
    panels[-1].set_xlabel('after the first frame [s]')
    return figure
