# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which way a branched body goes: as it carries what hangs on it.

The direction in which most of it is spread is none of a body with teeth, prongs or arms: they
count as much as the spine that bears them. What is bent or softer at one place moves all that
hangs beyond it, so places count by that. It is the flux of what each part brings along to the
clamp by the least way, the gradient of a potential with a source everywhere (Poisson's equation):
a spine carries all of its teeth, and a tooth itself.
"""

from dataclasses import dataclass

from diffcal_ros.fem.elements.element import discretise, Element, rest_laplacian
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix, diags_array
from scipy.sparse.linalg import cg

FloatArray = NDArray[np.float64]

# Of the source, what is left of it; steps that a body of hundreds of elements' length needs.
_RESIDUAL, _MOST_STEPS = 1e-8, 5000


@dataclass(frozen=True)
class LoadPath:
    """Where the load of a body goes.

    Attributes:
        way: unit vector, away from the clamp, shape (3,).
        middle: of the places where it goes [m], shape (3,).
    """

    way: FloatArray
    middle: FloatArray


def load_path(mesh: TetMesh, held: NDArray[np.int32]) -> LoadPath | None:
    """Find where the load of a body goes; each place counts by the square of what it carries.

    Args:
        mesh: of the body at rest.
        held: vertices that carry all, shape (h,).

    Returns:
        None where it goes as much one way as the other, or some parts are held by nothing.
    """
    flux = _flux(mesh, held)
    squares = mesh.volumes * np.einsum('ti,ti->t', flux, flux)
    total = float(squares.sum())
    if not np.isfinite(total) or total <= 0.0:
        return None
    way = -squares @ flux
    size = float(np.linalg.norm(way))
    # Of what goes to both sides the most is taken back.
    if size < 0.5 * float(squares @ np.linalg.norm(flux, axis=1)):
        return None
    return LoadPath(way / size, squares @ mesh.centroids / total)


def _flux(mesh: TetMesh, held: NDArray[np.int32]) -> FloatArray:
    """Return the flux to what is held in each tetrahedron [m], shape (T, 3)."""
    linear = discretise(mesh, Element.LINEAR)
    matrix = rest_laplacian(linear).tocsr()
    source = np.zeros(linear.node_count)
    np.add.at(source, linear.nodes, linear.load_fractions)
    free = np.setdiff1d(np.unique(linear.nodes), held)
    potential = np.zeros(linear.node_count)
    potential[free] = _solved(matrix[free][:, free], source[free])
    return -np.einsum('ta,tai->ti', potential[linear.nodes], linear.gradients[:, 0])


def _solved(matrix: csr_matrix, source: FloatArray) -> FloatArray:
    """Solve Poisson's equation by conjugate gradients: factors of a fine mesh would be large."""
    found, _ = cg(
        matrix,
        source,
        rtol=_RESIDUAL,
        maxiter=_MOST_STEPS,
        M=diags_array(1.0 / matrix.diagonal()),
    )
    return np.asarray(found)
