# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""An elastic body on a device: energy, forces, stiffness and their derivatives."""

from functools import cache
from types import ModuleType
from typing import Any

from diffcal_ros.fem.elements.element import Discretisation
from diffcal_ros.fem.elements.element_kernels import (
    ElementKernels,
    growth_unforeseen,
    make_element_kernels,
)
from diffcal_ros.fem.elements.sparse_pattern import SparsePattern
from diffcal_ros.fem.laws import stable_neo_hookean
from diffcal_ros.material import LameParameters
from diffcal_ros.warp_runtime.device_array import (
    download,
    float_array,
    int_array,
    point_array,
    shared,
    upload,
    zero_floats,
    zero_points,
)
from diffcal_ros.warp_runtime.launcher import Launcher
import numpy as np
from numpy.typing import NDArray
import warp as wp

FloatArray = NDArray[np.float64]


@cache
def _kernels(law: ModuleType) -> ElementKernels:
    return make_element_kernels(law)


class ElasticBody:
    """Elements of one energy law; every method takes node positions and returns NumPy arrays."""

    def __init__(
        self,
        discretisation: Discretisation,
        *,
        law: ModuleType = stable_neo_hookean,
        device: str = 'cpu',
    ) -> None:
        self.discretisation = discretisation
        self.device = device
        self._launcher = Launcher(device)
        self.law = law
        self._kernels = _kernels(law)
        self._mean_shear_modulus = 0.0
        # Counts the materials set, so that factorisations know whether they are out of date.
        self.material_count = 0
        tet_count = len(discretisation.nodes)
        self._positions = point_array(discretisation.rest_nodes, device)
        self._direction = zero_points(discretisation.node_count, device)
        self._internal = zero_points(discretisation.node_count, device)
        self._mu, self._lam, self._dmu, self._dlam, self._energies = (
            zero_floats(tet_count, device) for _ in range(5)
        )
        self._nodes = int_array(discretisation.nodes, device)
        self._gradients = point_array(discretisation.gradients, device)
        self._weights = float_array(discretisation.weights, device)

    def set_lame_parameters(self, lame_parameters: LameParameters) -> None:
        """Set the material of every tetrahedron."""
        upload(self._mu, lame_parameters.neo_hookean_mu)
        upload(self._lam, lame_parameters.neo_hookean_lambda)
        self.material_count += 1
        self._mean_shear_modulus = float(np.mean(lame_parameters.neo_hookean_mu))

    def set_rest_shape(self, discretisation: Discretisation) -> None:
        """Take the shape without stress from other nodes of the same elements."""
        upload(self._gradients, discretisation.gradients)
        upload(self._weights, discretisation.weights)
        self.material_count += 1

    def mean_shear_modulus(self) -> float:
        """Return the mean of the energy's mu [Pa]: the scale of the body's stiffness."""
        return self._mean_shear_modulus

    @property
    def shape_on_device(self) -> list[Any]:
        """Nodes, shape gradients and weights for kernels."""
        return [self._nodes, self._gradients, self._weights]

    @property
    def lame_parameters_on_device(self) -> list[Any]:
        """The energy's mu and lambda for kernels."""
        return [self._mu, self._lam]

    def energy(self, positions: FloatArray) -> float:
        """Return the elastic energy [J] at node positions [m], shape (N, 3)."""
        upload(self._positions, positions)
        self._launch(self._kernels.energy, [self._positions], [self._energies])
        return float(self._energies.numpy().sum())

    def forces(self, positions: FloatArray) -> FloatArray:
        """Return the energy's gradient by the positions [N], shape (N, 3)."""
        upload(self._positions, positions)
        self._internal.zero_()
        self._launch(self._kernels.forces, [self._positions], [self._internal])
        return download(self._internal)

    def force_tangent(self, positions: FloatArray, direction: FloatArray) -> FloatArray:
        """Return stiffness times a direction [m], shape (N, 3): no matrix is built."""
        upload(self._positions, positions)
        upload(self._direction, direction)
        self._internal.zero_()
        self._launch(
            self._kernels.force_tangent, [self._positions, self._direction], [self._internal]
        )
        return download(self._internal)

    def force_of_lame_parameters(
        self, positions: FloatArray, change: LameParameters
    ) -> FloatArray:
        """Return the derivative of the forces along a change of the material, shape (N, 3)."""
        upload(self._positions, positions)
        upload(self._dmu, change.neo_hookean_mu)
        upload(self._dlam, change.neo_hookean_lambda)
        self._internal.zero_()
        self._launch(
            self._kernels.force_of_lame_parameters,
            [self._dmu, self._dlam, self._positions],
            [self._internal],
        )
        return download(self._internal)

    def number_gradient(self, positions: FloatArray, adjoint: FloatArray) -> LameParameters:
        """Return adjoint . d forces / d (mu, lambda) of every tetrahedron, shape (T,) each."""
        upload(self._positions, positions)
        upload(self._direction, adjoint)
        self._launch(
            self._kernels.number_gradient,
            [self._positions, self._direction],
            [self._dmu, self._dlam],
        )
        return LameParameters(download(self._dmu), download(self._dlam))

    def diagonal_blocks(self, positions: FloatArray) -> FloatArray:
        """Return the guarded stiffness of each node with itself [N/m], shape (N, 3, 3)."""
        upload(self._positions, positions)
        count = self.discretisation.node_count
        blocks = wp.zeros(count, dtype=wp.mat33d, device=self.device)
        self._launch(self._kernels.diagonal, [self._positions], [blocks])
        return download(blocks)

    def make_stiffness(self, pattern: SparsePattern) -> 'Stiffness':
        """Prepare assembly into a pattern."""
        return Stiffness(self, pattern)

    def _launch(self, kernel: Any, inputs: list[Any], outputs: list[Any]) -> None:
        shared = [self._nodes, self._gradients, self._weights, self._mu, self._lam]
        self._launcher.launch(kernel, len(self.discretisation.nodes), [*shared, *inputs], outputs)


