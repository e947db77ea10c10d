# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The fixture as a camera sees it: what moves it is the camera or its readings, not the body.

With one pose a camera that is elsewhere and a body that sits elsewhere in its clamp are the same
to every pixel of the body, and a depth that is read too far nearly is. A rigid part in view parts
them: no load, clamp or material moves it. Where it is beside the body is itself known to about a
millimetre only, the same one in all poses: a nuisance of the model.
"""

from dataclasses import replace

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.forward.sensor_model import SensorModel, SurfacePlaces
from diffcal_ros.calibration.forward.solution import View
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.calibration.observations.pixel_masks import pixels_left_out, ViewMask
from diffcal_ros.calibration.parameters.fixture_offset import fixture_offset_parameters
from diffcal_ros.calibration.parameters.parameters import Kind, ParameterSet
from diffcal_ros.calibration.residuals.robust_residual import (
    Comparison,
    Reach,
    Residuals,
    ViewComparer,
)
from diffcal_ros.depth.trace import Trace
from diffcal_ros.depth.tracer import DepthTracer, OutOfViewError
from diffcal_ros.effects.registry import edge_seen
from diffcal_ros.rigid_motion import moved, moved_by
from diffcal_ros.rigid_transform import apply
from diffcal_ros.scene.model import Fixture, Scene
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation

BoolArray = NDArray[np.bool_]
FloatArray = NDArray[np.float64]

# So near to the body a pixel may be the body's, and an edge is not found [px].
_BESIDE, _BESIDE_EDGE = 4, 10
# So near to where the fixture hides the body a pixel shows both [px].
_COVERED = 1


class RigidReference:
    """The fixture before one observation's camera."""

    def __init__(self, scene: Scene, fixture: Fixture, observation: Observation) -> None:
        """Prepare its surface.

        Args:
            scene: with masks and the posture of the observation.
            fixture: of the scene.
            observation: what was seen.
        """
        self._seen = observation.depth
        self._placed = scene.observations[observation.setup_index].world_from_object
        self._positions, self._middle = fixture.positions, fixture.positions.mean(axis=0)
        self._tracer = DepthTracer(fixture.triangles, len(fixture.positions), observation.camera)
        no_triangle = np.zeros(len(fixture.triangles), dtype=bool)
        no_edge = np.zeros(len(self._tracer.edge_vertices), dtype=bool)
        mask = ViewMask(pixels_left_out(observation, scene.masks), no_triangle, no_edge)
        edge = edge_seen(scene.effects, observation.setup_index)
        surface = SurfacePlaces(no_triangle, edge=edge)
        self.comparer = ViewComparer(observation, self._tracer, mask, scene.masks, 'cpu', surface)

    def view(self, number: int, model: ForwardModel, coordinates: FloatArray) -> View | None:
        """Return the fixture as a model predicts it; None where the camera does not see it.

        Args:
            number: of the observation.
            model: whose cameras look.
            coordinates: of its parameters, shape (c,).
        """
        world = self._world(fixture_offset(model.parameters, coordinates))
        view = View(model.cameras.points(number, world, coordinates), self._tracer)
        try:
            view.trace  # noqa: B018  It is traced when it is first asked for.
        except OutOfViewError:
            return None
        return view

    def tangents(
        self, number: int, model: ForwardModel, coordinates: FloatArray, count: int
    ) -> FloatArray:
        """Return how its corners follow the parameters, and that nothing else moves them.

        Args:
            number: of the observation.
            model: whose cameras look.
            coordinates: of its parameters, shape (c,).
            count: of rows, those of what moves the body alone included.

        Returns:
            Camera frame [m], shape (count, V, 3).
        """
        offset = fixture_offset(model.parameters, coordinates)
        world = self._world(offset)
        tangents = np.zeros((count, *world.shape))
        for index, motion in model.cameras.motions(number, world, coordinates).items():
            tangents[index] = motion
        for index, parameter in enumerate(model.parameters):
            if parameter.kind is Kind.FIXTURE_OFFSET:
                own = moved_by(self._positions, offset, self._middle, parameter.axis)
                own = own @ self._placed[:3, :3].T
                tangents[index] = model.cameras.carried(number, world, own, coordinates)
        return tangents

    def _world(self, offset: FloatArray) -> FloatArray:
        return apply(self._placed, moved(self._positions, offset, self._middle))

    def lay_over(
        self, residuals: FloatArray, view: View, body: Trace, sensor: SensorModel
    ) -> FloatArray:
        """Return a residual image of the body with the fixture's where that is before it.

        Args:
            residuals: measured depth less what the sensor would read [m], shape (H, W).
            view: of the fixture.
            body: traced in the same image.
            sensor: how the camera reads.
        """
        depth = view.trace.in_image(self.comparer.read(view.trace, sensor))
        hides = np.isfinite(depth) & ~_in_front(body, view.trace)
        return np.where(hides, self._seen - depth, residuals)

    def compare(self, view: View, body: Trace, reach: Reach, sensor: SensorModel) -> Comparison:
        """Compare the fixture with what was seen of it, away from the body.

        Args:
            view: of the fixture.
            body: traced in the same image.
            reach: how far to look.
            sensor: how the camera reads.
        """
        compared = self.comparer.compare(view, reach, sensor)
        before = _in_front(body, view.trace)
        return _beside(compared, _widened(before, _BESIDE), _widened(before, _BESIDE_EDGE))

    def uncovered(self, compared: Comparison, view: View, body: Trace) -> Comparison:
        """Return a comparison of the body without what the fixture hides of it.

        A clamp that is a little wider than the body covers a strip of it: what is seen there is
        the clamp, some tenths of a millimetre nearer, and which pixels these are changes step by
        step as the body moves beneath it.

        Args:
            compared: the body with what was seen.
            view: of the fixture.
            body: traced in the same image.
        """
        hidden = np.isfinite(view.trace.full_depth()) & ~_in_front(body, view.trace)
        return _beside(compared, _widened(hidden, _COVERED), _widened(hidden, _BESIDE))


