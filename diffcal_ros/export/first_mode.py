# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The slowest swing of a body of linear tetrahedra about its rest without gravity.

What a simulator damps by is not always what this package damps by; in this swing they are made to
take the same power.
"""

from dataclasses import dataclass

from diffcal_ros.export.exported_body import ExportedBody
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array, diags_array
from scipy.sparse.linalg import eigsh

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class FirstMode:
    """The slowest swing.

    Attributes:
        frequency: angular, undamped [1/s].
        gradients: of the displacement, d u_i / d x_j in each tetrahedron [1/m per unit of the
            swing], shape (T, 3, 3); its sign and size are of no meaning.
    """

    frequency: float
    gradients: FloatArray

    @property
    def strains(self) -> FloatArray:
        """Small strains, shape (T, 3, 3)."""
        return 0.5 * (self.gradients + np.swapaxes(self.gradients, 1, 2))

    @property
    def dilations(self) -> FloatArray:
        """Changes of volume, shape (T,)."""
        return np.trace(self.gradients, axis1=1, axis2=2)


def first_mode(body: ExportedBody) -> FirstMode:
    """Find the slowest swing, masses lumped at the vertices."""
    slopes = shape_gradients(body)
    free = np.ones(body.mesh.vertex_count, dtype=bool)
    free[body.held] = False
    slots = np.flatnonzero(np.repeat(free, 3))
    stiffness = csc_array(_stiffness(body, slopes).tocsr()[slots][:, slots])
    masses = diags_array(np.repeat(body.vertex_masses, 3)[slots]).tocsc()
    # A start that is the same in every run, and no mode is orthogonal to by symmetry.
    start = 1.0 + np.sin(np.arange(len(slots)))
    squares, shapes = eigsh(stiffness, k=1, M=masses, sigma=0.0, v0=start)
    swing = np.zeros(3 * body.mesh.vertex_count)
    swing[slots] = shapes[:, 0]
    corners = swing.reshape(-1, 3)[body.mesh.tets]
    return FirstMode(
        frequency=float(np.sqrt(squares[0])),
        gradients=np.einsum('tai,taj->tij', corners, slopes),
    )


def shape_gradients(body: ExportedBody) -> FloatArray:
    """Return the gradients of the four shape functions [1/m], shape (T, 4, 3)."""
    corners = body.mesh.rest_positions[body.mesh.tets]
    inner = np.linalg.inv(np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2))
    return np.concatenate([-inner.sum(axis=1, keepdims=True), inner], axis=1)


def _stiffness(body: ExportedBody, slopes: FloatArray) -> coo_array:
    """Return the stiffness at rest: lambda div u div v + 2 mu D(u) : D(v), shape (3V, 3V)."""
    lam, mu = body.lame_lambda * body.mesh.volumes, body.lame_mu * body.mesh.volumes
    blocks = np.einsum('t,tai,tbj->taibj', lam, slopes, slopes)
    blocks += np.einsum('t,taj,tbi->taibj', mu, slopes, slopes)
    blocks += np.einsum('t,tak,tbk,ij->taibj', mu, slopes, slopes, np.eye(3), optimize=True)
    slots = (3 * body.mesh.tets[:, :, None] + np.arange(3)).reshape(-1, 12)
    rows = np.repeat(slots, 12, axis=1).reshape(-1)
    columns = np.tile(slots, 12).reshape(-1)
    size = 3 * body.mesh.vertex_count
    return coo_array((blocks.reshape(-1), (rows, columns)), shape=(size, size))
