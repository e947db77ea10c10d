# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Find a body that changed in one frame, fast."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from diffcal_ros.calibration.parameters.longest_steps import longest_steps
from diffcal_ros.calibration.residuals.objective import RobustObjective
from diffcal_ros.calibration.residuals.residual_scales import Scales
from diffcal_ros.calibration.results.outcome_rules import leaves_body_out
from diffcal_ros.calibration.search.basins import Basin
from diffcal_ros.calibration.search.global_search import can_search, GlobalSearch
from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.errors import NotSimulatedError
from diffcal_ros.least_squares.levenberg_marquardt import Iteration, minimise, Stop
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Of a body that is found, a larger share of what is rendered is seen.
FOUND = 0.10
# How often a search is tried while the body is not found [ns].
_RETRY = 1_000_000_000
# A brief search ends with a step no longer than this share of the longest (1.4 % of a modulus):
# frames can do the rest, and polishing what is hard to tell apart takes as long again.
_NEAR = 0.02


@dataclass(frozen=True)
class FoundBody:
    """Where a body was found.

    Attributes:
        coordinates: shape (k,).
        scales: by which residuals were weighed there.
    """

    coordinates: FloatArray
    scales: Scales


class BodySearch:
    """Finds a body that left the place where it was followed; not with every frame.

    Attributes:
        count: searches so far.
    """

    def __init__(self, objective: RobustObjective) -> None:
        """Prepare.

        Args:
            objective: compares with the frame that was shown last.
        """
        self._objective = objective
        self._bounds = objective.model.parameters.bounds()
        self._longest = longest_steps(objective.model.parameters)
        self._stage: GlobalSearch | None = None
        self.count = 0
        self.forget()

    def forget(self) -> None:
        """Search whenever it is asked for, briefly at first."""
        self._next_ns = self._thorough_until_ns = 0

    def is_due(self, frame: DepthFrame) -> bool:
        """Tell whether the last search is long enough ago."""
        return frame.stamp_ns >= self._next_ns

    def find(self, frame: DepthFrame, start: FloatArray) -> FoundBody | None:
        """Fit one frame.

        Args:
            frame: that the objective compares with.
            start: coordinates, shape (k,).

        Returns:
            Where the body is; None when it is found nowhere.
        """
        self.count += 1
        self._next_ns = frame.stamp_ns + _RETRY
        objective, limits = self._objective, (self._bounds, self._longest)
        is_brief = frame.stamp_ns >= self._thorough_until_ns
        near = find_body(objective, start, *limits, is_brief=is_brief)
        found = find_body_anywhere(objective, lambda: self._basins(frame, start), *limits, near)
        if found is not None and is_brief:
            # Where the model cannot show the body, only the minimum itself keeps frames near.
            self._thorough_until_ns = frame.stamp_ns + 2 * _RETRY
            self._next_ns = 0
        return found

    def _basins(self, frame: DepthFrame, start: FloatArray) -> list[Basin]:
        """Return where on the whole range the body of a frame may be, the best first."""
        model = self._objective.model
        if not can_search(model):
            return []
        if self._stage is None:
            self._stage = GlobalSearch(model, start)
        self._stage.look_at([frame.depth])
        return self._stage.basins()


def find_body(
    objective: RobustObjective,
    start: FloatArray,
    bounds: tuple[FloatArray, FloatArray],
    longest: FloatArray,
    *,
    is_brief: bool,
) -> FoundBody | None:
    """Fit the frame that an objective compares with.

    Args:
        objective: compares with the frame; its scales are left as they are.
        start: coordinates, shape (k,).
        bounds: lower and upper, shape (k,) each.
        longest: step of each coordinate, shape (k,).
        is_brief: come near only; not to the minimum itself.

    Returns:
        Where the body is; None when it is not found.
    """
    trial = objective.under(Scales())
    goes_on = _Approach(trial, longest) if is_brief else None
    try:
        minimum = minimise(trial, start, bounds, longest, on_iteration=goes_on)
        gap = trial.gap(minimum.coordinates)
    except NotSimulatedError:
        return None
    if minimum.stop is Stop.STUCK or gap.coverage < FOUND:
        return None
    return FoundBody(minimum.coordinates, trial.scales)


def find_body_anywhere(
    objective: RobustObjective,
    basins: Callable[[], Sequence[Basin]],
    bounds: tuple[FloatArray, FloatArray],
    longest: FloatArray,
    near: FoundBody | None,
) -> FoundBody | None:
    """Look over the whole range where a search from near by leaves a part of the body out.

    Args:
        objective: compares with the frame.
        basins: finds places to start from, the best first.
        bounds: lower and upper, shape (k,) each.
        longest: step of each coordinate, shape (k,).
        near: what was found from near by, or None.

    Returns:
        Where the body is; None when it is found nowhere.
    """
    if near is not None and not leaves_body_out(
        objective.under(near.scales).gap(near.coordinates)
    ):
        return near
    for basin in basins()[:1]:
        far = find_body(objective, basin.coordinates, bounds, longest, is_brief=False)
        if far is not None and (near is None or _is_better(objective, far, near)):
            return far
    return near


def _is_better(objective: RobustObjective, far: FoundBody, near: FoundBody) -> bool:
    yardstick = objective.under(far.scales)
    return yardstick.misfit(near.coordinates).is_worse(
        yardstick.misfit(far.coordinates), fraction=0.0
    )


class _Approach:
    """Lets a search go on until its steps are short."""

    def __init__(self, objective: RobustObjective, longest: FloatArray) -> None:
        self._objective, self._longest = objective, longest
        self._last: FloatArray | None = None

    def __call__(self, iteration: Iteration) -> bool:
        """Return False when the last step was short, under the final widths."""
        last, self._last = self._last, iteration.coordinates
        if last is None or not self._objective.is_annealed:
            return True
        return bool((np.abs(iteration.coordinates - last) > _NEAR * self._longest).any())
