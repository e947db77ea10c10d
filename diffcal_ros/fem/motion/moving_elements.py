# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Elements with strain-rate damping on a device: forces, stiffness and derivatives of a motion."""

from typing import Any

from diffcal_ros.fem.elements.elastic_body import ElasticBody
from diffcal_ros.fem.elements.sparse_pattern import SparsePattern
from diffcal_ros.fem.motion.step_kernels import make_step_kernels
from diffcal_ros.fem.motion.viscous_kernels import (
    viscous_forces,
    viscous_rest,
    viscous_tangent,
    viscous_velocity_tangents,
)
from diffcal_ros.material import LameParameters
from diffcal_ros.warp_runtime.device_array import (
    float_array,
    HostMirror,
    int_array,
    zero_floats,
    zero_points,
)
from diffcal_ros.warp_runtime.launcher import Launcher
import numpy as np
from numpy.typing import NDArray
import warp as wp

FloatArray = NDArray[np.float64]


class MovingElements:
    """Elements of a body in motion; positions [m] and velocities [m/s] have shape (N, 3).

    Strain rates are measured from the same shape without stress as strains, with the material of
    the elastic body.
    """

    def __init__(self, elastic: ElasticBody, pattern: SparsePattern) -> None:
        self._elastic = elastic
        device = elastic.device
        self._launcher = Launcher(device)
        self._kernels = make_step_kernels(elastic.law)
        count = elastic.discretisation.node_count
        self._tet_count = len(elastic.discretisation.nodes)
        self._slots = int_array(pattern.slots, device)
        self._beta, self._change = (zero_floats(self._tet_count, device) for _ in range(2))
        self._values = HostMirror(zero_floats(pattern.entry_count, device))
        self._sums = [HostMirror(zero_floats(self._tet_count, device)) for _ in range(3)]
        self._positions, self._velocities, self._first, self._second, self._out, self._other = (
            HostMirror(zero_points(count, device)) for _ in range(6)
        )
        self._sides: dict[int, tuple[HostMirror, HostMirror]] = {}
        self._is_damped = False

    @property
    def is_damped(self) -> bool:
        """Tell whether the strain rate of any tetrahedron is damped."""
        return self._is_damped

    def set_damping(self, strain_rate: FloatArray) -> None:
        """Set beta [Pa s] of every tetrahedron."""
        self._beta = float_array(strain_rate, self._elastic.device)
        self._is_damped = bool(strain_rate.any())

    def forces(self, positions: FloatArray, velocities: FloatArray) -> FloatArray:
        """Return elastic and viscous forces [N], as the energy's gradient has them."""
        self._place(positions, velocities)
        self._launch(self._kernels.forces, self._lame_parameters(), [], [self._out])
        return self._out.read()

    def stiffness(self, positions: FloatArray, rate: float) -> FloatArray:
        """Return the main part of how forces follow positions [N/m], symmetric, shape (nnz,).

        Args:
            positions: [m], shape (N, 3).
            rate: change of velocities per change of positions in a step [1/s].
        """
        self._positions.write(positions)
        self._values.clear()
        self._launcher.launch(
            self._kernels.stiffness,
            self._tet_count,
            [
                *self._elastic.shape_on_device,
                *self._lame_parameters(),
                self._positions.array,
                wp.float64(rate),
                self._slots,
            ],
            [self._values.array],
        )
        return self._values.read()

    def rest_product(
        self,
        positions: FloatArray,
        velocities: FloatArray,
        directions: FloatArray,
        *,
        is_transposed: bool,
    ) -> FloatArray:
        """Return what `stiffness` leaves out times each direction, shape (k, N, 3)."""
        return self._of_sides(viscous_rest, positions, velocities, directions, [is_transposed])

    def velocity_tangents(
        self, positions: FloatArray, velocities: FloatArray, sped: FloatArray
    ) -> FloatArray:
        """Return how viscous forces follow each change of velocities [m/s], shape (k, N, 3)."""
        return self._of_sides(viscous_velocity_tangents, positions, velocities, sped, [])

    def _of_sides(
        self,
        kernel: Any,
        positions: FloatArray,
        velocities: FloatArray,
        sides: FloatArray,
        more: list[Any],
    ) -> FloatArray:
        """Launch a kernel that takes several directions at once."""
        self._place(positions, velocities)
        count = len(sides)
        if count not in self._sides:
            shape, device = sides.shape[:2], self._elastic.device
            self._sides = {
                count: (
                    HostMirror(zero_points(shape, device)),
                    HostMirror(zero_points(shape, device)),
                )
            }
        given, found = self._sides[count]
        given.write(sides)
        found.clear()
        self._launch(kernel, [self._beta], [given.array, *more], [found])
        return found.read()

    def viscous_tangent(
        self, positions: FloatArray, velocities: FloatArray, moved: FloatArray, sped: FloatArray
    ) -> FloatArray:
        """Return how viscous forces follow changes of positions and velocities [N]."""
        self._place(positions, velocities)
        self._first.write(moved)
        self._second.write(sped)
        directions = [self._first.array, self._second.array]
        self._launch(viscous_tangent, [self._beta], directions, [self._out])
        return self._out.read()

    def force_of_damping(
        self, positions: FloatArray, velocities: FloatArray, change: FloatArray
    ) -> FloatArray:
        """Return the derivative of the forces along a change of beta [Pa s], shape (T,)."""
        self._place(positions, velocities)
        self._change.assign(change)
        self._launch(viscous_forces, [self._change], [], [self._out])
        return self._out.read()

    def begin_sums(self) -> None:
        """Let `pull_back` start its sums anew."""
        for mirror in self._sums:
            mirror.clear()

    def pull_back(
        self,
        positions: FloatArray,
        velocities: FloatArray,
        adjoint: FloatArray,
        *,
        has_positions: bool,
    ) -> tuple[FloatArray, FloatArray]:
        """Return adjoint . d forces by positions and by velocities; add that by the material.

        Args:
            positions: [m], shape (N, 3).
            velocities: [m/s], shape (N, 3).
            adjoint: shape (N, 3).
            has_positions: whether the derivative by positions is wanted; else it is zero.
        """
        self._place(positions, velocities)
        self._other.clear()
        self._first.write(adjoint)
        self._launch(
            self._kernels.pull_back,
            self._lame_parameters(),
            [self._first.array, has_positions],
            [self._out, self._other, *self._sums],
        )
        return self._out.read(), self._other.read()

    def sums(self) -> tuple[LameParameters, FloatArray]:
        """Return sums of adjoint . d forces by the energy's constants and by beta, (T,) each."""
        by_mu, by_lambda, by_beta = (mirror.read() for mirror in self._sums)
        return LameParameters(by_mu, by_lambda), by_beta

    def _lame_parameters(self) -> list[Any]:
        return [*self._elastic.lame_parameters_on_device, self._beta]

    def _place(self, positions: FloatArray, velocities: FloatArray) -> None:
        self._positions.write(positions)
        self._velocities.write(velocities)
        self._out.clear()

    def _launch(
        self, kernel: Any, lame_parameters: list[Any], inputs: list[Any], outputs: list[HostMirror]
    ) -> None:
        shape = self._elastic.shape_on_device
        state = [self._positions.array, self._velocities.array]
        self._launcher.launch(
            kernel,
            self._tet_count,
            [*shape, *lame_parameters, *state, *inputs],
            [mirror.array for mirror in outputs],
        )
