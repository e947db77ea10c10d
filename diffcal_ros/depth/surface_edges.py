# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Edges of a triangle surface and the triangles on their two sides."""

import numpy as np
from numpy.typing import NDArray

IntArray = NDArray[np.int32]


def surface_edges(triangles: IntArray) -> tuple[IntArray, IntArray]:
    """Find every edge once.

    Args:
        triangles: shape (F, 3).

    Returns:
        Vertices of each edge, shape (E, 2), and the triangles on its sides, shape (E, 2), where
        -1 stands for none (the rim of an open surface).

    Raises:
        ValueError: when more than two triangles meet at an edge.
    """
    sides = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    owners = np.repeat(np.arange(len(triangles), dtype=np.int32), 3)
    edges, index, count = np.unique(sides, axis=0, return_inverse=True, return_counts=True)
    if count.max(initial=0) > 2:
        raise ValueError(
            f'{(count > 2).sum()} edges of the surface belong to more than two triangles: the '
            'mesh touches itself along an edge; mesh the body again'
        )
    order = np.argsort(index.ravel(), kind='stable')
    starts = np.concatenate([[0], np.cumsum(count)[:-1]])
    faces = np.full((len(edges), 2), -1, dtype=np.int32)
    faces[:, 0] = owners[order[starts]]
    paired = count == 2
    faces[paired, 1] = owners[order[starts[paired] + 1]]
    return edges.astype(np.int32), faces
