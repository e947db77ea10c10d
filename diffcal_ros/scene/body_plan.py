# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a scene says of the body of one observation, put together once for all who simulate it."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from types import ModuleType

from diffcal_ros.fem.body_axes import BodyAxes
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.laws import find_law
from diffcal_ros.fem.terms.cable_route import CableRoute
from diffcal_ros.scene.model import ObservationSetup, Scene
from diffcal_ros.scene.posing import held_targets, object_axes, world_positions
from diffcal_ros.scene.sections.cables import cable_routes
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]


@dataclass(frozen=True)
class Holding:
    """How some parts hold a body.

    Attributes:
        vertices: that are held, ascending, shape (h,).
        positions: where they are held in the end, world frame [m], shape (h, 3).
        path: where they are at a fraction 0..1 of the way from rest; None: they stay.
    """

    vertices: IntArray
    positions: FloatArray
    path: Callable[[float], FloatArray] | None


@dataclass(frozen=True)
class BodyPlan:
    """The body of one observation.

    Attributes:
        mesh: at rest, world frame.
        element: which finite element.
        law: energy law module.
        cables: that run through it.
        axes: of the body, world frame.
        held: by all parts, also those that let go.
        staying: held by those that never let go; nothing where there is none.
    """

    mesh: TetMesh
    element: Element
    law: ModuleType
    cables: tuple[CableRoute, ...]
    axes: BodyAxes
    held: Holding
    staying: Holding

    @property
    def released(self) -> IntArray:
        """Vertices that are held until a support lets go, shape (r,)."""
        return np.setdiff1d(self.held.vertices, self.staying.vertices)


def plan_body(scene: Scene, setup: ObservationSetup) -> BodyPlan:
    """Put together what a scene says of the body of one of its observations."""
    rest = world_positions(scene.mesh, setup)
    return BodyPlan(
        mesh=scene.mesh.placed(rest),
        element=scene.element,
        law=find_law(scene.law),
        cables=tuple(cable_routes(scene)),
        axes=object_axes(scene.mesh, setup).placed(setup.world_from_object),
        held=_holding(setup, rest),
        staying=_holding(replace(setup, held=setup.staying), rest),
    )


def _holding(setup: ObservationSetup, rest_world: FloatArray) -> Holding:
    if not setup.held:
        return Holding(np.zeros(0, dtype=np.int32), np.zeros((0, 3)), None)
    targets = held_targets(setup, rest_world)
    path = None
    if any(part.turn is not None for part in setup.held):

        def path(fraction: float) -> FloatArray:
            return held_targets(setup, rest_world, fraction).positions

    return Holding(targets.vertices, targets.positions, path)
