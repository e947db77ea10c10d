# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The equation of motion: masses, forces at positions and velocities, and their derivatives.

    M a + f(x, v) = 0,    f = elastic and contact forces + damping - loads

on the free nodes, with a diagonal M (`lumped_mass`).
"""

from dataclasses import replace

from diffcal_ros.fem.giving_clamp import GivingClamp
from diffcal_ros.fem.motion.air_drag import AirDrag
from diffcal_ros.fem.motion.inputs import MotionChange, MotionError, MotionInputs
from diffcal_ros.fem.motion.lumped_mass import lumped_fractions, lumped_masses
from diffcal_ros.fem.motion.moving_elements import MovingElements
from diffcal_ros.fem.statics.force_changes import Change
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.fem.terms.conditions import NO_CONDITIONS
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


class Dynamics:
    """Forces on one body; positions [m], velocities [m/s] and forces [N] have shape (N, 3)."""

    def __init__(self, body: StaticBody) -> None:
        self.body = body
        self.pattern = body.solver.stiffness.pattern
        self.free = self.pattern.free_nodes
        self.fractions = lumped_fractions(body.discretisation)
        self.elements = MovingElements(body.elastic, self.pattern)
        self.drag = AirDrag(body.discretisation, self.free)
        self.masses = np.zeros((body.discretisation.node_count, 1))
        self.loads = np.zeros((body.discretisation.node_count, 3))
        self.clamp = GivingClamp.of(body.clamp, body.held_nodes, NO_CONDITIONS)
        self._time = 0.0
        self._inputs: MotionInputs | None = None
        self._mass_damping = 0.0

    @property
    def inputs(self) -> MotionInputs:
        """The inputs taken last."""
        if self._inputs is None:
            raise RuntimeError('no motion yet: call simulate first')
        return self._inputs

    def take(self, inputs: MotionInputs) -> None:
        """Take material, damping, gravity and effects."""
        self._inputs, self._time = inputs, 0.0
        gravity = inputs.gravity_at(0.0)
        self.loads = self.body.prepare(inputs.material, gravity, inputs.conditions)
        masses = lumped_masses(self.body.discretisation, self.fractions, inputs.material.density)
        if inputs.conditions.added_masses is not None:
            masses = masses + inputs.conditions.added_masses
        if not (masses > 0.0).all():
            raise MotionError(
                'the added mass takes more than there is at some node: a moving body needs a '
                'positive mass everywhere'
            )
        self.masses = masses[:, None]
        self.elements.set_damping(inputs.damping.strain_rate)
        self._mass_damping = inputs.damping.mass
        self.drag.set_area(inputs.conditions.air_drag)
        self.clamp = GivingClamp.of(self.body.clamp, self.body.held_nodes, inputs.conditions)

    def go_to(self, time: float) -> None:
        """Have loads as they are at a time since the start [s]."""
        before, self._time = self._time, time
        inputs = self.inputs
        if inputs.gravity_course and time != before:
            more = inputs.gravity_at(time) - inputs.gravity_at(before)
            self.loads = self.loads + self._weight_of(more)

    def _weight_of(self, gravity: FloatArray) -> FloatArray:
        """Return what a gravity more pulls at nodes [N]."""
        change, inputs = Change(gravity=gravity), self.inputs
        return self.body.force_changes.along(
            np.zeros_like(self.loads), change, inputs.material, inputs.gravity
        )

    def forces(self, positions: FloatArray, velocities: FloatArray) -> FloatArray:
        """Return f(x, v)."""
        forces = self.elements.forces(positions, velocities)
        forces -= self.loads
        for term in self.body.solver.stiffness.terms:
            forces += term.forces(positions)
        if self._mass_damping != 0.0:
            forces += self._mass_damping * self.masses * velocities
        if self.drag.is_present:
            forces += self.drag.forces(velocities)
        return forces

    def accelerations(self, positions: FloatArray, velocities: FloatArray) -> FloatArray:
        """Return -f / M on free nodes and zero on held ones [m/s^2]."""
        result = np.zeros_like(positions)
        free = self.free
        result[free] = -self.forces(positions, velocities)[free] / self.masses[free]
        return result

    def system_values(self, positions: FloatArray, inertia: float, rate: float) -> FloatArray:
        """Return the main part of a step's matrix in the pattern [N/m], shape (nnz,).

        Args:
            positions: where forces are linearised.
            inertia: change of acceleration per change of position [1/s^2].
            rate: change of velocity per change of position [1/s].
        """
        values = self.elements.stiffness(positions, rate)
        for term in self.body.solver.stiffness.terms:
            values += term.stiffness(positions, is_guarded=False)
        weights = (inertia + self._mass_damping * rate) * self.masses[self.free, 0]
        values[self.pattern.diagonal_slots] += np.repeat(weights, 3)
        return values

    @property
    def has_rest(self) -> bool:
        """Tell whether `system_values` leaves anything out."""
        return self.elements.is_damped or self.drag.is_present

    def rest_product(
        self,
        positions: FloatArray,
        velocities: FloatArray,
        directions: FloatArray,
        rate: float,
        *,
        is_transposed: bool,
    ) -> FloatArray:
        """Return what `system_values` leaves out times each direction, shape (k, N, 3)."""
        product = np.zeros_like(directions)
        if self.elements.is_damped:
            product = self.elements.rest_product(
                positions, velocities, directions, is_transposed=is_transposed
            )
        if self.drag.is_present:
            product += rate * self.drag.tangents(velocities, directions)
        return product

    def force_tangent(
        self, positions: FloatArray, velocities: FloatArray, moved: FloatArray, sped: FloatArray
    ) -> FloatArray:
        """Return how f follows changes of positions and velocities."""
        forces = self.body.solver.stiffness.force_tangent(positions, moved)
        if self.elements.is_damped:
            forces += self.elements.viscous_tangent(positions, velocities, moved, sped)
        if self._mass_damping != 0.0:
            forces += self._mass_damping * self.masses * sped
        if self.drag.is_present:
            forces += self.drag.tangent(velocities, sped)
        return forces

    def velocity_tangents(
        self, positions: FloatArray, velocities: FloatArray, sped: FloatArray
    ) -> FloatArray:
        """Return how f follows each change of velocities alone, shape (k, N, 3)."""
        forces = self._mass_damping * self.masses * sped
        if self.elements.is_damped:
            forces += self.elements.velocity_tangents(positions, velocities, sped)
        if self.drag.is_present:
            forces += self.drag.tangents(velocities, sped)
        return forces

    def pull_back(
        self,
        positions: FloatArray,
        velocities: FloatArray,
        adjoint: FloatArray,
        *,
        has_positions: bool,
    ) -> tuple[FloatArray, FloatArray]:
        """Return adjoint . df by positions (zero if not wanted) and by velocities.

        What it gives by the material goes into the sums of `elements`.
        """
        by_positions, by_velocities = self.elements.pull_back(
            positions, velocities, adjoint, has_positions=has_positions
        )
        if has_positions:
            for term in self.body.solver.stiffness.terms:
                by_positions += term.force_tangent(positions, adjoint)
        if self._mass_damping != 0.0:
            by_velocities += self._mass_damping * self.masses * adjoint
        if self.drag.is_present:
            by_velocities += self.drag.tangent(velocities, adjoint)
        return by_positions, by_velocities

    def residual_change(
        self,
        positions: FloatArray,
        velocities: FloatArray,
        accelerations: FloatArray,
        change: Change,
    ) -> FloatArray:
        """Return how M a + f follows the inputs in a fixed state, at the time gone to."""
        inputs, change = self.inputs, change_at(change, self.inputs, self._time)
        residual = -self.body.force_changes.along(
            positions, change, inputs.material, inputs.gravity_at(self._time)
        )
        inertial = accelerations + self._mass_damping * velocities
        if change.density is not None:
            masses = lumped_masses(self.body.discretisation, self.fractions, change.density)
            residual += masses[:, None] * inertial
        if change.conditions is not None and change.conditions.added_masses is not None:
            residual += change.conditions.added_masses[:, None] * inertial
        if change.conditions is not None and change.conditions.air_drag != 0.0:
            residual += change.conditions.air_drag * self.drag.force_of_area(velocities)
        if isinstance(change, MotionChange):
            if change.damping is not None:
                residual += self.elements.force_of_damping(positions, velocities, change.damping)
            residual += change.mass_damping * self.masses * velocities
        return residual

    @property
    def mass_damping(self) -> float:
        """Mass-proportional damping [1/s]."""
        return self._mass_damping


def change_at(change: Change, inputs: MotionInputs, time: float) -> Change:
    """Return what a change of a motion is at a time since the start [s].

    Its gravity counts there by its knot, and what is let go later has gravity as it is later.

    Args:
        change: with its knot on that axis.
        inputs: of the motion.
        time: since the start [s].
    """
    if not isinstance(change, MotionChange):
        return change
    gravity = change.gravity
    if gravity is not None and change.knot is not None:
        gravity = float(change.weights(time)) * gravity
    if change.release_time != 0.0:
        for knot, own in inputs.gravity_course:
            later = change.release_time * knot.slope(time) * own
            gravity = later if gravity is None else gravity + later
    return change if gravity is change.gravity else replace(change, gravity=gravity)
