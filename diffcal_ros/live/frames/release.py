# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""When a live swing began, and whether it was a release at all."""

from dataclasses import replace

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.forward.solution import View
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.calibration.residuals.fit_objective import FitObjective
from diffcal_ros.depth.tracer import OutOfViewError
from diffcal_ros.errors import InputError, RecordingError
from diffcal_ros.fem.motion.inputs import MotionError
from diffcal_ros.fem.statics.equilibrium import EquilibriumError
from diffcal_ros.live.frames.swing_window import Swing
from diffcal_ros.scene.fit_names import RELEASE_TIME
from diffcal_ros.scene.model import Quantity, Scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# A body that is let go moves visibly so much later, at the latest, and usually [s].
_SLOWEST, _USUAL = 0.12, 0.03
# A view that explains the first frame so much better than rest is no chance, nor what a placement
# that is a centimetre wrong does.
_CLEARLY = 0.35


def with_release(scene: Scene, index: int, swing: Swing) -> Scene:
    """Return the scene with the release of one observation where a swing shows it.

    Args:
        scene: the set-up.
        index: of its observation that moves.
        swing: whose first frame is at time zero.
    """
    setup = scene.observations[index]
    assert setup.motion is not None
    stamps = [frame.stamp_ns / 1e9 for frame in swing.frames]
    spacing = float(np.diff(stamps).max())
    lower = max(0.0, swing.onset - _SLOWEST - spacing)
    release = Quantity(max(lower, swing.onset - _USUAL), lower, swing.onset)
    moving = replace(setup, motion=replace(setup.motion, release_time=release))
    observations = (*scene.observations[:index], moving, *scene.observations[index + 1 :])
    return replace(scene, observations=observations)


def require_rest(calibration: Calibration) -> None:
    """Refuse a movement that does not begin with the body on its support.

    A hand that lifts a hanging body moves it as well. How it would hang, a simulated swing shows
    sooner or later.

    Args:
        calibration: at the coordinates to start from; one of a body at rest is let pass.

    Raises:
        RecordingError: when the first frame looks more like a later one is expected to.
    """
    objective, first = calibration.objective, calibration.model.observations[0]
    if first.instant is None:
        return
    try:
        views = calibration.model.views(calibration.coordinates)
    except (EquilibriumError, MotionError):
        return  # The fit itself says so.
    misfits = [
        _misfit(objective, number, view, calibration.coordinates, first)
        for number, view in enumerate(views)
    ]
    if min(misfits) < _CLEARLY * misfits[0]:
        raise RecordingError(
            f'the body is {1e3 * misfits[0] ** 0.5:.1f} mm (RMS) from its support before it '
            'moves: no release was seen but another movement; set the body on its support and let '
            'it go, or correct the placement in the scene'
        )


def _misfit(
    objective: FitObjective,
    number: int,
    view: View,
    coordinates: FloatArray,
    seen: Observation,
) -> float:
    """Return the mean truncated square between a view and an observation [m^2]."""
    try:
        trace = view.trace
    except OutOfViewError:
        return objective.truncation**2
    window = seen.depth[trace.rows, trace.columns].astype(np.float64)
    distances = np.abs(window - objective.read_depth(number, view, coordinates))
    distances = distances[objective.counted(number, view)]
    # What was not measured is as far as can be.
    square = np.fmin(np.where(np.isnan(distances), np.inf, distances), objective.truncation) ** 2
    return float(square.mean()) if len(square) else objective.truncation**2


def require_release_time(names: tuple[str, ...]) -> None:
    """Refuse to fit a motion without the time of its release.

    Args:
        names: of the parameters to fit.

    Raises:
        InputError: when it is not among them.
    """
    if RELEASE_TIME not in names:
        raise InputError(
            f'the body moves, and {RELEASE_TIME!r} is not fitted: live nobody knows beforehand '
            f'when the support lets go; add it to `fit` ({", ".join(names)})'
        )
