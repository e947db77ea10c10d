# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Simulated bodies for tests."""

from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.material import LameConvention, Material
from diffcal_ros.tet_mesh import TetMesh
import numpy as np

from support.beams import beam_mesh, held_end

GRAVITY = np.array([0.6, -9.0, 3.1])  # Askew, so that no symmetry hides a mistake.


def uniform_material(
    mesh: TetMesh,
    modulus: float = 30e3,
    nu: float = 0.45,
    density: float = 1080.0,
    convention: LameConvention = LameConvention.CONSISTENT,
) -> Material:
    """One material throughout."""
    ones = np.ones(mesh.tet_count)
    return Material(modulus * ones, nu * ones, density * ones, convention)


def hanging_beam(
    element: Element = Element.QUADRATIC, mesh: TetMesh | None = None, solver: str = 'auto'
) -> StaticBody:
    """A beam held at its low-x end."""
    mesh = mesh or beam_mesh()
    return StaticBody(mesh, element, held_end(mesh), solver=solver)
