# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Everything that is measured about one set of parameters, patch by patch and view by view."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.forward.solution import View
from diffcal_ros.calibration.observations.observation import Observation, pose_owners
from diffcal_ros.calibration.parameters.longest_steps import longest_steps
from diffcal_ros.calibration.residuals.objective import RobustObjective
from diffcal_ros.calibration.residuals.residual_scales import Scales
from diffcal_ros.calibration.residuals.robust_residual import (
    Comparison,
    make_comparers,
    Reach,
    ViewComparer,
)
from diffcal_ros.diagnosis.patches.boundary_strip import BoundaryStrip
from diffcal_ros.diagnosis.patches.discretisation_error import (
    DiscretisationError,
    find_discretisation_error,
)
from diffcal_ros.diagnosis.patches.noise_model import noise_of, NoiseModel
from diffcal_ros.diagnosis.patches.patch_group import PatchGroup, PatchName, report_part
from diffcal_ros.diagnosis.patches.patches import depth_patches, edge_patches, Patches
from diffcal_ros.diagnosis.patches.rigid_reference import make_references, RigidReference
from diffcal_ros.diagnosis.patches.roughness import measured_noises
from diffcal_ros.diagnosis.patches.smooth_error import with_smooth_error
from diffcal_ros.least_squares.levenberg_marquardt import minimise
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_ROBUST_STEPS = 15
_FAR_REACH = Reach(depth=0.060, edge_depth=0.090, edge_pixels=60)


