# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Place shapes of the body on a coarse image, and keep the places from which a fit may start."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from diffcal_ros.calibration.parameters.longest_steps import longest_steps
from diffcal_ros.calibration.parameters.parameters import Kind, PLACING
from diffcal_ros.calibration.residuals.two_way_comparison import Misfit
from diffcal_ros.calibration.search.posed_shapes import CoarseObjective, FLOOR, PosedShapes
from diffcal_ros.calibration.search.shapes import modulus_indices, Shape
from diffcal_ros.errors import NotSimulatedError
from diffcal_ros.least_squares.levenberg_marquardt import minimise
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_MOST_STEPS = 8
# A body may lie so far along itself from where it seems to be [m]: a vertebra, and two.
_SLIDES = (-0.03, -0.015, 0.015, 0.03)
# Every second shape is tried, and the others beside good ones.
_NEIGHBOURS = 2
# Shapes around which more is tried, and shapes that are slid.
_LOOKED_AROUND, _SLID = 3, 2
# Two places are one where moduli and shifts are closer than this [log], [m]: a fit goes from one
# to the other. Turns make up for the modulus on the way, and do not tell.
_SAME_MODULUS, _SAME_SHIFT = 0.5, 0.010


@dataclass(frozen=True)
class Basin:
    """A place from which a fit may start.

    Attributes:
        coordinates: shape (k,).
        misfit: of the coarse image there.
        shape: number of the shape.
    """

    coordinates: FloatArray
    misfit: Misfit
    shape: int


class Placing:
    """Places shapes before the coarse cameras.

    Attributes:
        model: of the bodies.
        objective: compares shapes of them with the coarse images.
        shapes: in families, each from stiff to soft.
        doubt: by how much what is stated leaves open where a body is, one deviation [m].
    """

    def __init__(
        self, model: PosedShapes, objective: CoarseObjective, shapes: Sequence[Shape]
    ) -> None:
        """Take what is placed.

        Args:
            model: of the bodies.
            objective: compares shapes of them with the coarse images.
            shapes: in families, each from stiff to soft.
        """
        self.model, self.objective, self.shapes = model, objective, tuple(shapes)
        self._moduli = modulus_indices(model.parameters)
        self._indices = [
            index for index, own in enumerate(model.parameters) if own.kind in PLACING
        ]
        self._shifts = [
            index
            for index, own in enumerate(model.parameters)
            if own.kind is Kind.RIGID_OFFSET and own.axis < 3
        ]
        self._longest = longest_steps(model.parameters)
        self._bounds = model.parameters.bounds()
        self.doubt = self._doubt_of_places()

    def basins(self, start: FloatArray, leeway: float = 1.0) -> list[Basin]:
        """Return places that are worth a fit, the best first.

        Args:
            start: coordinates that place the body without a better guess, shape (k,).
            leeway: standard deviations of placements count so many times.
        """
        found: dict[int, Basin] = {}
        others: list[Basin] = []
        self._try(range(0, len(self.shapes), _NEIGHBOURS), start, leeway, found)
        for basin in _best(found.values(), _LOOKED_AROUND):
            self._try((basin.shape - 1, basin.shape + 1), start, leeway, found)
        for basin in _best(found.values(), _SLID):
            others.extend(self._slid(basin, leeway))
        return self.distinct([*found.values(), *others])

    def distinct(self, basins: Iterable[Basin]) -> list[Basin]:
        """Return the lowest places, the best first: a fit goes down from a shape to the next."""
        ordered = sorted(basins, key=lambda own: own.misfit.left)
        return [
            basin
            for number, basin in enumerate(ordered)
            if not any(self._leads_to(basin, lower) for lower in ordered[:number])
        ]

    def are_same(self, one: FloatArray, other: FloatArray) -> bool:
        """Tell whether a fit would hardly tell two starts apart."""
        change = np.abs(one - other)
        if self._moduli and change[self._moduli].max() > _SAME_MODULUS:
            return False
        return bool(np.linalg.norm(change[self._shifts]) < _SAME_SHIFT)

    def place(self, number: int, start: FloatArray, leeway: float = 1.0) -> Basin | None:
        """Fit what places a shape, residual scales annealed; None where it leaves the image.

        Args:
            number: of the shape.
            start: coordinates that place it, shape (k,).
            leeway: see `basins`.
        """
        shape = self.shapes[number]
        coordinates = shape.coordinates.copy()
        coordinates[self._indices] = start[self._indices]
        objective = self.objective.of_shape(shape.world, leeway)
        try:
            # What is stated better than a coarse image can tell stays as it is stated.
            if leeway * self.doubt > FLOOR:
                coordinates = minimise(
                    objective,
                    coordinates,
                    self._bounds,
                    self._longest,
                    max_iterations=_MOST_STEPS,
                ).coordinates
            misfit = objective.at_the_end().misfit(coordinates)
        except NotSimulatedError:
            return None
        return Basin(coordinates, misfit, number)

    def _doubt_of_places(self) -> float:
        """Return what `doubt` says.

        Of the point and the view where it is most: turns count by their levers.
        """
        indices = self._indices
        if not indices or not self.shapes:
            return 0.0
        mean, precision = self.model.parameters.prior()
        own = precision[np.ix_(indices, indices)]
        if (np.diagonal(own) <= 0.0).any():
            return np.inf
        covariance, doubt = np.linalg.inv(own), 0.0
        for number, world in enumerate(self.shapes[0].world):
            motions = self.model.cameras.motions(number, world, mean)
            nothing = np.zeros_like(world)
            moves = np.stack([motions.get(index, nothing) for index in indices])
            variances = np.einsum('inj,ik,knj->n', moves, covariance, moves)
            doubt = max(doubt, float(np.sqrt(variances.max())))
        return doubt

    def _try(
        self, numbers: Iterable[int], start: FloatArray, leeway: float, found: dict[int, Basin]
    ) -> None:
        for number in numbers:
            if number in found or not 0 <= number < len(self.shapes):
                continue
            basin = self.place(number, start, leeway)
            if basin is not None:
                found[number] = basin

    def _slid(self, basin: Basin, leeway: float) -> list[Basin]:
        """Place a shape anew from farther along itself, where a body with a pattern may fit."""
        if not self._shifts:
            return []
        along = self._along(basin)
        found = []
        for slide in _SLIDES:
            start = basin.coordinates.copy()
            start[self._shifts] += slide * along
            own = self.place(basin.shape, np.clip(start, *self._bounds), leeway)
            if own is not None:
                found.append(own)
        return found

    def _leads_to(self, basin: Basin, lower: Basin) -> bool:
        """Tell whether a lower place is that of a neighbouring shape in about the same place."""
        is_next = abs(basin.shape - lower.shape) <= _NEIGHBOURS
        if not is_next or self.shapes[basin.shape].family != self.shapes[lower.shape].family:
            return False
        change = (basin.coordinates - lower.coordinates)[self._shifts]
        return bool(np.linalg.norm(change) < _SAME_SHIFT)

    def _along(self, basin: Basin) -> FloatArray:
        """Return the direction from clamp to the body's middle in the camera's frame, (3,)."""
        model = self.model
        body = model.body(model.observations[0])
        world = self.shapes[basin.shape].world[0]
        free = np.delete(world, body.held_nodes, axis=0).mean(axis=0)
        along = model.cameras.rotation(0, basin.coordinates) @ (
            free - world[body.held_nodes].mean(axis=0)
        )
        return along / max(float(np.linalg.norm(along)), 1e-12)


def _best(basins: Iterable[Basin], count: int) -> list[Basin]:
    return sorted(basins, key=lambda basin: basin.misfit.left)[:count]
