# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Sums over the steps of an adjoint march that become the gradient by the inputs."""

from diffcal_ros.fem.motion.dynamics import Dynamics
from diffcal_ros.fem.motion.inputs import MotionGradient
from diffcal_ros.fem.statics.force_changes import StaticGradient
from diffcal_ros.material import LameParameters
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


class GradientSum:
    """Collects -adjoint . d (M a + f) by every input; only what differs by step is looked at."""

    def __init__(self, dynamics: Dynamics) -> None:
        self._dynamics = dynamics
        nodes, tets = len(dynamics.masses), len(dynamics.fractions)
        dynamics.elements.begin_sums()
        self._stiffening = np.zeros(tets)
        self._adjoint = np.zeros((nodes, 3))
        self._by_masses = np.zeros(nodes)
        self._by_mass_damping = 0.0

    def add(
        self,
        positions: FloatArray,
        velocities: FloatArray,
        accelerations: FloatArray,
        adjoint: FloatArray,
    ) -> None:
        """Add one state, which `Dynamics.pull_back` has seen with the same adjoint.

        Args:
            positions: [m], shape (N, 3).
            velocities: [m/s], shape (N, 3).
            accelerations: [m/s^2], shape (N, 3); those of held nodes are not read.
            adjoint: of the equation of motion there, zero on held nodes, shape (N, 3).
        """
        dynamics = self._dynamics
        stiffening = dynamics.body.force_changes.stiffening_by_mu(positions, adjoint)
        if stiffening is not None:
            self._stiffening += stiffening
        self._adjoint += adjoint
        along_velocity = np.einsum('ni,ni->n', adjoint, velocities)
        self._by_masses -= np.einsum('ni,ni->n', adjoint, accelerations)
        self._by_masses -= dynamics.mass_damping * along_velocity
        self._by_mass_damping -= float(dynamics.masses[:, 0] @ along_velocity)

    def total(self, start: StaticGradient, release_time: float) -> MotionGradient:
        """Return the gradient, with that of the state at rest before the release."""
        dynamics, inputs = self._dynamics, self._dynamics.inputs
        lame_parameters, by_beta = dynamics.elements.sums()
        by_mu = lame_parameters.neo_hookean_mu + self._stiffening
        moving = dynamics.body.force_changes.collect(
            LameParameters(by_mu, lame_parameters.neo_hookean_lambda),
            self._adjoint,
            inputs.material,
            inputs.gravity,
        )
        nodes = dynamics.body.discretisation.nodes
        inertial = np.einsum('ta,ta->t', dynamics.fractions, self._by_masses[nodes])
        return MotionGradient(
            youngs_modulus=moving.youngs_modulus + start.youngs_modulus,
            poissons_ratio=moving.poissons_ratio + start.poissons_ratio,
            density=moving.density + start.density + inertial,
            gravity=moving.gravity + start.gravity,
            damping=-by_beta,
            mass_damping=self._by_mass_damping,
            release_time=release_time,
        )
