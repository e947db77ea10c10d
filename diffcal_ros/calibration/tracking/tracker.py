# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Follow the parameters of a body from frame to frame, after a fit has found them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.parameters.longest_steps import longest_steps
from diffcal_ros.calibration.parameters.parameters import Kind, ParameterSet
from diffcal_ros.calibration.residuals.gap import Gap
from diffcal_ros.calibration.residuals.residual_scales import Scales
from diffcal_ros.calibration.result import FittedParameter
from diffcal_ros.calibration.search.basins import Basin
from diffcal_ros.calibration.search.global_search import can_search, GlobalSearch
from diffcal_ros.calibration.tracking.body_change import BodyChange, ChangeWatch
from diffcal_ros.calibration.tracking.body_search import find_body, find_body_anywhere, FOUND
from diffcal_ros.calibration.tracking.forgetting_filter import ForgettingFilter
from diffcal_ros.calibration.tracking.innovation import Innovation
from diffcal_ros.calibration.tracking.linearised_view import FrameEquations, HeldView
from diffcal_ros.calibration.uncertainty.fitted_parameters import fitted_parameters
from diffcal_ros.calibration.uncertainty.uncertainty import estimate_uncertainty, MESH_SHIFT_FACTOR
from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.errors import InputError, NotSimulatedError
from diffcal_ros.least_squares.gauss_newton import gauss_newton_step
from diffcal_ros.least_squares.normal_equations import Linearisation, NormalEquations
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# The view is rendered anew when an estimate is farther from it than this share of the longest
# step, 0.3 % of a modulus: what is left of the sag's curvature is far below the sensor's noise.
_HELD = 0.004
# The sensor's bias of edges enters linearly, and differs between one frame and many fused (here as
# a share of 2 px): it alone is no reason to render anew, and tells nothing of the body.
_HELD_BIAS = 0.05
# Nor are so many standard errors: what is left of the curvature is far below them. At most 2 % of
# a modulus.
_HELD_ERRORS, _HELD_MOST = 3.0, 0.03
# A frame that pulls farther than this (5 % of a modulus), costs so many times the usual or hardly
# shows the body is not explained near here: residuals lie in the tails of the robust cost, where
# one step does not get far. It takes several such frames in a row to believe them.
_FAR = 0.07
_DEAR = 2.0
_BELIEVED = 6
_SETTLED = 8  # Frames after a fit or a search that have done the rest.
_COST_SHARE = 0.05
# How often a search is tried while the body is not found [ns].
_RETRY = 1_000_000_000
_MOST_REFINEMENTS = 4
_LOOKING = 1_000_000_000  # Between two looks at what lies beside the body [ns].
_INFORMING = 15  # Frames between two looks at how sure a frame is.
_LONGEST = 0.7  # Step of the logarithm of a modulus.
_FRESH = 4.0  # Frames that an estimate must be worth before a change is told.


@dataclass(frozen=True)
class TrackerSettings:
    """How to follow.

    Attributes:
        memory: age at which a frame weighs 1/e of the newest [s].
        change: relative change of a modulus or density that is told; other parameters in
            proportion to their longest steps.
    """

    memory: float = 0.5
    change: float = 0.05

    def __post_init__(self) -> None:
        if not self.memory > 0.0 or not self.change > 0.0:
            raise InputError(
                f'memory is {self.memory:g} s and the change to tell {self.change:g}: give '
                'positive numbers'
            )


@dataclass(frozen=True)
class Tracked:
    """What is known after a frame.

    Attributes:
        stamp_ns: of the frame [ns].
        parameters: values and standard errors.
        correlation: of the parameters' coordinates, shape (k, k).
        cost: half chi-square of the frame.
        gap: of the last frame whose gap was measured.
        frames_worth: equally weighted frames that would average as well.
        is_found: the body is where the model says; else the parameters are the last known.
        is_taken: the frame was used; else it contradicts all others, so far.
        change: what it showed, or None.
    """

    stamp_ns: int
    parameters: tuple[FittedParameter, ...]
    correlation: FloatArray
    cost: float
    gap: Gap
    frames_worth: float
    is_found: bool
    is_taken: bool
    change: BodyChange | None

    def values(self) -> dict[str, float]:
        """Return the asked-for parameters in SI units by name."""
        return {p.name: p.value for p in self.parameters if not p.is_nuisance}


def least_changes(parameters: ParameterSet, change: float) -> FloatArray:
    """Return the change of each coordinate that is told, shape (k,).

    Args:
        parameters: what the coordinates mean.
        change: the same as a relative change of a modulus.
    """
    return change * longest_steps(parameters) / _LONGEST


