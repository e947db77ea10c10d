# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Handles in the scene that move the body, and where its clamp begins."""

from typing import Any

from diffcal_ros.report.palette import START
from diffcal_ros.report.scene_picture.scene_legend import HELD_COLOR
from diffcal_ros.rigid_transform import (
    apply,
    rotation_from_quaternion,
    rotation_vector,
    transform,
)
from diffcal_ros.tet_mesh import TetMesh
from diffcal_ros.web.arrangement import Arrangement
from diffcal_ros.web.held_box import box_around
from diffcal_ros.web.setup_controls import OnEdit
from diffcal_ros.web.stage import draw_held_box, draw_surface, pose
from diffcal_ros.web.trial import SimulatedBody
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

PLACE, CLAMP = '/place', '/place/clamp'
# Share of the body's length.
_PLACE_SIZE, _CLAMP_SIZE = 0.4, 0.25
_OPACITY = 0.85
# Share of the clamp's width from its middle.
_BESIDE = 0.8


class SetupHandles:
    """A frame with three arrows and three rings that carries the body, and an arrow of the clamp.

    The frame's middle is the middle of what is held first, so that the rings turn about that.
    """

    def __init__(self, scene: Any, mesh: TetMesh, start: Arrangement, on_edit: OnEdit) -> None:
        """Add the handles.

        Args:
            scene: of viser.
            mesh: the body at rest.
            start: arrangement that is shown first.
            on_edit: called with how a handle changes the arrangement, and the handle's name.
        """
        self._scene, self._mesh, self._on_edit = scene, mesh, on_edit
        pivot = mesh.rest_positions[start.hold.vertices(mesh)].mean(axis=0)
        self._handle_from_object = transform(np.eye(3), -pivot)
        self._size = float(np.ptp(mesh.rest_positions, axis=0).max())
        # Points and body do not hide them.
        self._place = scene.add_transform_controls(
            PLACE, scale=_PLACE_SIZE * self._size, depth_test=False
        )
        self._clamp = scene.add_transform_controls(
            CLAMP,
            scale=_CLAMP_SIZE * self._size,
            active_axes=(True, False, False),
            disable_sliders=True,
            disable_rotations=True,
            depth_test=False,
        )
        self._place.on_update(self._placed)
        self._clamp.on_update(self._clamped)

    # Handlers that are coroutines are called in the order of the drag.
    async def _placed(self, event: Any) -> None:
        if event.client_id is None:
            return
        x, y, z = self._place.position
        w, *vector = self._place.wxyz
        there = transform(rotation_from_quaternion(np.array([*vector, w])), np.array([x, y, z]))
        there = there @ self._handle_from_object
        turn = rotation_vector(there[:3, :3])
        self._on_edit(lambda own: own.placed(there[:3, 3], turn), PLACE)

    async def _clamped(self, event: Any) -> None:
        if event.client_id is None:
            return
        point = np.array(self._clamp.position) - self._handle_from_object[:3, 3]
        self._on_edit(lambda own: own.held_from(float(point @ own.hold.direction)), CLAMP)

    def show(self, arrangement: Arrangement, dragged: str = '') -> None:
        """Move the handles, but the one that is being dragged, and the clamp's box."""
        if dragged != PLACE:
            object_from_handle = transform(np.eye(3), -self._handle_from_object[:3, 3])
            there = pose(arrangement.world_from_object @ object_from_handle)
            self._place.position, self._place.wxyz = there['position'], there['wxyz']
        rest, hold = self._mesh.rest_positions, arrangement.hold
        held = rest[hold.vertices(self._mesh)]
        box = box_around(held if len(held) else rest, hold.direction, hold.plane)
        if dragged != CLAMP:
            front = box.object_from_box.copy()
            front[:3, 3] -= 0.5 * box.sides[0] * hold.direction
            # Beside the body, where it does not lie on an arrow of the other handle.
            front[:3, 3] -= _BESIDE * box.sides[1] * front[:3, 1]
            there = pose(self._handle_from_object @ front)
            self._clamp.position, self._clamp.wxyz = there['position'], there['wxyz']
        draw_held_box(self._scene, f'{PLACE}/box', box, self._handle_from_object)

    def draw_body(self, body: SimulatedBody) -> None:
        """Draw the simulated body where the handle is; what is held in the clamp's colour."""
        vertices = apply(self._handle_from_object, body.vertices)
        is_held_face = body.is_held[body.triangles].all(axis=1)
        for name, part, color in (
            ('body', body.triangles[~is_held_face], START),
            ('held', body.triangles[is_held_face], HELD_COLOR),
        ):
            draw_surface(self._scene, f'{PLACE}/{name}', vertices, part, color, _OPACITY)
