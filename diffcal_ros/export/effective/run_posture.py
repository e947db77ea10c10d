# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body at rest that another simulator finds, in the place of this package's own."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from diffcal_ros.calibration.forward.posture import PostureInputs, RestingPosture, RestingStates
from diffcal_ros.export.effective.simulators import Run
from diffcal_ros.export.exported_body import constants_at_rest, ExportedBody
from diffcal_ros.fem.statics.equilibrium import EquilibriumError
from diffcal_ros.fem.statics.force_changes import Change, StaticGradient
from diffcal_ros.material import Material
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Of a parameter's unit, which is that of a logarithm for moduli.
DIFFERENCE = 0.02


@dataclass(frozen=True)
class RunStates:
    """A body at rest.

    Attributes:
        inputs: what it depends on.
        positions: of its vertices, world frame [m], shape (1, V, 3).
    """

    inputs: PostureInputs
    positions: FloatArray


class RunPosture:
    """See `calibration.forward.posture.Posture`.

    This package's linear elements settle first: where they are the simulator begins, or else where
    it was last at rest.

    Attributes:
        body: this package's own, with the shape that cameras trace.
    """

    def __init__(
        self, own: RestingPosture, body: ExportedBody, run: Run, *, difference: float = DIFFERENCE
    ) -> None:
        """Take what is simulated, and how.

        Args:
            own: of the same body with linear elements.
            body: as the simulator is given it, but for the material.
            run: the simulator.
            difference: half the width of the differences that derivatives are taken by.
        """
        self.body = own.body
        self._own = own
        self._exported = body
        self._run = run
        self._difference = difference
        self._settled: RestingStates | None = None
        self._last: FloatArray | None = None

    def solve(
        self,
        inputs: PostureInputs,
        warm: RunStates | None = None,
        prediction: FloatArray | None = None,
    ) -> RunStates:
        """Find where the simulator comes to rest."""
        return RunStates(inputs, self._rest(inputs)[None])

    def tangents(self, states: RunStates, changes: Sequence[Change]) -> FloatArray:
        """Return how the vertices follow changes of the material [m], shape (k, 1, V, 3).

        Raises:
            NotImplementedError: for a change of something else.
        """
        inputs, rates = states.inputs, []
        for change in changes:
            low, high = (
                self._rest(replace(inputs, material=changed_material(inputs, change, step)))
                for step in (-self._difference, self._difference)
            )
            rates.append((high - low) / (2.0 * self._difference))
        return np.array(rates)[:, None]

    def gradient(self, states: RunStates, by_positions: FloatArray) -> StaticGradient:
        """Refuse: a simulator that is only run has no adjoint."""
        raise NotImplementedError('a simulator that is run gives no gradient: fit by tangents')

    def mesh_moves(self, states: RunStates, solver: str) -> FloatArray:
        """Return no move: the mesh that is exported is what the parameters are made for."""
        return np.zeros_like(states.positions)

    def warnings(self, states: RunStates) -> list[str]:
        """Say nothing: the simulator came to rest, or an error told otherwise."""
        return []

    def _rest(self, inputs: PostureInputs) -> FloatArray:
        try:
            self._settled = self._own.solve(inputs, self._settled)
            start = self._settled.positions[0]
        except EquilibriumError:
            start = self._exported.mesh.rest_positions if self._last is None else self._last
        self._last = self._run(body_with(self._exported, inputs), start)
        return self._last


def body_with(body: ExportedBody, inputs: PostureInputs) -> ExportedBody:
    """Return a body with the material and the gravity of some inputs."""
    modulus, ratio = constants_at_rest(inputs.material)
    return replace(
        body,
        youngs_modulus=modulus,
        poissons_ratio=ratio,
        density=inputs.material.density,
        gravity=inputs.gravity,
    )


def changed_material(inputs: PostureInputs, change: Change, step: float) -> Material:
    """Return the material a step along a change.

    Raises:
        NotImplementedError: for a change of gravity or conditions.
    """
    if change.gravity is not None or change.conditions is not None or change.beyond_gradient:
        raise NotImplementedError('a simulator that is run follows the material alone')
    material = inputs.material
    columns = {
        name: getattr(material, name) + step * getattr(change, name)
        for name in ('youngs_modulus', 'poissons_ratio', 'density')
        if getattr(change, name) is not None
    }
    return replace(material, **columns)
