# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A beam that was fitted once and is filmed on: exact views of it, and a tracker at its values."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.results.result import CalibrationResult
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.calibration.tracking.tracked import Tracked, TrackerSettings
from diffcal_ros.calibration.tracking.tracker import Tracker
from diffcal_ros.depth_frame import DepthFrame
import numpy as np

from support.scenes import beam_scene, MODULUS, noisy, observation, true_depth

PERIOD = 33_333_333  # [ns]
START = 1_700_000_000_000_000_000  # [ns]
COUNTS = (8, 2, 2)
_WALL = 0.9  # Behind the beam [m].
_SETTINGS = CalibrationSettings(with_mesh_error=False)
ALONE, WITH_OFFSET = ('youngs_modulus',), ('youngs_modulus', 'rigid_offset')


@cache
def exact(factor: float = 1.0) -> np.ndarray:
    """Depth of the beam with a multiple of the modulus before a wall [m], without noise."""
    depth = true_depth(factor * MODULUS, counts=COUNTS)
    return np.where(np.isnan(depth), _WALL, depth)


def calibration(fit: tuple[str, ...] = WITH_OFFSET) -> Calibration:
    """A fit of what is seen at the plain modulus, not yet run; alone, the pose is exact."""
    seen = observation(exact())
    if fit != ALONE:
        seen = replace(seen, pose_covariance=np.diag([1e-6] * 3 + [1e-5] * 3))
    return Calibration(beam_scene(COUNTS, fit=fit), [seen], _SETTINGS)


@cache
def fitted(fit: tuple[str, ...] = WITH_OFFSET) -> CalibrationResult:
    return calibration(fit).run()


class Film:
    """A stream of noisy frames, and a tracker that follows it."""

    def __init__(
        self,
        seed: int = 0,
        settings: TrackerSettings | None = None,
        fit: tuple[str, ...] = WITH_OFFSET,
    ) -> None:
        self.tracker = Tracker(calibration(fit), fitted(fit).parameters, settings)
        self.stamp_ns = START
        self._random = np.random.default_rng(seed)

    def shoot(self, depths: Sequence[np.ndarray], period_ns: int = PERIOD) -> list[Tracked]:
        """Follow one frame of each of these exact views."""
        told = []
        for depth in depths:
            self.stamp_ns += period_ns
            frame = DepthFrame(noisy(depth, self._random), self.stamp_ns, 'camera')
            told.append(self.tracker.follow(frame))
        return told


def modulus(tracked: Tracked) -> float:
    return tracked.values()['youngs_modulus']
