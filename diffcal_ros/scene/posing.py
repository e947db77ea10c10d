# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where the body rests in the world, and where its clamp holds it."""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from hashlib import sha256

from diffcal_ros.fem.body_axes import body_axes, BodyAxes
from diffcal_ros.rigid_transform import apply, rotation_matrix, transform
from diffcal_ros.scene.model import ObservationSetup, Turn
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]


@dataclass(frozen=True)
class HeldTargets:
    """Where held vertices are.

    Attributes:
        vertices: mesh vertices that any part holds, ascending, shape (h,).
        positions: where they are held, world frame [m], shape (h, 3).
    """

    vertices: IntArray
    positions: FloatArray


def world_positions(mesh: TetMesh, setup: ObservationSetup) -> FloatArray:
    """Return the mesh vertices at rest in the world frame [m], shape (V, 3)."""
    return apply(setup.world_from_object, mesh.rest_positions)


def object_axes(mesh: TetMesh, setup: ObservationSetup) -> BodyAxes:
    """Return the body's axes in the object frame; postures may hold other parts."""
    held = np.unique(np.concatenate([part.vertices for part in setup.held]))
    return _axes_of(_HeldBody(mesh, held.astype(np.int32)))


@dataclass(frozen=True, eq=False)
class _HeldBody:
    """A body and what is held of it; two of the same numbers are the same one."""

    mesh: TetMesh
    held: IntArray

    @cached_property
    def _digest(self) -> bytes:
        arrays = (self.mesh.rest_positions, self.mesh.tets, self.held)
        return sha256(b''.join(own.tobytes() for own in arrays)).digest()

    def __hash__(self) -> int:
        return hash(self._digest)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _HeldBody) and self._digest == other._digest


# Every model of a body asks anew, and the line of a large one takes a second.
@lru_cache(maxsize=16)
def _axes_of(body: _HeldBody) -> BodyAxes:
    mesh, held = body.mesh, body.held
    is_held = np.zeros(len(mesh.rest_positions), dtype=bool)
    is_held[held] = True
    is_cut = is_held[mesh.tets].any(axis=1) & ~is_held[mesh.tets].all(axis=1)
    border = np.intersect1d(mesh.tets[is_cut], held)
    return body_axes(mesh.rest_positions, held, border.astype(np.int32), mesh)


def held_targets(
    setup: ObservationSetup, rest_world: FloatArray, fraction: float = 1.0
) -> HeldTargets:
    """Return where the clamp holds its vertices.

    Args:
        setup: the observation.
        rest_world: vertices at rest in the world frame [m], shape (N, 3) with N >= V.
        fraction: how much of each turn is done, 0 to 1.
    """
    if not 0.0 <= fraction <= 1.0:
        raise ValueError(f'fraction is {fraction:g}: a turn is done from 0 to 1')
    targets = rest_world.copy()
    for part in setup.held:
        if part.turn is not None:
            own = rest_world[part.vertices]
            targets[part.vertices] = apply(turn_motion(part.turn, own, fraction), own)
    vertices = np.unique(np.concatenate([part.vertices for part in setup.held]))
    return HeldTargets(vertices.astype(np.int32), targets[vertices])


def turn_motion(turn: Turn, rest_world: FloatArray, fraction: float = 1.0) -> FloatArray:
    """Return the motion `turned_from_rest` after a fraction of a turn, shape (4, 4).

    Args:
        turn: rotation about an axis in the world frame, then a translation.
        rest_world: the part's vertices at rest [m], shape (h, 3); the middle of their bounding
            box is the centre where the turn gives none.
        fraction: 0 to 1; angle and translation grow with it evenly.
    """
    center = turn.center
    if center is None:
        center = 0.5 * (rest_world.min(axis=0) + rest_world.max(axis=0))
    # Axis times angle, not a blend of end poses: angles may exceed half a turn.
    rotation = rotation_matrix(turn.axis * (turn.angle * fraction))
    return transform(rotation, center - rotation @ center + fraction * turn.translation)
