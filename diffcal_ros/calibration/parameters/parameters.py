# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Parameters: their names, scales, bounds and priors, and what each does to the model.

An optimiser sees *coordinates*: the logarithm of moduli and densities, everything else as it is.
"""

from dataclasses import dataclass, field
from enum import Enum

from diffcal_ros.effects.effect import Component
from diffcal_ros.effects.registry import EFFECTS
from diffcal_ros.least_squares.normal_equations import Prior
from diffcal_ros.scene.model import Quantity
from diffcal_ros.time_knot import TimeKnot
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


class Kind(str, Enum):
    """What a parameter acts on."""

    YOUNGS_MODULUS = 'youngs_modulus'
    POISSONS_RATIO = 'poissons_ratio'
    DENSITY = 'density'
    DAMPING = 'damping'
    RELEASE_TIME = 'release_time'
    REST_LENGTH = 'rest_length'
    CABLE_STIFFNESS = 'cable_stiffness'
    GRAVITY_TILT = 'gravity_tilt'
    RIGID_OFFSET = 'rigid_offset'
    LENS = 'lens'
    CAMERA_POSE = 'camera_pose'
    EDGE_BIAS = 'edge_bias'
    FIXTURE_OFFSET = 'fixture_offset'
    EFFECT = 'effect'


# What places a body before the cameras.
PLACING = (Kind.RIGID_OFFSET, Kind.CAMERA_POSE)
_LOGARITHMIC = (Kind.YOUNGS_MODULUS, Kind.DENSITY, Kind.DAMPING, Kind.CABLE_STIFFNESS)


@dataclass(frozen=True)
class Parameter:
    """One fitted number.

    Attributes:
        name: as in results, for example `youngs_modulus.tip`.
        kind: what it acts on.
        target: number of its region, cable, axis, observation or posture.
        unit: SI.
        quantity: start, bounds and prior, in that unit.
        axis: second index, for poses.
        is_nuisance: carried along for honest errors, not asked for.
        effect: identifier of the effect that it is of; empty for others.
        amplitude: which of the effect's amplitudes it is.
        sized: that amplitude with the size it has on the body; None: on a usual one.
        posture: number of the only one where it counts, on top of what the amplitude is in all;
            None: it is that.
        knot: the time after the first frame around which alone it counts, likewise; None: it
            counts at all times.
    """

    name: str
    kind: Kind
    target: int
    unit: str
    quantity: Quantity
    axis: int = 0
    is_nuisance: bool = False
    effect: str = ''
    amplitude: str = ''
    sized: Component | None = None
    posture: int | None = None
    knot: TimeKnot | None = None

    @property
    def is_in_all(self) -> bool:
        """Tell whether it is what something is in all postures at all times, and not more."""
        return self.posture is None and self.knot is None

    def weight_in(self, posture: int | None, time: float | None) -> float:
        """Return by how much it counts in a posture at a time after the first frame [s].

        Args:
            posture: number of it; None: what something is in all is asked for.
            time: None: at rest, or what it is at all times is asked for.
        """
        if self.posture not in (None, posture):
            return 0.0
        if self.knot is None:
            return 1.0
        return 0.0 if time is None else float(self.knot.weights(time))

    @property
    def component(self) -> Component | None:
        """The amplitude that it is, of an effect that is nothing else; None for others."""
        return self.part if self.kind in (Kind.EFFECT, Kind.LENS) else None

    @property
    def part(self) -> Component:
        """The amplitude that it is; only of those of an effect."""
        return self.sized or EFFECTS[self.effect].component(self.amplitude)

    @property
    def is_freed(self) -> bool:
        """Tell whether it is what an effect is more in one posture, at a time, or in form."""
        return bool(self.effect) and self.is_nuisance

    @property
    def is_logarithmic(self) -> bool:
        """Tell whether its coordinate is its logarithm."""
        return self.kind in _LOGARITHMIC

    def coordinate(self, value: float) -> float:
        """Turn a value into the optimiser's coordinate."""
        return float(np.log(value)) if self.is_logarithmic else float(value)

    def value(self, coordinate: float) -> float:
        """Turn the optimiser's coordinate into a value."""
        return float(np.exp(coordinate)) if self.is_logarithmic else float(coordinate)


