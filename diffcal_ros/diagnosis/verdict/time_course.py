# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""When a motion's gap is large, and how fast what is left oscillates."""

from dataclasses import dataclass

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patch_fits.residual_location import PART_NAMES, part_numbers
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Frequencies tried between once in the recording and every other frame.
_TRIED = 200
# Fewer frames have no frequency.
_FEWEST = 6
_THIRDS = ('early', 'in the middle', 'late')


@dataclass(frozen=True)
class TimeCourse:
    """The gap of one recording frame by frame, and where and how it swings.

    Attributes:
        times: of the frames, after the first one [s].
        rms_mm: root mean square over the patches of each frame [mm].
        held_out: which frames no fit has seen.
        largest: when the gap is largest, in words.
        part: of the body on which depth residuals swing most, in words.
        mean_mm: mean depth residual of that part in each frame [mm]; None where it is not seen.
        frequency_hz: at which that swings; None where it drifts or frames are too few.
    """

    times: tuple[float, ...]
    rms_mm: tuple[float, ...]
    held_out: tuple[bool, ...]
    largest: str
    part: str
    mean_mm: tuple[float | None, ...]
    frequency_hz: float | None


def time_course(model: ForwardModel, fit: Refit) -> TimeCourse | None:
    """Return the course of the recording that is off most; None where nothing moves.

    Args:
        model: the model of the fit.
        fit: with all patches.
    """
    recordings = dict.fromkeys(
        group.recording
        for group in fit.groups
        if model.observations[group.view].instant is not None
    )
    courses = [_course(model, fit, recording) for recording in recordings]
    return max(courses, key=lambda course: max(course.rms_mm), default=None)


def _course(model: ForwardModel, fit: Refit, recording: int) -> TimeCourse:
    views = model.views(fit.coordinates)
    frames: dict[float, list[FloatArray]] = {}
    means: dict[float, FloatArray] = {}
    held_out: dict[float, bool] = {}
    for group in (b for b in fit.groups if b.recording == recording):
        seen = model.observations[group.view]
        assert seen.instant is not None
        time = seen.instant.time
        frames.setdefault(time, []).append(1e3 * group.patches.values)
        held_out[time] = seen.is_held_out
        if group.kind == 'depth':
            parts = part_numbers(group, model, views[group.view].points)
            means[time] = _means(1e3 * group.patches.values, parts)
    times = np.array(sorted(frames))
    rms = [float(np.sqrt(np.mean(np.concatenate(frames[t]) ** 2))) for t in times]
    curves = np.stack([means[t] for t in times], axis=1)
    part = int(np.argmax([_swing(curve) for curve in curves]))
    curve = curves[part]
    return TimeCourse(
        times=tuple(times.tolist()),
        rms_mm=tuple(rms),
        held_out=tuple(held_out[t] for t in times),
        largest=_words(times, int(np.argmax(rms))),
        part=PART_NAMES[part],
        mean_mm=tuple(float(v) if np.isfinite(v) else None for v in curve),
        frequency_hz=_frequency(times, curve),
    )


def _means(values: FloatArray, parts: NDArray[np.int64]) -> FloatArray:
    """Return the mean of each part; NaN where it has no patch."""
    counts = np.bincount(parts, minlength=len(PART_NAMES))
    sums = np.bincount(parts, values, minlength=len(PART_NAMES))
    return np.divide(sums, counts, where=counts > 0, out=np.full(len(counts), np.nan))


def _swing(curve: FloatArray) -> float:
    seen = curve[np.isfinite(curve)]
    return float(seen.std()) if len(seen) > 1 else 0.0


def _words(times: FloatArray, index: int) -> str:
    third = min(3 * index // max(len(times), 1), 2)
    return f'{_THIRDS[third]}, at {times[index]:.3f} s'


def _frequency(times: FloatArray, curve: FloatArray) -> float | None:
    """Return the frequency [Hz] at which a curve that may have holes swings most."""
    # Few commands see a motion, and all would wait 0.6 s for it, with SciPy's statistics.
    from scipy.signal import lombscargle

    seen = np.isfinite(curve)
    times, curve = times[seen], curve[seen]
    if len(times) < _FEWEST or not curve.std() > 0.0:
        return None
    span, spacing = times[-1] - times[0], float(np.median(np.diff(times)))
    tried = np.linspace(1.0 / span, 0.5 / spacing, _TRIED)
    power = lombscargle(times, curve - curve.mean(), 2.0 * np.pi * tried)
    best = int(np.argmax(power))
    # What goes once through the recording drifts, and does not swing.
    return float(tried[best]) if best > 0 else None
