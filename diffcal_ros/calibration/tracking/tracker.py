# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Follow the parameters of a body from frame to frame, after a fit has found them."""

from collections.abc import Sequence
from dataclasses import replace

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.parameters.longest_steps import longest_steps
from diffcal_ros.calibration.parameters.parameters import Kind
from diffcal_ros.calibration.results.fitted_parameters import fitted_parameters
from diffcal_ros.calibration.results.result import FittedParameter
from diffcal_ros.calibration.tracking.body_change import BodyChange, ChangeWatch
from diffcal_ros.calibration.tracking.body_search import BodySearch, FOUND
from diffcal_ros.calibration.tracking.current_view import CurrentView
from diffcal_ros.calibration.tracking.forgetting_filter import ForgettingFilter
from diffcal_ros.calibration.tracking.innovation import Innovation
from diffcal_ros.calibration.tracking.linearised_view import FrameEquations, LinearisedView
from diffcal_ros.calibration.tracking.tracked import least_changes, Tracked, TrackerSettings
from diffcal_ros.calibration.uncertainty.uncertainty import estimate_uncertainty, MESH_SHIFT_FACTOR
from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.errors import InputError, NotSimulatedError
from diffcal_ros.least_squares.gauss_newton import gauss_newton_step
from diffcal_ros.least_squares.normal_equations import NormalEquations
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
_COST_FRACTION = 0.05
_FRESH = 4.0  # Frames that an estimate must be worth before a change is told.


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
        self._mesh_fractions = np.array(
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
        self._body_search = BodySearch(self._objective)
        self._current: CurrentView | None = None
        self._is_found = True
        self._strange_count = 0
        self._usual_cost: float | None = None
        self._is_rough = True

    @property
    def search_count(self) -> int:
        """Searches for a body that was lost."""
        return self._body_search.count

    @property
    def view(self) -> LinearisedView:
        """The view in use.

        Raises:
            RuntimeError: before the first frame.
        """
        return self._known.view

    @property
    def _known(self) -> CurrentView:
        if self._current is None:
            raise RuntimeError('nothing was followed yet: call follow first')
        return self._current

    def forget(self) -> None:
        """Forget all frames, not what they said: another stretch of the stream begins."""
        self._filter.clear()
        self._strange_count = 0
        self._body_search.forget()
        if self._current is not None:
            self._current.look_beside_soon()

    def follow(self, frame: DepthFrame) -> Tracked:
        """Take a frame; its stamp must not lie before the last one's.

        Raises:
            InputError: when the fitted values cannot be simulated.
        """
        if self._current is None:
            self._begin(frame)
        seen = self.view.look(frame.depth)
        is_taken = not self._is_strange(seen)
        if is_taken:
            self._strange_count = 0
        else:
            self._strange_count += 1
            is_due = self._strange_count >= _BELIEVED and self._body_search.is_due(frame)
            is_taken = is_due and self._search(frame)
            seen = self.view.look(frame.depth) if is_taken else seen
        if is_taken:
            self._take(frame, seen.equations)
        return self._told(frame, seen.equations.cost, is_taken)

    def _begin(self, frame: DepthFrame) -> None:
        """Weigh residuals by what one frame shows; the fit saw many fused."""
        try:
            self._current = CurrentView(self._objective, self.coordinates, frame)
        except NotSimulatedError as error:
            raise InputError(f'the fitted values cannot be simulated: {error}') from error
        self._measure_innovation()

    def _measure_innovation(self) -> None:
        """Measure surprises by how a frame scatters where the view was rendered."""
        self.coordinates = self.view.coordinates.copy()
        self._innovation.hold(self._known.information.gradient_covariance)

    def _is_strange(self, frame: FrameEquations) -> bool:
        """Tell whether a frame is not explained near here."""
        if frame.coverage < FOUND:
            return True
        if self._usual_cost is not None and frame.equations.cost > _DEAR * self._usual_cost:
            return True
        step = self._step_from(frame.equations)
        return bool((np.abs(step) > self._far).any())

    def _take(self, frame: DepthFrame, equations: NormalEquations) -> None:
        self._is_found = True
        fraction = 0.0
        if self._filter.count:
            before = self._filter.equations
            fraction = self._innovation.least_fraction(
                equations.negative_gradient - before.negative_gradient
            )
        self._filter.add(equations, frame.stamp_ns, fraction)
        usual = equations.cost if self._usual_cost is None else self._usual_cost
        self._usual_cost = usual + _COST_FRACTION * (equations.cost - usual)
        self._step(frame)
        if self._is_rough and self._filter.count >= _SETTLED:
            self._weigh_anew(frame)

    def _search(self, frame: DepthFrame) -> bool:
        """Forget the past and fit one frame from where we are; return whether that was found."""
        self._filter.clear()
        self._is_found = False
        found = self._body_search.find(frame, self.coordinates)
        if found is None:
            return False
        self._is_rough = True
        self._strange_count, self._usual_cost = 0, None
        self._watch.is_sudden = True
        self._known.weigh_by(found.scales, found.coordinates, frame)
        self._measure_innovation()
        return True

    def _weigh_anew(self, frame: DepthFrame) -> None:
        """Weigh residuals once more where frames have carried on a fit or a search.

        What is left at its end is alike over many pixels, and would count as the sensor's.
        """
        self._is_rough = False
        try:
            self._known.weigh_anew(self.coordinates, frame)
        except NotSimulatedError:
            return
        self._measure_innovation()
        self._usual_cost = None
        self._filter.clear()
        self._filter.add(self.view.look(frame.depth).equations, frame.stamp_ns, 0.0)

    def _step(self, frame: DepthFrame) -> None:
        """Go to where the filter says; render anew when that is far from the view in use."""
        here = self.view.coordinates
        step = self._step_from(self._filter.equations)
        step /= max(1.0, float((np.abs(step) / self._longest).max()))
        there = np.clip(here + step, *self._bounds)
        if not (np.abs(there - here) > self._reach).any():
            self.coordinates = there
            self._known.grow_older(frame)
            return
        try:
            self._known.render(there, frame)
        except NotSimulatedError:
            self.coordinates = here
            return
        self._measure_innovation()
        self._filter.move(there - here)

    def _step_from(self, data: NormalEquations) -> FloatArray:
        here = self.view.coordinates
        return gauss_newton_step(data.under(self._prior, here), here, *self._bounds)

    def _told(self, frame: DepthFrame, cost: float, is_taken: bool) -> Tracked:
        information = self._known.information
        worth = max(1.0, self._filter.frames_worth)
        # What is new in every frame averages out, structure that stays does not.
        new = min(1.0, self._innovation.new_fraction)
        covariance = information.gradient_covariance * (1.0 - new + new / worth)
        uncertainty = estimate_uncertainty(
            replace(information, gradient_covariance=covariance),
            self._parameters,
            self._mesh_fractions / MESH_SHIFT_FACTOR,
        )
        errors = _HELD_ERRORS * np.sqrt(np.maximum(np.diag(uncertainty.statistical), 0.0))
        most = np.maximum(_HELD_MOST * self._longest, self._least_reach)
        self._reach = np.clip(errors, self._least_reach, most)
        return Tracked(
            stamp_ns=frame.stamp_ns,
            parameters=fitted_parameters(self._parameters, self.coordinates, uncertainty),
            correlation=uncertainty.correlation,
            cost=cost,
            gap=self._known.gap,
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
        return self._watch.look(frame.stamp_ns, self.coordinates, errors, self._known.gap.median)
