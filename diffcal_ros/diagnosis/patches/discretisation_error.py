# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What mesh and time step may add to a gap, beside what the parameters take up of it."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.observations.observation import pose_owners
from diffcal_ros.calibration.parameters.parameters import ParameterSet
from diffcal_ros.diagnosis.patches.regularised_prior import regularised_prior
from diffcal_ros.errors import NotSimulatedError
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Halving a mesh or a time step removes three quarters of a smooth error; what one refinement
# tells too little about.
_GAIN, _SPREAD = 4.0 / 3.0, 0.5
# How the waves of a release run on a coarse mesh it tells less about: of what is left beside the
# parameters there may be hardly anything, or all of it.
_GAIN_MOVING = 2.0 / 3.0
# Patches of a frame, and their noise [m]: what parameters are held to in a motion, roughly.
_PATCHES, _FLOOR = 30, 1e-4
# What is left of so large a move is uncertain to this share of it.
_DOUBT = 0.15


@dataclass(frozen=True)
class DiscretisationError:
    """What a finer mesh and time step would change, view by view [m], shape (N, 3) each.

    Attributes:
        moves: of the points, beside what the parameters take up.
        doubts: how far the moves may be off; None for a body at rest.
        is_slow: of each view, whether its body is at rest, or as good as that.
        shifts: by parameter, how far its coordinate is off where it took up an error of a motion.
    """

    moves: tuple[FloatArray, ...]
    doubts: tuple[FloatArray | None, ...]
    is_slow: tuple[bool, ...]
    shifts: dict[str, float] = field(default_factory=dict)

    def columns(self, view: int) -> FloatArray:
        """Return the expected move, its coherent spread and its doubt [m], shape (3, N, 3)."""
        move, doubt = self.moves[view], self.doubts[view]
        if doubt is None:
            return np.stack([_GAIN * move, _SPREAD * move, np.zeros_like(move)])
        gain = _GAIN if self.is_slow[view] else _GAIN_MOVING
        return np.stack([gain * move, _SPREAD * move, doubt])

    def shifts_of(self, parameters: ParameterSet) -> FloatArray:
        """Return the shifts of these parameters' coordinates, zero of others, shape (k,)."""
        return np.array([self.shifts.get(name, 0.0) for name in parameters.names])


def find_discretisation_error(model: ForwardModel, coordinates: FloatArray) -> DiscretisationError:
    """Find how a finer mesh and time step would move each view's points.

    A motion runs ahead or late where its mesh is too stiff or its time step too long: by
    centimetres after a while, and just as with another modulus and damping. What these take up is
    taken off, since they are fitted; they are then those of this mesh and time step, and so far
    from the body's.
    """
    moves = model.mesh_moves(coordinates)
    is_moving = [observation.instant is not None for observation in model.observations]
    doubts = tuple(_DOUBT * m if is_m else None for m, is_m in zip(moves, is_moving, strict=True))
    motions = [model.scene.observations[o.setup_index].motion for o in model.observations]
    is_slow = tuple(motion is None or motion.is_slow for motion in motions)
    if not any(is_moving):
        return DiscretisationError(tuple(moves), doubts, is_slow)
    owners = pose_owners(model.observations)
    shifts = []
    for owner in dict.fromkeys(owners):
        views = [view for view, of in enumerate(owners) if of == owner and is_moving[view]]
        if views:
            shifts.append(-_GAIN * _taken_up(model, coordinates, moves, views))
    names = model.parameters.names
    mean = np.mean(shifts, axis=0).tolist()
    return DiscretisationError(tuple(moves), doubts, is_slow, dict(zip(names, mean, strict=True)))


def _taken_up(
    model: ForwardModel, coordinates: FloatArray, moves: list[FloatArray], views: Sequence[int]
) -> FloatArray:
    """Take off what one recording's motion follows of the parameters; return theirs, (k,).

    By two steps of Gauss and Newton's method: what a mesh that is 5 % too stiff does to a swing is
    off its tangents by as much as some percent of drag or damping move the body.
    """
    _, precision = regularised_prior(model.parameters)
    model.keep(coordinates)
    begun = [model.views(coordinates)[view].points for view in views]
    whole = [moves[view] for view in views]
    found = _take_off(moves, model.tangents(coordinates), views, precision)
    there = np.clip(coordinates + found, *model.parameters.bounds())
    try:
        ended = [model.views(there)[view].points for view in views]
    except NotSimulatedError:
        return found
    for view, move, before, after in zip(views, whole, begun, ended, strict=True):
        moves[view] = move - (after - before)
    so_far = there - coordinates
    return so_far + _take_off(moves, model.tangents(there), views, precision, so_far)


def _take_off(
    moves: list[FloatArray],
    tangents: Sequence[FloatArray],
    views: Sequence[int],
    precision: FloatArray,
    so_far: FloatArray | float = 0.0,
) -> FloatArray:
    """Take off what moves follow of a step of the parameters along tangents; return it, (k,).

    A parameter that hardly moves the body stays near what is known of it, `so_far` from here.
    """
    whole = np.concatenate([moves[view].ravel() for view in views])
    columns = np.concatenate(
        [tangents[view].reshape(len(tangents[view]), -1) for view in views], 1
    )
    weight = _PATCHES * len(views) / (_FLOOR**2 * len(whole))
    pull = weight * columns @ whole - precision @ np.broadcast_to(so_far, len(columns))
    found = np.linalg.solve(weight * columns @ columns.T + precision, pull)
    for view in views:
        moves[view] = moves[view] - np.einsum('k,kni->ni', found, tangents[view])
    return np.asarray(found, dtype=np.float64)
