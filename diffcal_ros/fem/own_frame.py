# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body's own frame: the world's axes, with an origin at the body.

Strains are differences of positions, and positions far from their origin round: at 2 m by 0.2 fm,
which is little, but in an element of 3 mm of a nearly incompressible body of 5 MPa it already
leaves more force on a node than an equilibrium may. So a body is simulated in its own frame;
whoever asks it gives and gets positions in the world.
"""

from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# The origin is a multiple of this [m]: taking it off a position far away rounds nothing.
_GRID = 2.0**-10


def own_origin(mesh: TetMesh) -> FloatArray:
    """Return the origin of a body's own frame in the mesh's [m], shape (3,).

    Along an axis on which the body is within its own size of the mesh's origin, that is kept.
    """
    low, high = mesh.extent
    middle = 0.5 * (low + high)
    size = float(np.linalg.norm(high - low))
    rounded: FloatArray = np.round(middle / _GRID) * _GRID
    return np.where(np.abs(middle) > size, rounded, 0.0)


def moved_mesh(mesh: TetMesh, shift: FloatArray) -> TetMesh:
    """Return a mesh that is shifted [m], shape (3,); itself where the shift is zero."""
    return mesh.placed(mesh.rest_positions + shift) if shift.any() else mesh
