# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The stage before a fit: where on the modulus' and the placement's whole range to start.

Under gravity the shape of a clamped body depends on its modulus alone, and what places it before
the camera depends on nothing else. So shapes over the modulus are simulated once, with linear
elements, and each is placed on a coarse image by a few cheap steps.
"""

from collections.abc import Sequence
from dataclasses import replace

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.calibration.parameters.parameters import Kind, PLACING
from diffcal_ros.calibration.search.basins import Basin, Placing
from diffcal_ros.calibration.search.coarse_views import (
    coarse_observation,
    coarse_scene,
    stride_for,
)
from diffcal_ros.calibration.search.posed_shapes import CoarseObjective, PosedShapes
from diffcal_ros.calibration.search.shapes import make_shapes, modulus_indices, sag
from diffcal_ros.errors import NotSimulatedError
from diffcal_ros.fem.elements.element import Element
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


# A place is worth a fit where it leaves no more than so many times what the best one does, and so
# many are at most; the one that explains most of the image is, whatever it leaves.
_WORTH, _MOST = 1.5, 3


def worth_fitting(basins: Sequence[Basin]) -> list[Basin]:
    """Return the basins that may hold the best fit."""
    if not basins:
        return []
    limit = _WORTH * min(basin.misfit.left for basin in basins)
    worth = [basin for basin in basins if basin.misfit.left <= limit][:_MOST]
    explains_most = min(basins, key=lambda basin: basin.misfit.above_absence)
    if not any(basin is explains_most for basin in worth):
        worth.append(explains_most)
    return worth


def can_search(model: ForwardModel) -> bool:
    """Tell whether the stage serves a fit: bodies at rest whose modulus or place is fitted."""
    kinds = {own.kind for own in model.parameters}
    return not model.is_moving and bool(kinds & {Kind.YOUNGS_MODULUS, Kind.RIGID_OFFSET})


class GlobalSearch:
    """Finds starts for one model; its shapes are kept for other images of the same bodies."""

    def __init__(self, model: ForwardModel, start: FloatArray, *, solver: str = 'auto') -> None:
        """Simulate shapes.

        Args:
            model: of the fit.
            start: coordinates of what the search leaves as it is, shape (k,).
            solver: name of the sparse solver.

        Raises:
            InputError: when no shape has an equilibrium, or a camera does not see the body.
        """
        self._model, self._solver = model, solver
        self._start = self._unplaced(start)
        self._compliance = self._measure_compliance(start)
        points = self._points(self._start)
        self._stride = stride_for(points, model.observations)
        self._placing = self._prepare(model.observations)

    def basins(self, leeway: float = 1.0) -> list[Basin]:
        """Return places from which a fit may start, the best first.

        Args:
            leeway: standard deviations of placements count so many times.
        """
        return self._placing.basins(self._start, leeway)

    def look_at(self, depths: Sequence[NDArray[np.float32]]) -> None:
        """Compare with other images of the same cameras from now on [m], shape (H, W) each."""
        stride = self._stride
        for comparer, depth in zip(self._placing.objective.comparers, depths, strict=True):
            comparer.show(np.ascontiguousarray(depth[::stride, ::stride]))

    def are_same(self, one: FloatArray, other: FloatArray) -> bool:
        """Tell whether a fit would hardly tell two starts apart."""
        return self._placing.are_same(one, other)

    def _prepare(self, observations: Sequence[Observation]) -> Placing:
        model, stride = self._model, self._stride
        scene = replace(coarse_scene(model.scene, stride), element=Element.LINEAR)
        coarse = PosedShapes(
            scene,
            [coarse_observation(seen, stride) for seen in observations],
            model.parameters,
            solver=self._solver,
            device=model.device,
        )
        shapes = make_shapes(coarse, self._start, self._compliance)
        return Placing(coarse, CoarseObjective(coarse, stride, device=model.device), shapes)

    def _unplaced(self, start: FloatArray) -> FloatArray:
        """Return a start with the placement where its prior has it."""
        mean, _ = self._model.parameters.prior()
        placed = [index for index, own in enumerate(self._model.parameters) if own.kind in PLACING]
        unplaced = start.copy()
        unplaced[placed] = mean[placed]
        return unplaced

    def _points(self, start: FloatArray) -> list[FloatArray]:
        """Return the body at rest in every camera's frame [m], shape (N, 3) each."""
        model = self._model
        return [
            model.cameras.points(number, model.body(seen).discretisation.rest_nodes, start)
            for number, seen in enumerate(model.observations)
        ]

    def _measure_compliance(self, start: FloatArray) -> float | None:
        """Return how far the fit's own body sags at the start [m]; None: it has no equilibrium."""
        model, count = self._model, self._model.scene.mesh.vertex_count
        if not modulus_indices(model.parameters):
            return None
        try:
            worlds = model.worlds(start)
        except NotSimulatedError:
            return None
        bodies = [model.body(seen) for seen in model.observations]
        return sag(
            [world[:count] for world in worlds],
            [body.discretisation.rest_nodes[:count] for body in bodies],
            [model.inputs.gravity(seen.setup_index, start) for seen in model.observations],
        )
