# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Shapes that a body takes under its weight: however it is held, and however soft it is."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from diffcal_ros.errors import NotSimulatedError
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.material import Material
from diffcal_ros.proposal.hold import Hold
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

GRAVITY = 9.81  # [m/s^2]
# Linear elements lock near one half; a lower ratio bends a body much the same.
_POISSONS_RATIO = 0.4
# Moduli from stiff to soft [Pa], evenly spaced in the logarithm.
_STIFFEST, _SOFTEST, _LEVELS = 1e7, 1.2e4, 11
# Shapes that differ by less than this share of the body's size are one.
_ALIKE = 0.05
# A body's axis may climb towards the clamp, or fall, by this [rad]; fits find what lies between.
_SLOPES = tuple(np.deg2rad([-40.0, 0.0, 40.0]))


@dataclass(frozen=True)
class BentShape:
    """A body at rest under its weight.

    Attributes:
        hold: what of it is held.
        gravity: direction in the object frame, unit, shape (3,).
        youngs_modulus: with which it looks so, in linear elements [Pa].
        positions: vertices in the object frame [m], shape (V, 3).
    """

    hold: Hold
    gravity: FloatArray
    youngs_modulus: float
    positions: FloatArray


def gravity_directions(direction: FloatArray) -> list[FloatArray]:
    """List directions of gravity, object frame, for a body that is held at one end.

    Args:
        direction: unit, from the body to the clamp, shape (3,).

    Returns:
        Across the body four times, at three slopes each; and along it, hanging and standing.
    """
    across = np.eye(3)[int(np.argmin(np.abs(direction)))]
    first = np.cross(direction, across)
    first /= np.linalg.norm(first)
    second = np.cross(direction, first)
    found = [-direction, direction]
    for side in (first, second, -first, -second):
        found += [np.cos(slope) * side + np.sin(slope) * direction for slope in _SLOPES]
    return found


def bent_shapes(
    mesh: TetMesh,
    holds: Sequence[Hold],
    density: float,
    tell: Callable[[str], None] = lambda _: None,
) -> list[BentShape]:
    """Simulate a body in all ways in which it may be held, from stiff to soft.

    Args:
        mesh: the body at rest, object frame.
        holds: ends at which it may be held.
        density: [kg/m^3].
        tell: told what is being done.
    """
    shapes: list[BentShape] = []
    ways = [(hold, gravity) for hold in holds for gravity in gravity_directions(hold.direction)]
    for number, (hold, gravity) in enumerate(ways, start=1):
        shapes += _softer_and_softer(mesh, hold, gravity, density)
        if number % 7 == 0 or number == len(ways):
            tell(f'simulated the body in {number} of {len(ways)} ways to hold it')
    return shapes


def _softer_and_softer(
    mesh: TetMesh, hold: Hold, gravity: FloatArray, density: float
) -> Iterator[BentShape]:
    held = hold.vertices(mesh)
    body = StaticBody(mesh, Element.LINEAR, held)
    size = float(np.linalg.norm(np.ptp(mesh.rest_positions, axis=0)))
    last: FloatArray | None = None
    for modulus in np.geomspace(_STIFFEST, _SOFTEST, _LEVELS):
        material = Material(
            np.full(mesh.tet_count, modulus),
            np.full(mesh.tet_count, _POISSONS_RATIO),
            np.full(mesh.tet_count, density),
        )
        try:
            positions = body.solve_equilibrium(material, GRAVITY * gravity).positions
        except NotSimulatedError:
            return
        positions = positions[: mesh.vertex_count].copy()
        if last is not None:
            moved = float(np.linalg.norm(positions - last, axis=1).max())
            if moved < _ALIKE * size:
                continue
        last = positions
        yield BentShape(hold, gravity, float(modulus), positions)
