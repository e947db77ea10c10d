# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A steady stream of air over a whole body, which presses what faces it (Newton's impact law)."""

import numpy as np

from benchmarks.blind.hexahedra import CORNERS, HexMesh
from benchmarks.blind.shapes import FloatArray, Shape


def blown(mesh: HexMesh, shares: FloatArray, push: FloatArray, shape: Shape) -> FloatArray:
    """Return forces of nodes, along normals by the square of the cosine [N], shape (N, 3).

    Faces are those of the body before it is loaded; none gives another shelter.

    Args:
        mesh: the body.
        shares: of the free length at which its nodes lie, shape (N,).
        push: force if the stream met the largest side squarely, object frame [N], shape (3,).
        shape: of the body, whose section and free length say how large that side is.
    """
    size = float(np.linalg.norm(push))
    way = push / max(size, 1e-30)
    pressure = size / (max(shape.section) * (shape.length - shape.clamp))
    forces = np.zeros_like(mesh.nodes)
    for number, axis, side in mesh.faces:
        nodes = mesh.cells[number, CORNERS[:, axis] == side]
        if shares[nodes].max() <= 0.0:
            continue
        points = mesh.nodes[nodes]
        middle = points.mean(axis=0)
        spans, ways = np.linalg.svd(points - middle)[1:]
        # The eight points of a rectangle a x b: singular values a sqrt(3/2), b sqrt(3/2).
        area = spans[:2].prod() / 1.5
        inside = mesh.nodes[mesh.cells[number]].mean(axis=0)
        outward = ways[2] * np.sign(ways[2] @ (middle - inside))
        facing = max(-float(outward @ way), 0.0)
        forces[nodes] -= pressure * area * facing**2 / len(nodes) * outward
    return forces
