# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What makes a field smooth: its squared gradient over the body, by finite volumes.

    R = 1/L sum over inner faces of A / d (f_i - f_j)^2 + s sum over tetrahedra of V_t / V f_t^2
        + c sum over regions of (mean of f)^2,

with the face's area A, the distance d of the two centroids and the cube root L of the volume V.
The second sum is small; it settles what the first does not see. The third is large: where a
region's modulus is fitted, that is the mean, and the field only what differs from it.
"""

from collections.abc import Sequence

from diffcal_ros.tet_mesh import TET_FACES, TetMesh
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csc_matrix, csr_matrix, diags
from scipy.sparse.linalg import splu

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_SIZE_FRACTION = 1e-3
_MEAN_WEIGHT = 1e3
# Right-hand sides at once, so that the variances of a large field need little memory.
_BLOCK = 256


class Smoothness:
    """The roughness of a field as a quadratic form of its unknowns."""

    def __init__(
        self,
        mesh: TetMesh,
        tets_from_unknowns: csr_matrix,
        regions: Sequence[NDArray[np.integer]] = (),
    ) -> None:
        """Assemble and factor the form.

        Args:
            mesh: of the body.
            tets_from_unknowns: shape (T, n).
            regions: tetrahedra of each region over which the field's mean is to be zero.
        """
        self._spread = tets_from_unknowns
        volumes = np.abs(mesh.volumes)
        form = face_roughness(mesh) + _SIZE_FRACTION * diags(volumes / volumes.sum())
        self._form = csc_matrix(tets_from_unknowns.T @ form @ tets_from_unknowns)
        self._factor = splu(self._form)
        means = np.zeros((mesh.tet_count, len(regions)))
        for number, tets in enumerate(regions):
            means[tets, number] = volumes[tets] / volumes[tets].sum()
        # The means are few and dense: they are added by Woodbury's formula.
        self._means = tets_from_unknowns.T @ means
        self._answers = self._factor.solve(self._means) if len(regions) else self._means
        self._small = np.linalg.inv(
            np.eye(len(regions)) / _MEAN_WEIGHT + self._means.T @ self._answers
        )

    def apply(self, unknowns: FloatArray) -> FloatArray:
        """Return half the derivative of the roughness, shape (n,)."""
        product: FloatArray = self._form @ unknowns
        product += _MEAN_WEIGHT * (self._means @ (self._means.T @ unknowns))
        return product

    def solve(self, duals: FloatArray) -> FloatArray:
        """Undo `apply`; shape (n,) or (n, k)."""
        solution: FloatArray = self._factor.solve(duals)
        solution -= self._answers @ (self._small @ (self._means.T @ solution))
        return solution

    def roughness(self, unknowns: FloatArray) -> float:
        """Return the roughness."""
        return float(unknowns @ self.apply(unknowns))

    def variances(self) -> FloatArray:
        """Return what the form alone says of each tetrahedron, under a weight of 1, shape (T,)."""
        count = self._spread.shape[0]
        found = np.empty(count)
        for first in range(0, count, _BLOCK):
            rows = self._spread[first : first + _BLOCK].toarray()
            found[first : first + _BLOCK] = np.einsum('tn,nt->t', rows, self.solve(rows.T))
        return found


def face_roughness(mesh: TetMesh) -> csr_matrix:
    """Return the matrix of the first sum, shape (T, T)."""
    first, second, faces = inner_faces(mesh)
    corners = mesh.rest_positions[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = 0.5 * np.linalg.norm(normals, axis=1)
    apart = np.linalg.norm(mesh.centroids[first] - mesh.centroids[second], axis=1)
    length = float(np.abs(mesh.volumes).sum()) ** (1.0 / 3.0)
    weights = areas / (apart * length)
    rows = np.concatenate([first, second, first, second])
    columns = np.concatenate([first, second, second, first])
    values = np.concatenate([weights, weights, -weights, -weights])
    return coo_matrix((values, (rows, columns)), shape=(mesh.tet_count,) * 2).tocsr()


def inner_faces(mesh: TetMesh) -> tuple[IntArray, IntArray, IntArray]:
    """Return the two tetrahedra of every inner face, shape (F,) each, and its corners, (F, 3)."""
    faces = np.sort(mesh.tets[:, TET_FACES].reshape(-1, 3), axis=1).astype(np.int64)
    owners = np.repeat(np.arange(mesh.tet_count), len(TET_FACES))
    order = np.lexsort(faces.T)
    same = np.flatnonzero((faces[order[1:]] == faces[order[:-1]]).all(axis=1))
    return owners[order[same]], owners[order[same + 1]], faces[order[same]]