class Stiffness:
    """Assembles the energy's Hessian straight into a fixed pattern.

    Attributes:
        foresees: the law wants pressures foreseen, see `values`.
    """

    def __init__(self, body: ElasticBody, pattern: SparsePattern) -> None:
        self._body = body
        self._slots = shared(pattern.slots, wp.int32, body.device)
        self._values = zero_floats(pattern.entry_count, body.device)
        self._growths = zero_floats(body.discretisation.weights.shape, body.device)
        self.foresees = bool(getattr(body.law, 'PRESSES_BY_VOLUME', False))
        self._last_step: FloatArray | None = None

    def foresee(self, before: FloatArray, step: FloatArray) -> None:
        """Keep a step [m] and where it began, for `values` of `is_foreseen`; shape (N, 3) each."""
        if self.foresees:
            self._last_step = np.stack([before, step])

    @property
    def knows_step(self) -> bool:
        """Tell whether there is a step to foresee pressures by."""
        return self._last_step is not None

    def forget_step(self) -> None:
        """Foresee nothing until there is another step."""
        self._last_step = None

    def values(
        self, positions: FloatArray, *, is_guarded: bool = False, is_foreseen: bool = False
    ) -> FloatArray:
        """Return the entries [N/m] at node positions [m], shape (nnz,).

        Args:
            positions: shape (N, 3).
            is_guarded: leave out what makes the matrix indefinite far from equilibrium.
            is_foreseen: with the pressures that the linear model of the last step foresaw. A step
                puts volumes wrong by its square, which near nu = 0.5 makes pressures that the
                step after takes back. As in a method that has pressures as unknowns, forces are
                those of the volumes, and only the stiffness knows the pressures.
        """
        body = self._body
        foresees = is_foreseen and self.knows_step
        if foresees:
            self._compare_volumes(positions)
        upload(body._positions, positions)
        self._values.zero_()
        body._launch(
            body._kernels.stiffness,
            [body._positions, self._slots, is_guarded, self._growths, foresees],
            [self._values],
        )
        return download(self._values)

    def _compare_volumes(self, positions: FloatArray) -> None:
        body = self._body
        assert self._last_step is not None
        before, step, now = (
            point_array(each, body.device) for each in (*self._last_step, positions)
        )
        inputs = [body._nodes, body._gradients, before, step, now]
        body._launcher.launch(
            growth_unforeseen, len(body.discretisation.nodes), inputs, [self._growths]
        )
