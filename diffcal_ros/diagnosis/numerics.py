# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What mesh and time step may add to a gap, beside what the parameters take up of it."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from diffcal_ros.calibration.forward_model import ForwardModel
from diffcal_ros.calibration.observation import pose_owners
from diffcal_ros.calibration.parameters import ParameterSet
from diffcal_ros.diagnosis.full_prior import full_prior
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Halving a mesh or a step removes three quarters of a smooth error.
MESH_GAIN = 4.0 / 3.0
# Patches of a frame, and their noise [m]: what parameters are held to in a motion, roughly.
_PATCHES, _FLOOR = 30, 1e-4
# What is left of so large a move is uncertain to this share of it.
_DOUBT = 0.15


@dataclass(frozen=True)
class Numerics:
    """What a finer mesh and step would change, view by view [m], shape (N, 3) each.

    Attributes:
        moves: of the points, beside what the parameters take up.
        doubts: how far the moves may be off; None for a body at rest.
        shifts: by parameter, how far its coordinate is off where it took up an error of a motion.
    """

    moves: tuple[FloatArray, ...]
    doubts: tuple[FloatArray | None, ...]
    shifts: dict[str, float] = field(default_factory=dict)

    def columns(self, view: int) -> FloatArray:
        """Return the move and its doubt, which is zero at rest [m], shape (2, N, 3)."""
        move, doubt = self.moves[view], self.doubts[view]
        return np.stack([move, np.zeros_like(move) if doubt is None else doubt])

    def shifts_of(self, parameters: ParameterSet) -> FloatArray:
        """Return the shifts of these parameters' coordinates, zero of others, shape (k,)."""
        return np.array([self.shifts.get(name, 0.0) for name in parameters.names])


def find_numerics(model: ForwardModel, coordinates: FloatArray) -> Numerics:
    """Find how a finer mesh and step would move each view's points.

    A motion runs ahead or late where its mesh is too stiff or its step too long: by centimetres
    after a while, and just as with another modulus and damping. What these take up is taken off,
    since they are fitted; they are then those of this mesh and step, and so far from the body's.
    """
    moves = model.mesh_moves(coordinates)
    is_moving = [observation.instant is not None for observation in model.observations]
    doubts = tuple(_DOUBT * m if is_m else None for m, is_m in zip(moves, is_moving, strict=True))
    if not any(is_moving):
        return Numerics(tuple(moves), doubts)
    tangents = model.tangents(coordinates)
    _, precision = full_prior(model.parameters)
    shifts = []
    for owner in dict.fromkeys(pose_owners(model.observations)):
        views = [
            number
            for number, of in enumerate(pose_owners(model.observations))
            if of == owner and is_moving[number]
        ]
        if views:
            shifts.append(-MESH_GAIN * _take_off(moves, tangents, views, precision))
    names = model.parameters.names
    mean = np.mean(shifts, axis=0).tolist()
    return Numerics(tuple(moves), doubts, dict(zip(names, mean, strict=True)))


def _take_off(
    moves: list[FloatArray],
    tangents: Sequence[FloatArray],
    views: Sequence[int],
    precision: FloatArray,
) -> FloatArray:
    """Take off what one recording's motion follows of the parameters; return theirs, (k,).

    A parameter that hardly moves the body stays near what is known of it.
    """
    whole = np.concatenate([moves[view].ravel() for view in views])
    columns = np.concatenate(
        [tangents[view].reshape(len(tangents[view]), -1) for view in views], 1
    )
    weight = _PATCHES * len(views) / (_FLOOR**2 * len(whole))
    found = np.linalg.solve(weight * columns @ columns.T + precision, weight * columns @ whole)
    for view in views:
        moves[view] = moves[view] - np.einsum('k,kni->ni', found, tangents[view])
    return np.asarray(found, dtype=np.float64)