def with_fixture_offset(
    model: ForwardModel, coordinates: FloatArray
) -> tuple[ForwardModel, FloatArray]:
    """Let the fixture be a little off where it is stated, where bodies at rest are seen beside it.

    Args:
        model: of a scene.
        coordinates: of its parameters, shape (c,).

    Returns:
        A model with six parameters more, and the coordinates with these at zero.
    """
    if not any(_shows_fixture(model, observation) for observation in model.observations):
        return model, coordinates
    more = fixture_offset_parameters()
    known = model.parameters
    parameters = ParameterSet((*known.parameters, *more), known.pose_covariances)
    return model.with_parameters(model.scene, parameters), np.append(coordinates, np.zeros(6))


def fixture_offset(parameters: ParameterSet, coordinates: FloatArray) -> FloatArray:
    """Return how far a fixture is from where it is stated, object frame [m, rad], shape (6,)."""
    return parameters.twist(Kind.FIXTURE_OFFSET, coordinates)


def make_references(model: ForwardModel) -> tuple[RigidReference | None, ...]:
    """Prepare the scene's fixture before the camera of every observation of a body at rest.

    None where there is no fixture, and for the frames of a motion.
    """
    fixture = model.scene.fixture
    return tuple(
        RigidReference(model.scene, fixture, observation)
        if fixture is not None and _shows_fixture(model, observation)
        else None
        for observation in model.observations
    )


def _shows_fixture(model: ForwardModel, observation: Observation) -> bool:
    return model.scene.fixture is not None and observation.instant is None


def _in_front(body: Trace, fixture: Trace) -> BoolArray:
    """Tell which pixels of the image show the body, and not the fixture before it, (H, W)."""
    far = np.nan_to_num(fixture.full_depth(), nan=np.inf)
    near: BoolArray = body.full_depth() < far
    return near


def _widened(marks: BoolArray, reach: int) -> BoolArray:
    """Mark what is within so many steps between neighbours of a marked pixel, shape (H, W)."""
    found = np.zeros_like(marks)
    rows, columns = (np.flatnonzero(marks.any(axis=axis)) for axis in (1, 0))
    if len(rows):
        # The rest of the image is most of it.
        near = tuple(slice(max(s[0] - reach, 0), s[-1] + reach + 1) for s in (rows, columns))
        found[near] = binary_dilation(marks[near], iterations=reach)
    return found


def _off(residuals: Residuals, marks: BoolArray) -> BoolArray:
    """Tell which residuals lie on no marked pixel of the image, shape (M,)."""
    columns, rows = residuals.pixels.T
    height, width = marks.shape
    found: BoolArray = ~marks[np.clip(rows, 0, height - 1), np.clip(columns, 0, width - 1)]
    return found


def _beside(compared: Comparison, inside: BoolArray, outline: BoolArray) -> Comparison:
    """Leave out what lies on marked pixels of the image, inside and on the outline."""
    depth, edge = _off(compared.depth, inside), _off(compared.edge, outline)
    return replace(
        compared,
        depth=compared.depth.chosen(depth),
        edge=compared.edge.chosen(edge),
        edge_scale=compared.edge_scale[edge],
    )