class PatchEvaluator:
    """Evaluates patches of one model; see `groups`."""

    def __init__(
        self,
        model: ForwardModel,
        comparers: list[ViewComparer],
        discretisation_error: DiscretisationError,
        cell: int,
        left_out: frozenset[PatchName] = frozenset(),
        references: Sequence[RigidReference | None] = (),
        noises: Sequence[NoiseModel] = (),
        strip: BoundaryStrip | None = None,
    ) -> None:
        """Prepare a model.

        Args:
            model: with its parameters.
            comparers: of its observations.
            discretisation_error: what a finer mesh and time step would change.
            cell: side of the image cells [px].
            left_out: patches that show something else than the body.
            references: the fixture in every view, None where there is none; default: nowhere.
            noises: of every view; default: as far as frames and sensor tell.
            strip: along the border of two materials, which no model is compared in.
        """
        self._strip = strip
        self.left_out = left_out
        self._references = tuple(references) or (None,) * len(comparers)
        self.model = model
        self.comparers = comparers
        self.discretisation_error = discretisation_error
        self.cell = cell
        far = Scales(reach=_FAR_REACH)
        self._objective = RobustObjective(model, comparers=comparers, scales=far)
        self._rigid_objective = RobustObjective(
            model,
            comparers=[
                comparer if reference is None else reference.comparer
                for comparer, reference in zip(comparers, self._references, strict=True)
            ],
        )
        self._recordings = pose_owners(model.observations)
        self._noises = tuple(noises) or tuple(
            _noise(observation, model, reference)
            for observation, reference in zip(model.observations, self._references, strict=True)
        )

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle what it is made of: another process has comparers of its own."""
        known = (self.model, self.discretisation_error, self.cell, self.left_out, self._noises)
        return _put_together, (*known, self._strip is not None)

    @property
    def is_measured(self) -> bool:
        """Tell whether the sensor floor comes from repeated frames."""
        return all(noise.is_measured for noise in self._noises)

    @property
    def stays_robust(self) -> bool:
        """Tell whether the robust fit of pixels stands: what noise to fit patches by is a guess.

        A motion is fitted by patches all the same: a robust fit would see held-out frames.
        """
        return not self.is_measured and not any(
            observation.is_held_out for observation in self.model.observations
        )

    def without_fixture(self, groups: Sequence[PatchGroup]) -> tuple[str, ...]:
        """Return the names of observations that should show the fixture, and do not."""
        shown = {group.view for group in groups if group.is_rigid and len(group.patches.values)}
        return tuple(
            observation.name
            for number, observation in enumerate(self.model.observations)
            if self._references[number] is not None and number not in shown
        )

    def of(self, model: ForwardModel) -> 'PatchEvaluator':
        """Return an evaluator of another model of the same bodies and observations."""
        return self._changed(model=model)

    def renewed(self, coordinates: FloatArray) -> 'PatchEvaluator':
        """Return the same evaluator with the discretisation error as it is somewhere else.

        Args:
            coordinates: where, shape (c,).
        """
        return self._changed(
            discretisation_error=find_discretisation_error(self.model, coordinates)
        )

    def with_measured_noise(self, coordinates: FloatArray) -> 'PatchEvaluator':
        """Return the same evaluator with the noise that single patches show in several poses.

        In one pose, details of that size tell twins apart that a mesh's error has, too: there the
        noise stays as assumed.

        Args:
            coordinates: of the nominal fit, shape (c,).
        """
        seen = self.model.observations
        still = [number for number, one in enumerate(seen) if one.instant is None]
        if not still or len({observation.setup_index for observation in seen}) == 1:
            return self
        groups = self.groups(coordinates)
        return self._changed(noises=measured_noises(self._noises, groups, still))

    def with_smooth_error(
        self, groups: Sequence[PatchGroup], *, is_hidden: bool = False
    ) -> 'PatchEvaluator':
        """Return the same evaluator with the smooth error that several poses at rest show.

        In one pose it is not told from what the model lacks.

        Args:
            groups: of the nominal fit, with tangents of all effects.
            is_hidden: see `smooth_error.with_smooth_error`.
        """
        if not self.tells_smooth_error:
            return self
        still = [n for n, one in enumerate(self.model.observations) if one.instant is None]
        noises = with_smooth_error(self._noises, groups, still, is_hidden=is_hidden)
        return self._changed(noises=noises)

    def with_noise_of(self, other: 'PatchEvaluator') -> 'PatchEvaluator':
        """Return the same evaluator with the noise that another one of the same views believes."""
        return self._changed(noises=other._noises)

    @property
    def noises(self) -> tuple[NoiseModel, ...]:
        """What is believed of the errors of every view."""
        return self._noises

    @property
    def smooth_error(self) -> float:
        """The largest smooth error of depth that is believed of a view [m]."""
        return max(noise.smooth for noise in self._noises)

    @property
    def tells_smooth_error(self) -> bool:
        """Tell whether several poses at rest can show the sensor's smooth error."""
        seen = self.model.observations
        return len({one.setup_index for one in seen if one.instant is None}) > 1

    def without(self, patches: frozenset[PatchName]) -> 'PatchEvaluator':
        """Return the same evaluator with some patches left out."""
        return self._changed(left_out=patches)

    def _changed(
        self,
        *,
        model: ForwardModel | None = None,
        discretisation_error: DiscretisationError | None = None,
        left_out: frozenset[PatchName] | None = None,
        noises: Sequence[NoiseModel] | None = None,
    ) -> 'PatchEvaluator':
        return PatchEvaluator(
            model or self.model,
            self.comparers,
            discretisation_error or self.discretisation_error,
            self.cell,
            self.left_out if left_out is None else left_out,
            self._references,
            noises or self._noises,
            self._strip,
        )

    def robust_fit(self, start: FloatArray) -> FloatArray:
        """Fit as a calibration does, which structured errors and obstacles mislead least.

        Args:
            start: coordinates, shape (c,).

        Raises:
            EquilibriumError: when the start cannot be simulated.
            OutOfViewError: when a camera does not see the body at the start.
        """
        parameters = self.model.parameters
        found = minimise(
            RobustObjective(self.model, comparers=self.comparers),
            start,
            parameters.bounds(),
            longest_steps(parameters),
            max_iterations=_ROBUST_STEPS,
        )
        return found.coordinates

    def comparisons(self, coordinates: FloatArray) -> list[Comparison]:
        """Compare every view with its observation, pixel by pixel."""
        return self._objective.comparisons(coordinates)

    def residual_images(self, coordinates: FloatArray) -> list[FloatArray]:
        """Return measured depth less what the sensor would read [m], shape (H, W) each.

        NaN where either is missing. The fixture is rendered, too.
        """
        compared, images = self.comparisons(coordinates), []
        for number, view in enumerate(self.model.views(coordinates)):
            image = view.trace.in_image(compared[number].difference)
            fixture = self._fixture(number, coordinates)
            if fixture is not None:
                reference, before = fixture
                sensor = self.model.sensor(coordinates, number)
                image = reference.lay_over(image, before, view.trace, sensor)
            images.append(image)
        return images

    def groups(
        self, coordinates: FloatArray, more: Sequence[FloatArray] | None = None
    ) -> list[PatchGroup]:
        """Compare and average.

        Args:
            coordinates: of the model's parameters, shape (c,).
            more: further ways that the points of each view may move [m], camera frame, shape
                (k, N, 3) each; their columns follow those of the parameters.

        Raises:
            EquilibriumError: when a posture has no equilibrium.
            OutOfViewError: when a camera does not see the body.
        """
        model = self.model
        compared = self._objective.comparisons(coordinates)
        tangents = model.tangents(coordinates)
        if more is not None:
            tangents = [np.concatenate(pair) for pair in zip(tangents, more, strict=True)]
        groups = []
        for number, view in enumerate(model.views(coordinates)):
            wide = np.concatenate([tangents[number], self.discretisation_error.columns(number)])
            fixture, body = self._fixture(number, coordinates), compared[number]
            if fixture is not None:
                reference, before = fixture
                body = reference.uncovered(body, before, view.trace)
            inside, outline = self._patches(self._objective, number, body, view, wide, coordinates)
            groups.append(self._group(number, 'depth', self._kept(number, 'depth', inside)))
            groups.append(self._group(number, 'edge', self._kept(number, 'edge', outline)))
            if fixture is not None:
                groups += self._rigid_groups(number, fixture, view, coordinates, len(wide))
        return groups

    def _fixture(self, number: int, coordinates: FloatArray) -> tuple[RigidReference, View] | None:
        """Return the fixture as it is seen in a view; None where it is not."""
        reference = self._references[number]
        view = None if reference is None else reference.view(number, self.model, coordinates)
        return None if reference is None or view is None else (reference, view)

    def _rigid_groups(
        self,
        number: int,
        fixture: tuple[RigidReference, View],
        body: View,
        coordinates: FloatArray,
        count: int,
    ) -> list[PatchGroup]:
        """Compare and average the fixture in a view, before which the body is."""
        reference, view = fixture
        wide = reference.tangents(number, self.model, coordinates, count)
        sensor = self.model.sensor(coordinates, number)
        compared = reference.compare(view, body.trace, _FAR_REACH, sensor)
        inside, outline = self._patches(
            self._rigid_objective, number, compared, view, wide, coordinates
        )
        found = [self._group(number, 'depth', inside), self._group(number, 'edge', outline)]
        # The gap that is reported is the body's.
        return [
            replace(group, is_rigid=True, is_report=np.zeros_like(group.is_report))
            for group in found
        ]

    def _patches(
        self,
        objective: RobustObjective,
        number: int,
        compared: Comparison,
        view: View,
        wide: FloatArray,
        coordinates: FloatArray,
    ) -> tuple[Patches, Patches]:
        """Average one view's comparison; return patches of depth and of outline."""
        (depth, by_depth), (edge, by_edge) = objective.with_jacobians(
            number, compared, view, wide, coordinates
        )
        if self._strip is not None and objective is self._objective:
            clear = self._strip.without(number, view, depth)
            depth, by_depth = depth.chosen(clear), by_depth[clear]
        noise = self._noises[number]
        doubt = objective.comparers[number].edge_doubt(view, edge.indices)
        return (
            depth_patches(depth, by_depth, noise, self.cell),
            edge_patches(edge, by_edge, compared.edge_scale, doubt, noise, self.cell),
        )

    def _group(self, view: int, kind: str, wide: Patches) -> PatchGroup:
        expected, spread, doubt = wide.jacobian[:, -3:].T
        patches = replace(
            wide, values=wide.values - expected, jacobian=wide.jacobian[:, :-3]
        ).doubted(np.abs(doubt))
        is_report = report_part(self.model.observations[view], wide.cells)
        return PatchGroup(view, kind, self._recordings[view], patches, spread, is_report)

    def _kept(self, view: int, kind: str, patches: Patches) -> Patches:
        if not self.left_out:
            return patches
        kept = np.array([(view, kind, int(c)) not in self.left_out for c in patches.cells], bool)
        return patches.chosen(kept)


def _noise(
    observation: Observation, model: ForwardModel, reference: RigidReference | None
) -> NoiseModel:
    """Return an observation's noise; a fixture has its smooth errors in common with the body."""
    noise = noise_of(observation, observation.sensor or model.scene.sensor)
    return noise if reference is None else replace(noise, common=1.0)


def _put_together(
    model: ForwardModel,
    discretisation_error: DiscretisationError,
    cell: int,
    left_out: frozenset[PatchName],
    noises: Sequence[NoiseModel],
    has_strip: bool,
) -> PatchEvaluator:
    comparers = make_comparers(model)
    return PatchEvaluator(
        model,
        comparers,
        discretisation_error,
        cell,
        left_out,
        make_references(model),
        noises,
        BoundaryStrip(model, comparers) if has_strip else None,
    )
