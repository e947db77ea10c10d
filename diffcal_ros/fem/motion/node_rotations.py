# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How far a body's material has turned around each node."""

from diffcal_ros.fem.elements.elastic_body import ElasticBody
from diffcal_ros.fem.motion.rotation_kernels import find_rotations, sum_gradients
from diffcal_ros.warp_runtime.device_array import HostMirror, zero_floats, zero_points
from diffcal_ros.warp_runtime.launcher import Launcher
import numpy as np
from numpy.typing import NDArray
import warp as wp

FloatArray = NDArray[np.float64]


class NodeRotations:
    """Finds rotations of one body from the positions of its nodes."""

    def __init__(self, elastic: ElasticBody) -> None:
        self._elastic, device = elastic, elastic.device
        self._launcher = Launcher(device)
        self._count = elastic.discretisation.node_count
        self._tet_count = len(elastic.discretisation.nodes)
        self._positions = HostMirror(zero_points(self._count, device))
        self._volumes = HostMirror(zero_floats(self._count, device))
        self._sums, self._rotations = (
            HostMirror(wp.zeros(self._count, dtype=wp.mat33d, device=device)) for _ in range(2)
        )

    def at(self, positions: FloatArray) -> FloatArray:
        """Return the rotation of the mean deformation gradient around each node, (N, 3, 3).

        Args:
            positions: [m], shape (N, 3).
        """
        self._positions.write(positions)
        for mirror in (self._sums, self._volumes):
            mirror.clear()
        summed = [self._sums.array, self._volumes.array]
        self._launcher.launch(
            sum_gradients,
            self._tet_count,
            [*self._elastic.shape_on_device, self._positions.array],
            summed,
        )
        self._launcher.launch(find_rotations, self._count, summed, [self._rotations.array])
        return self._rotations.read()