class Tracker:
    """Follows one body in one view."""

    def __init__(
        self,
        calibration: Calibration,
        fitted: Sequence[FittedParameter],
        settings: TrackerSettings | None = None,
    ) -> None:
        """Start from a fit.

        Args:
            calibration: of one observation, with the robust loss; it is the tracker's from now
                on.
            fitted: what a fit of the same parameters found.
            settings: how to follow.

        Raises:
            InputError: for several observations, or another loss.
        """
        count = len(calibration.model.observations)
        if count != 1:
            raise InputError(
                f'{count} observations cannot be followed from frame to frame: give only one'
            )
        self.settings = settings or TrackerSettings()
        self._objective = calibration.likelihood('following a body from frame to frame')
        self._parameters = calibration.parameters
        self._bounds = self._parameters.bounds()
        self._longest = longest_steps(self._parameters)
        self._least_reach, self._far = _HELD * self._longest, _FAR * self._longest
        bias = self._parameters.find(Kind.EDGE_BIAS)
        self._least_reach[bias] = _HELD_BIAS * self._longest[bias]
        self._far[bias] = np.inf
        self._reach = self._least_reach
        self._prior = self._parameters.prior()
        self._mesh_shares = np.array(
            [
                found.mesh_error / (found.value if parameter.is_logarithmic else 1.0)
                for parameter, found in zip(self._parameters, fitted, strict=True)
            ]
        )
        self._filter = ForgettingFilter(len(self._parameters), self.settings.memory)
        self._innovation = Innovation()
        self.coordinates = np.array(
            [p.coordinate(found.value) for p, found in zip(self._parameters, fitted, strict=True)]
        )
        self._watch = ChangeWatch(
            self._parameters,
            self.coordinates,
            least_changes(self._parameters, self.settings.change),
        )
        self._held: HeldView | None = None
        self._information: Linearisation | None = None
        self._gap = Gap(float('nan'), float('nan'), 0.0, 0)
        self._is_found = True
        self._strange_count = 0
        self._usual_cost: float | None = None
        self._since_informed = 0
        self._next_search_ns = self._thorough_until_ns = self._next_look_ns = 0
        self._is_rough = True
        self._stage: GlobalSearch | None = None
        self.search_count = 0

    @property
    def held(self) -> HeldView:
        """The view in use.

        Raises:
            RuntimeError: before the first frame.
        """
        if self._held is None:
            raise RuntimeError('nothing was followed yet: call follow first')
        return self._held

    def forget(self) -> None:
        """Forget all frames, not what they said: another stretch of the stream begins."""
        self._filter.clear()
        self._strange_count = 0
        self._next_search_ns = self._thorough_until_ns = self._next_look_ns = 0

    def follow(self, frame: DepthFrame) -> Tracked:
        """Take a frame; its stamp must not lie before the last one's.

        Raises:
            InputError: when the fitted values cannot be simulated.
        """
        if self._held is None:
            self._begin(frame)
        seen = self.held.look(frame.depth)
        is_taken = not self._is_strange(seen)
        if is_taken:
            self._strange_count = 0
        else:
            self._strange_count += 1
            is_taken = self._is_search_due(frame) and self._search(frame)
            seen = self.held.look(frame.depth) if is_taken else seen
        if is_taken:
            self._take(frame, seen.equations)
        return self._told(frame, seen.equations.cost, is_taken)

    def _begin(self, frame: DepthFrame) -> None:
        """Weigh residuals by what one frame shows; the fit saw many fused."""
        (comparer,) = self._objective.comparers
        comparer.show(frame.depth)
        try:
            self._weigh(self.coordinates)
            self._hold(self.coordinates, frame)
        except NotSimulatedError as error:
            raise InputError(f'the fitted values cannot be simulated: {error}') from error

    def _weigh(self, coordinates: FloatArray) -> None:
        """Weigh residuals by what the last frame shows there."""
        self._objective.scales = Scales()
        while not self._objective.is_sharp:
            self._objective.narrow(coordinates)
        self._refine_at(coordinates)

    def _refine_at(self, coordinates: FloatArray) -> None:
        for _ in range(_MOST_REFINEMENTS):
            if not self._objective.refine(coordinates):
                return

    def _hold(self, coordinates: FloatArray, frame: DepthFrame) -> None:
        self._held = HeldView(self._objective, coordinates)
        self.coordinates = coordinates.copy()
        self._inform(frame)
        assert self._information is not None
        self._innovation.hold(self._information.scatter)

    def _inform(self, frame: DepthFrame) -> None:
        self._information = self.held.inform(frame.depth)
        # What lies beside the body takes longer to look for than all else, and changes slowly.
        is_due = frame.stamp_ns >= self._next_look_ns
        gap = self.held.gap(frame.depth, is_both_ways=is_due)
        if is_due:
            self._next_look_ns = frame.stamp_ns + _LOOKING
        else:
            gap = replace(gap, explained=self._gap.explained, hidden=self._gap.hidden)
        self._gap = gap
        self._since_informed = 0

    def _is_strange(self, frame: FrameEquations) -> bool:
        """Tell whether a frame is not explained near here."""
        if frame.coverage < FOUND:
            return True
        if self._usual_cost is not None and frame.equations.cost > _DEAR * self._usual_cost:
            return True
        step = self._step_from(frame.equations)
        return bool((np.abs(step) > self._far).any())

    def _is_search_due(self, frame: DepthFrame) -> bool:
        return self._strange_count >= _BELIEVED and frame.stamp_ns >= self._next_search_ns

    def _take(self, frame: DepthFrame, equations: NormalEquations) -> None:
        self._is_found = True
        share = 0.0
        if self._filter.count:
            before = self._filter.equations
            share = self._innovation.least_share(equations.descent - before.descent)
        self._filter.add(equations, frame.stamp_ns, share)
        usual = equations.cost if self._usual_cost is None else self._usual_cost
        self._usual_cost = usual + _COST_SHARE * (equations.cost - usual)
        self._step(frame)
        if self._is_rough and self._filter.count >= _SETTLED:
            self._weigh_anew(frame)

    def _search(self, frame: DepthFrame) -> bool:
        """Forget the past and fit one frame from where we are; return whether that was found."""
        self.search_count += 1
        self._next_search_ns = frame.stamp_ns + _RETRY
        self._filter.clear()
        self._is_found = False
        scales = self._objective.scales
        self._objective.scales = Scales()
        is_brief = frame.stamp_ns >= self._thorough_until_ns
        found = find_body(
            self._objective, self.coordinates, self._bounds, self._longest, is_brief=is_brief
        )
        found = find_body_anywhere(
            self._objective,
            lambda: self._basins(frame),
            self._bounds,
            self._longest,
            found,
        )
        if found is None:
            self._objective.scales = scales
            return False
        if is_brief:
            # Where the model cannot show the body, only the minimum itself keeps frames near.
            self._thorough_until_ns = frame.stamp_ns + 2 * _RETRY
            self._next_search_ns = 0
        self._is_rough = True
        self._refine_at(found)
        self._strange_count, self._usual_cost = 0, None
        self._watch.is_sudden = True
        self._hold(found, frame)
        return True

    def _basins(self, frame: DepthFrame) -> list[Basin]:
        """Return where on the whole range the body of a frame may be, the best first."""
        model = self._objective.model
        if not can_search(model):
            return []
        if self._stage is None:
            self._stage = GlobalSearch(model, self.coordinates)
        self._stage.look_at([frame.depth])
        return self._stage.basins()

    def _weigh_anew(self, frame: DepthFrame) -> None:
        """Weigh residuals once more where frames have carried on a fit or a search.

        What is left at its end is alike over many pixels, and would count as the sensor's.
        """
        self._is_rough = False
        scales = self._objective.scales
        try:
            self._weigh(self.coordinates)
            self._hold(self.coordinates, frame)
        except NotSimulatedError:
            self._objective.scales = scales
            return
        self._usual_cost = None
        self._filter.clear()
        self._filter.add(self.held.look(frame.depth).equations, frame.stamp_ns, 0.0)

    def _step(self, frame: DepthFrame) -> None:
        """Go to where the filter says; render anew when that is far from the held view."""
        here = self.held.coordinates
        step = self._step_from(self._filter.equations)
        step /= max(1.0, float((np.abs(step) / self._longest).max()))
        there = np.clip(here + step, *self._bounds)
        self.coordinates = there
        self._since_informed += 1
        if (np.abs(there - here) > self._reach).any():
            try:
                self._hold(there, frame)
            except NotSimulatedError:
                self.coordinates = here
                return
            self._filter.move(there - here)
        elif self._since_informed >= _INFORMING:
            self._inform(frame)

    def _step_from(self, data: NormalEquations) -> FloatArray:
        here = self.held.coordinates
        return gauss_newton_step(data.under(self._prior, here), here, *self._bounds)

    def _told(self, frame: DepthFrame, cost: float, is_taken: bool) -> Tracked:
        assert self._information is not None
        worth = max(1.0, self._filter.frames_worth)
        # What is new in every frame averages out, structure that stays does not.
        new = min(1.0, self._innovation.new_share)
        scatter = self._information.scatter * (1.0 - new + new / worth)
        uncertainty = estimate_uncertainty(
            replace(self._information, scatter=scatter),
            self._parameters,
            self._mesh_shares / MESH_SHIFT_FACTOR,
        )
        errors = _HELD_ERRORS * np.sqrt(np.maximum(np.diag(uncertainty.statistical), 0.0))
        most = np.maximum(_HELD_MOST * self._longest, self._least_reach)
        self._reach = np.clip(errors, self._least_reach, most)
        return Tracked(
            stamp_ns=frame.stamp_ns,
            parameters=fitted_parameters(self._parameters, self.coordinates, uncertainty),
            correlation=uncertainty.correlation,
            cost=cost,
            gap=self._gap,
            frames_worth=self._filter.frames_worth,
            is_found=self._is_found,
            is_taken=is_taken,
            change=self._changed(frame, uncertainty.statistical) if is_taken else None,
        )

    def _changed(self, frame: DepthFrame, covariance: FloatArray) -> BodyChange | None:
        """Look for a change, once there are frames enough to tell."""
        if self._filter.frames_worth < _FRESH and self._filter.count < _FRESH:
            return None
        errors = np.sqrt(np.maximum(np.diag(covariance), 0.0))
        return self._watch.look(frame.stamp_ns, self.coordinates, errors, self._gap.median)
