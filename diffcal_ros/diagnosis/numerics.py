# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What mesh and time step may add to a gap, beside what the parameters take up of it."""

from collections.abc import Sequence
from dataclasses import dataclass

from diffcal_ros.calibration.forward_model import ForwardModel
from diffcal_ros.calibration.observation import pose_owners
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# What is left of so large a move is uncertain to this share of it.
_DOUBT = 0.15


@dataclass(frozen=True)
class Numerics:
    """What a finer mesh and step would change, view by view [m], shape (N, 3) each.

    Attributes:
        moves: of the points, beside what the parameters take up.
        doubts: how far the moves may be off; None for a body at rest.
    """

    moves: tuple[FloatArray, ...]
    doubts: tuple[FloatArray | None, ...]

    def columns(self, view: int) -> FloatArray:
        """Return the move and its doubt, which is zero at rest [m], shape (2, N, 3)."""
        move, doubt = self.moves[view], self.doubts[view]
        return np.stack([move, np.zeros_like(move) if doubt is None else doubt])


def find_numerics(model: ForwardModel, coordinates: FloatArray) -> Numerics:
    """Find how a finer mesh and step would move each view's points.

    A motion runs ahead or late where its mesh is too stiff or its step too long: by centimetres
    after a while, and just as with another modulus and damping. What these take up is taken off,
    since they are fitted; they are then those of this mesh and step.
    """
    moves = model.mesh_moves(coordinates)
    is_moving = [observation.instant is not None for observation in model.observations]
    doubts = tuple(_DOUBT * m if is_m else None for m, is_m in zip(moves, is_moving, strict=True))
    if not any(is_moving):
        return Numerics(tuple(moves), doubts)
    tangents = model.tangents(coordinates)
    for owner in dict.fromkeys(pose_owners(model.observations)):
        views = [
            number
            for number, of in enumerate(pose_owners(model.observations))
            if of == owner and is_moving[number]
        ]
        if views:
            _take_off(moves, tangents, views)
    return Numerics(tuple(moves), doubts)


def _take_off(
    moves: list[FloatArray], tangents: Sequence[FloatArray], views: Sequence[int]
) -> None:
    """Take off what one recording's motion follows of the parameters."""
    whole = np.concatenate([moves[view].ravel() for view in views])
    columns = np.concatenate(
        [tangents[view].reshape(len(tangents[view]), -1) for view in views], 1
    )
    found, *_ = np.linalg.lstsq(columns.T, whole, rcond=1e-9)
    for view in views:
        moves[view] = moves[view] - np.einsum('k,kni->ni', found, tangents[view])
