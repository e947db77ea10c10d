# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body that is let go again and again before a live camera: one fit a swing."""

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.parameters.parameters import Kind, ParameterSet
from diffcal_ros.calibration.results.outcome import Outcome
from diffcal_ros.calibration.results.result import CalibrationResult
from diffcal_ros.calibration.tracking.body_change import BodyChange, ChangeWatch
from diffcal_ros.calibration.tracking.tracked import least_changes
from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.live.frames.swing_window import Stage, SwingWindow
from diffcal_ros.live.health import Level
from diffcal_ros.scene.fit_names import RELEASE_TIME
from diffcal_ros.scene.model import MotionSetup
import numpy as np

# How long a swing is filmed where the scene does not say, rest before it included [s].
_DURATION = 1.2
# After so long without a rest, or without a release, somebody should know why [s].
_PATIENCE = 10.0


class Swings:
    """Cuts the stream into swings, and remembers what the last ones said.

    Attributes:
        window: looks for swings.
        fitted: swings that were fitted.
        used_frames: frames of these that were compared or held out.
        change: the last change of the body from swing to swing; None without one.
        change_count: changes so far.
        outcome: of the last fit; None before the first one.
        values: that the last good fit found, in SI units by name, without the time of release.
    """

    def __init__(self, motion: MotionSetup, least_change: float) -> None:
        """Start.

        Args:
            motion: what the scene says; when the support lets go is seen here.
            least_change: relative change of a modulus that is told; other parameters in
                proportion to their longest steps.
        """
        self.window = SwingWindow(motion.duration or _DURATION)
        self.fitted = self.used_frames = self.change_count = 0
        self.change: BodyChange | None = None
        self.outcome: Outcome | None = None
        self.values: dict[str, float] = {}
        self._least_change = least_change
        self._watch: ChangeWatch | None = None

    def take_in(
        self, result: CalibrationResult, calibration: Calibration, newest: DepthFrame
    ) -> None:
        """Note what a swing said, and how the body changed since the last one.

        Args:
            result: of the fit.
            calibration: that made it.
            newest: frame of the swing.
        """
        self.fitted += 1
        self.used_frames += len(calibration.model.observations) + len(calibration.held_out)
        self.outcome = result.outcome
        if not result.outcome.is_fitted:
            return
        self.values = {
            name: value
            for name, value in result.values().items()
            if name.partition('.')[0] != RELEASE_TIME
        }
        change = self._changed(result, calibration.parameters, newest.stamp_ns)
        if change is not None:
            self.change = change
            self.change_count += 1

    def _changed(
        self, result: CalibrationResult, parameters: ParameterSet, stamp_ns: int
    ) -> BodyChange | None:
        pairs = list(zip(parameters, result.parameters, strict=True))
        coordinates = np.array([p.coordinate(found.value) for p, found in pairs])
        errors = np.array([f.std_error / (f.value if p.is_logarithmic else 1.0) for p, f in pairs])
        if self._watch is None:
            least = least_changes(parameters, self._least_change)
            # Every swing has its own.
            least[parameters.find(Kind.RELEASE_TIME)] = np.inf
            self._watch = ChangeWatch(parameters, coordinates, least)
        return self._watch.look(stamp_ns, coordinates, errors, result.gap_end.median)

    def figures(self) -> dict[str, str]:
        """Return the figures for a diagnosis."""
        window = self.window
        return {
            'swings seen': str(window.seen),
            'swings fitted': str(self.fitted),
            'swings skipped': str(window.skipped),
            'frames used': str(self.used_frames),
            'frames skipped': str(window.skipped_frames),
            'frames refused for their stamp': str(window.refused),
            'last swing': 'none yet' if self.outcome is None else self.outcome.value,
            'changes': str(self.change_count),
        }

    def status(self) -> tuple[Level, str]:
        """Say what the stream is waited on for."""
        window, seconds = self.window, self.window.seconds
        level, last = self._last()
        if window.stage is Stage.MOVING:
            return level, f'filming a swing{last}'
        if window.stage is Stage.RESTING:
            if seconds < _PATIENCE or self.fitted:
                return level, f'the body rests, let it go{last}'
            return Level.WARN, (
                f'at rest for {seconds:.0f} s, the release was never seen: let the body go, or '
                'leave `motion` out for a body at rest'
            )
        if seconds < _PATIENCE:
            return level, f'waiting for the body to rest on its support{last}'
        return Level.WARN, (
            f'something has been moving for {seconds:.0f} s: a release is seen only after a rest; '
            'set the body on its support, and keep hands and other things out of view'
        )

    def _last(self) -> tuple[Level, str]:
        """Say how the last fit ended, and what to do about it where it did not end well."""
        if self.outcome is None:
            return Level.OK, ''
        words = f'; last swing: {self.outcome.value.replace("_", " ")}'
        if self.outcome is Outcome.CONVERGED:
            return Level.OK, words
        return Level.WARN, f'{words}: {self.outcome.remedy}'
