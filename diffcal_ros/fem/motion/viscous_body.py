# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Strain-rate damping of a body on a device; see `diffcal_ros.damping.Damping` for its law."""

from typing import Any

from diffcal_ros.device_array import (
    download,
    float_array,
    int_array,
    point_array,
    upload,
    zero_floats,
    zero_points,
)
from diffcal_ros.fem.element import Discretisation
from diffcal_ros.fem.motion.viscous_kernels import (
    viscous_forces,
    viscous_pull_back,
    viscous_skew,
    viscous_stiffness,
    viscous_tangent,
)
from diffcal_ros.fem.sparse_pattern import SparsePattern
from diffcal_ros.launcher import Launcher
import numpy as np
from numpy.typing import NDArray
import warp as wp

FloatArray = NDArray[np.float64]


class ViscousBody:
    """Forces of strain-rate damping; positions [m] and velocities [m/s] have shape (N, 3)."""

    def __init__(self, discretisation: Discretisation, pattern: SparsePattern, device: str):
        self._launcher = Launcher(device)
        count = discretisation.node_count
        self._tet_count = len(discretisation.nodes)
        self._nodes = int_array(discretisation.nodes, device)
        self._gradients = point_array(discretisation.gradients, device)
        self._weights = float_array(discretisation.weights, device)
        self._slots = int_array(pattern.slots, device)
        self._values = zero_floats(pattern.entry_count, device)
        self._beta, self._by_beta = (zero_floats(self._tet_count, device) for _ in range(2))
        self._positions, self._velocities, self._first, self._second = (
            zero_points(count, device) for _ in range(4)
        )
        self._internal, self._by_velocities = (zero_points(count, device) for _ in range(2))
        self._is_damped = False

    def set_damping(self, strain_rate: FloatArray) -> None:
        """Set beta [Pa s] of every tetrahedron."""
        upload(self._beta, strain_rate)
        self._is_damped = bool(strain_rate.any())

    @property
    def is_damped(self) -> bool:
        """Tell whether any tetrahedron is damped."""
        return self._is_damped

    def forces(self, positions: FloatArray, velocities: FloatArray) -> FloatArray:
        """Return the forces that oppose the motion [N], on the side of elastic forces."""
        self._place(positions, velocities)
        self._launch(viscous_forces, [], [self._internal])
        return download(self._internal)

    def force_of_damping(
        self, positions: FloatArray, velocities: FloatArray, change: FloatArray
    ) -> FloatArray:
        """Return the derivative of the forces along a change of beta [Pa s], shape (T,)."""
        kept = download(self._beta)
        upload(self._beta, change)
        forces = self.forces(positions, velocities)
        upload(self._beta, kept)
        return forces

    def force_tangent(
        self,
        positions: FloatArray,
        velocities: FloatArray,
        moved: FloatArray,
        sped: FloatArray,
    ) -> FloatArray:
        """Return how forces follow changes of positions and velocities [N], shape (N, 3)."""
        self._place(positions, velocities)
        upload(self._first, moved)
        upload(self._second, sped)
        self._launch(viscous_tangent, [self._first, self._second], [self._internal])
        return download(self._internal)

    def pull_back(
        self, positions: FloatArray, velocities: FloatArray, adjoint: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return adjoint . d forces by positions (N, 3), velocities (N, 3) and beta (T,)."""
        self._place(positions, velocities)
        self._by_velocities.zero_()
        upload(self._first, adjoint)
        self._launch(
            viscous_pull_back,
            [self._first],
            [self._internal, self._by_velocities, self._by_beta],
        )
        return tuple(map(download, (self._internal, self._by_velocities, self._by_beta)))  # type: ignore[return-value]

    def skew_product(
        self, positions: FloatArray, velocities: FloatArray, direction: FloatArray
    ) -> FloatArray:
        """Return what `stiffness` leaves out times a direction, shape (N, 3)."""
        self._place(positions, velocities)
        upload(self._first, direction)
        self._launch(viscous_skew, [self._first], [self._internal])
        return download(self._internal)

    def stiffness(self, positions: FloatArray, velocities: FloatArray, rate: float) -> FloatArray:
        """Return the symmetric part of how forces follow positions [N/m], shape (nnz,).

        Args:
            positions: [m], shape (N, 3).
            velocities: [m/s], shape (N, 3).
            rate: change of velocities per change of positions in a step [1/s].
        """
        self._place(positions, velocities)
        self._values.zero_()
        self._launch(viscous_stiffness, [wp.float64(rate), self._slots], [self._values])
        return download(self._values)

    def _place(self, positions: FloatArray, velocities: FloatArray) -> None:
        upload(self._positions, positions)
        upload(self._velocities, velocities)
        self._internal.zero_()

    def _launch(self, kernel: Any, inputs: list[Any], outputs: list[Any]) -> None:
        shared = [self._nodes, self._gradients, self._weights, self._beta]
        state = [self._positions, self._velocities]
        self._launcher.launch(kernel, self._tet_count, [*shared, *state, *inputs], outputs)
