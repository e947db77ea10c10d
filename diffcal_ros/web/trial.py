# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body simulated as it is arranged, and fitted from there."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.calibration.residuals.gap import Gap
from diffcal_ros.calibration.results.result import CalibrationResult, IterationRecord
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.errors import InputError, NotSimulatedError
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.rigid_transform import apply, inverse
from diffcal_ros.scene.model import Scene
from diffcal_ros.web.arrangement import Arrangement
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]
BoolArray = NDArray[np.bool_]

_MODULUS = 'youngs_modulus'
_SETTINGS = CalibrationSettings(with_mesh_error=False, search=False)
# Linear elements lock near one half; a lower ratio bends a body much the same.
_COARSE_RATIO = 0.4


@dataclass(frozen=True)
class SimulatedBody:
    """A body at rest as it was arranged, as the first camera has it.

    Attributes:
        vertices: object frame [m], shape (N, 3).
        triangles: of its surface, outward, shape (F, 3).
        is_held: whether the clamp holds a node, shape (N,).
        gap: to what was measured; None where the camera does not see the body.
    """

    vertices: FloatArray
    triangles: IntArray
    is_held: BoolArray
    gap: Gap | None


@dataclass(frozen=True)
class FittedTrial:
    """A fit from an arrangement.

    Attributes:
        result: of it.
        arrangement: where the body is in the first camera's view, and its modulus.
        body: there.
    """

    result: CalibrationResult
    arrangement: Arrangement
    body: SimulatedBody


class Trial:
    """Simulates and fits what a person arranges."""

    def __init__(self, scene: Scene, observations: Sequence[Observation]) -> None:
        """Remember what was measured.

        Args:
            scene: of one region, whose gravity is that of the world.
            observations: of one posture; all are fitted, the first one is compared with.
        """
        self.scene, self.observations = scene, tuple(observations)
        # The last one with the scene's elements: another modulus needs no new body.
        self._last: tuple[Arrangement, Calibration] | None = None

    def simulate(self, arrangement: Arrangement, *, is_coarse: bool) -> SimulatedBody:
        """Simulate the body as it is arranged.

        Args:
            arrangement: without a problem, see `Arrangement.problem`.
            is_coarse: linear elements, which are quick and too stiff; else the scene's own.

        Raises:
            InputError: when the body has no equilibrium there.
        """
        calibration = self._coarse(arrangement) if is_coarse else self._fine(arrangement)
        coordinates = calibration.coordinates.copy()
        (index,) = (n for n, own in enumerate(calibration.parameters) if own.name == _MODULUS)
        parameter = calibration.parameters.parameters[index]
        coordinates[index] = parameter.coordinate(arrangement.youngs_modulus)
        return _body(calibration, coordinates, arrangement.world_from_object)

    def fit(
        self,
        arrangement: Arrangement,
        on_iteration: Callable[[IterationRecord], bool] | None = None,
    ) -> FittedTrial:
        """Fit modulus and offset from where the body is arranged, with the scene's elements.

        Args:
            arrangement: where the fit starts.
            on_iteration: told of every step; returns False to stop.

        Raises:
            InputError: when the body cannot be simulated or seen there.
        """
        calibration = Calibration(arrangement.scene(self.scene), self.observations, _SETTINGS)
        result = calibration.run(on_iteration)
        first = calibration.model.observations[0]
        seen = calibration.model.cameras.pose(0, calibration.coordinates)
        moved = inverse(first.depth_from_world) @ seen @ arrangement.world_from_object
        fitted = Arrangement(moved, arrangement.hold, result[_MODULUS].value)
        return FittedTrial(result, fitted, _body(calibration, calibration.coordinates, moved))

    def _coarse(self, arrangement: Arrangement) -> Calibration:
        scene = arrangement.scene(self.scene)
        region = scene.regions[0]
        ratio = min(region.poissons_ratio.start, _COARSE_RATIO)
        softened = replace(region, poissons_ratio=replace(region.poissons_ratio, start=ratio))
        coarse = replace(scene, element=Element.LINEAR, regions=(softened,))
        return Calibration(coarse, self.observations[:1], _SETTINGS)

    def _fine(self, arrangement: Arrangement) -> Calibration:
        if self._last is not None:
            known, calibration = self._last
            is_there = np.array_equal(known.world_from_object, arrangement.world_from_object)
            if is_there and known.hold is arrangement.hold:
                return calibration
        self._last = None  # Two bodies at once are of no use.
        calibration = Calibration(arrangement.scene(self.scene), self.observations[:1], _SETTINGS)
        self._last = arrangement, calibration
        return calibration


def _body(
    calibration: Calibration, coordinates: FloatArray, world_from_object: FloatArray
) -> SimulatedBody:
    """Return the body of the first observation in the object frame, and the gap.

    Raises:
        InputError: when it has no equilibrium.
    """
    model = calibration.model
    first = model.observations[0]
    try:
        points = model.views(coordinates)[0].points
    except NotSimulatedError as error:
        raise InputError(f'the body cannot be simulated like this: {error}') from error
    try:
        gap: Gap | None = calibration.likelihood('the page').gap(coordinates)
    except (NotSimulatedError, InputError):
        gap = None
    object_from_depth = inverse(first.depth_from_world @ world_from_object)
    body = model.body(first)
    is_held = np.zeros(len(points), dtype=bool)
    is_held[body.held_nodes] = True
    surface = body.discretisation.surface_triangles
    return SimulatedBody(apply(object_from_depth, points), surface, is_held, gap)