@dataclass(frozen=True)
class ParameterSet:
    """All fitted parameters, in the order of the coordinates.

    Attributes:
        parameters: one a coordinate.
        pose_covariances: joint priors of camera poses: number of the observation, shape (6, 6).
    """

    parameters: tuple[Parameter, ...] = field(default_factory=tuple)
    pose_covariances: tuple[tuple[int, FloatArray], ...] = ()

    def __len__(self) -> int:
        return len(self.parameters)

    def __iter__(self):  # type: ignore[no-untyped-def]
        return iter(self.parameters)

    @property
    def names(self) -> tuple[str, ...]:
        """Names in order."""
        return tuple(parameter.name for parameter in self.parameters)

    def start(self) -> FloatArray:
        """Coordinates where a fit starts, shape (k,)."""
        return np.array([p.coordinate(p.quantity.start) for p in self.parameters])

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Lower and upper coordinates, shape (k,) each."""
        lower = [p.coordinate(p.quantity.lower) for p in self.parameters]
        upper = [p.coordinate(p.quantity.upper) for p in self.parameters]
        return np.array(lower), np.array(upper)

    def values(self, coordinates: FloatArray) -> dict[str, float]:
        """Values in SI units by name."""
        return {p.name: p.value(c) for p, c in zip(self.parameters, coordinates, strict=True)}

    def prior(self, leeway: float = 1.0) -> Prior:
        """Return what the scene states of the coordinates, without any data.

        Args:
            leeway: standard deviations of what places the body count so many times.
        """
        means, precision = np.zeros(len(self)), np.zeros((len(self), len(self)))
        for index, p in enumerate(self.parameters):
            mean, std = p.quantity.prior_mean, p.quantity.prior_std
            if mean is None or std is None:
                continue
            # A logarithm's standard deviation is the relative one, to first order.
            spread = std / mean if p.is_logarithmic else std
            means[index], precision[index, index] = p.coordinate(mean), 1.0 / spread**2
        for observation, covariance in self.pose_covariances:
            indices = self.pose_indices(observation)
            precision[np.ix_(indices, indices)] = np.linalg.inv(covariance)
        firmness = np.array([1.0 / leeway if p.kind in PLACING else 1.0 for p in self.parameters])
        return Prior(means, precision * np.outer(firmness, firmness))

    def pose_indices(self, observation: int) -> list[int]:
        """Places of the parameters of one observation's camera pose."""
        return [
            index
            for index, p in enumerate(self.parameters)
            if p.kind is Kind.CAMERA_POSE and p.target == observation
        ]

    def twist(
        self,
        kind: Kind,
        coordinates: FloatArray,
        target: int | None = None,
        stated: FloatArray | None = None,
        posture: int | None = None,
        time: float | None = None,
    ) -> FloatArray:
        """Return the rigid motion that parameters of one kind are [m, rad], shape (6,).

        Args:
            kind: of the parameters.
            coordinates: of all, shape (k,).
            target: what they are of; None: of anything.
            stated: what it is where no parameter is of it, shape (6,); None: none.
            posture: number of the one in which it is asked for; None: what it is in all.
            time: see `Parameter.weight_in`.
        """
        values, own = np.zeros(6) if stated is None else stated.copy(), np.zeros(6)
        for parameter, coordinate in zip(self.parameters, coordinates, strict=True):
            if parameter.kind is not kind or target not in (None, parameter.target):
                continue
            if parameter.is_in_all:
                values[parameter.axis] = coordinate
            else:
                own[parameter.axis] += parameter.weight_in(posture, time) * coordinate
        return values + own

    def find(self, kind: Kind) -> list[int]:
        """Places of the parameters of one kind."""
        return [index for index, p in enumerate(self.parameters) if p.kind is kind]
