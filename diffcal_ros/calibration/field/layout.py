# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a field of log moduli is made of: one unknown a tetrahedron, or a point of a grid."""

from dataclasses import dataclass

from diffcal_ros.errors import InputError
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csr_matrix, eye

FloatArray = NDArray[np.float64]

_MOST_CELLS = 1000


@dataclass(frozen=True)
class FieldKind:
    """What a field is made of.

    Attributes:
        spacing: of a control grid [m]; None: one unknown a tetrahedron.
    """

    spacing: float | None = None

    def describe(self) -> str:
        """Say it in words."""
        if self.spacing is None:
            return 'one modulus a tetrahedron'
        return f'a control grid of {1e3 * self.spacing:g} mm'


def tets_from_unknowns(mesh: TetMesh, kind: FieldKind) -> csr_matrix:
    """Return the matrix from the unknowns to the tetrahedra, shape (T, n); its rows sum to 1.

    Args:
        mesh: of the body.
        kind: what the field is made of; a grid is interpolated trilinearly.

    Raises:
        InputError: when a grid is too coarse for a field, or finer than any mesh.
    """
    if kind.spacing is None:
        return csr_matrix(eye(mesh.tet_count))
    low, high = mesh.extent
    longest = float((high - low).max())
    if not 0.0 < kind.spacing < longest:
        raise InputError(
            f'the control grid has a spacing of {kind.spacing:g} m: give less than the length of '
            f'the body, {longest:.3g} m'
        )
    finest = longest / _MOST_CELLS
    if kind.spacing < finest:
        raise InputError(
            f'the control grid has a spacing of {kind.spacing:g} m: give at least {finest:.3g} m, '
            f'{_MOST_CELLS} cells along the body, or leave the spacing out'
        )
    cells = np.maximum(np.ceil((high - low) / kind.spacing).astype(np.int64), 1)
    scaled = (mesh.centroids - low) / (high - low) * cells
    corner = np.minimum(scaled.astype(np.int64), cells - 1)
    inside = scaled - corner
    rows, columns, values = [], [], []
    for step in np.ndindex(2, 2, 2):
        place = corner + np.array(step)
        rows.append(np.arange(mesh.tet_count))
        columns.append((place[:, 0] * (cells[1] + 1) + place[:, 1]) * (cells[2] + 1) + place[:, 2])
        values.append(np.prod(np.where(np.array(step) == 1, inside, 1.0 - inside), axis=1))
    # Grid points far from the body are no unknowns.
    used, numbers = np.unique(np.concatenate(columns), return_inverse=True)
    shape = (mesh.tet_count, len(used))
    return coo_matrix((np.concatenate(values), (np.concatenate(rows), numbers)), shape).tocsr()
