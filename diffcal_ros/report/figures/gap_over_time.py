# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How well each frame of a motion is met, at start and fitted values, kept frames included."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.residuals.gap import Gap, measure_gap
from diffcal_ros.calibration.residuals.objective import RobustObjective
from diffcal_ros.calibration.results.result import CalibrationResult
from diffcal_ros.report import palette
from diffcal_ros.report.figures.figure_png import new_figure
import numpy as np

_LEAST_SPAN = 10.0  # Ends of the scale as far apart as this ask for a logarithm.


@dataclass(frozen=True)
class FrameGap:
    """The gap of one frame.

    Attributes:
        time: after the first frame of its recording [s].
        is_held_out: it was kept from the fit.
        start: at the start values.
        fitted: at the fitted values.
    """

    time: float
    is_held_out: bool
    start: Gap
    fitted: Gap


@dataclass(frozen=True)
class MotionGaps:
    """The gaps of one motion.

    Attributes:
        name: of its observation.
        release_time: where the fit has it [s].
        frames: in order of time.
    """

    name: str
    release_time: float
    frames: tuple[FrameGap, ...]


def motion_gaps(calibration: Calibration, result: CalibrationResult) -> list[MotionGaps]:
    """Measure every frame of every motion; empty for bodies at rest."""
    seen = (*calibration.model.observations, *calibration.held_out)
    moving = sorted({frame.setup_index for frame in seen if frame.instant is not None})
    if not moving:
        return []
    model, parameters = calibration.model_of_all(), calibration.parameters
    objective = RobustObjective(model, device=calibration.settings.device)
    fitted = {p.name: p.value for p in result.parameters}
    start = result.history[0].values if result.history else fitted
    gaps, ends = [], np.zeros(0)
    for values in (start, fitted):
        ends = np.array([p.coordinate(values[p.name]) for p in parameters])
        gaps.append(
            [
                measure_gap([c.difference], [c.counted], objective.truncation)
                for c in objective.comparisons(ends)
            ]
        )
    motions = []
    for index in moving:
        frames = [
            FrameGap(frame.instant.time, frame.instant.is_held_out, *pair)
            for frame, *pair in zip(model.observations, *gaps, strict=True)
            if frame.instant is not None and frame.setup_index == index
        ]
        name = calibration.scene.observations[index].name
        release = model.inputs.release_time(index, ends)
        frames.sort(key=lambda frame: frame.time)
        motions.append(MotionGaps(name, release, tuple(frames)))
    return motions


def gap_over_time_figure(motion: MotionGaps) -> Any:
    """Draw the RMS gap of every frame over time, one scale for start and fitted values."""
    figure = new_figure(11.0, 3.6)
    panel = figure.subplots()
    times = [frame.time for frame in motion.frames]
    lines = (
        ('start', [frame.start for frame in motion.frames], palette.START),
        ('fitted', [frame.fitted for frame in motion.frames], palette.FITTED),
    )
    for label, gaps, color in lines:
        values = [1e3 * gap.rms for gap in gaps]
        panel.plot(times, values, color=color, marker='o', label=label)
    _mark_held_out(panel, motion.frames)
    panel.axvline(motion.release_time, color=palette.MEASURED, linestyle=':', label='release')
    sizes = [1e3 * gap.rms for _, gaps, _ in lines for gap in gaps if np.isfinite(gap.rms)]
    if sizes and max(sizes) > _LEAST_SPAN * max(min(sizes), 1e-6):
        panel.set_yscale('log')
    else:
        panel.set_ylim(bottom=0.0)
    panel.grid(color='#e5e7eb', linewidth=0.7)
    panel.set_xlabel('after the first frame [s]')
    panel.set_ylabel('RMS gap on the body [mm]')
    panel.legend(loc='upper center', bbox_to_anchor=(0.5, -0.2), ncol=4, fontsize=9, frameon=False)
    return figure


def _mark_held_out(panel: Any, frames: Sequence[FrameGap]) -> None:
    kept = [frame for frame in frames if frame.is_held_out]
    if not kept:
        return
    panel.plot(
        [frame.time for frame in kept],
        [1e3 * frame.fitted.rms for frame in kept],
        linestyle='none',
        marker='o',
        markersize=11,
        markerfacecolor='none',
        markeredgecolor=palette.FITTED,
        label='kept from the fit',
    )
