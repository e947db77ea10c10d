# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Simulated bodies and tracers that models with different parameters share."""

from collections.abc import Callable, Sequence
from typing import Any

from diffcal_ros.calibration.forward.body_factory import make_bodies, state_indices
from diffcal_ros.calibration.forward.posture import Posture
from diffcal_ros.calibration.observations.observation import Observation, pose_owners
from diffcal_ros.depth.tracer import DepthTracer
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.scene.model import Scene

StandIn = Callable[[int, Posture[Any]], Posture[Any]]


class SharedBodies:
    """What is costly to make: one body a posture, one tracer a recording.

    They can be asked about all states that any model has found, see `posture`.

    Attributes:
        bodies: by number of the scene's observation.
        states: which state of its body each observation shows.
        tracers: of each observation.
    """

    def __init__(
        self,
        scene: Scene,
        observations: Sequence[Observation],
        solver: str,
        device: str,
        stand_in: StandIn | None = None,
    ) -> None:
        """Make bodies and tracers.

        Args:
            scene: the set-up.
            observations: what is to be predicted.
            solver: name of the sparse solver.
            device: Warp device.
            stand_in: returns what simulates a body in place of this package, of the number of the
                scene's observation and the usual posture.
        """
        self.bodies = make_bodies(scene, observations, solver, device)
        if stand_in is not None:
            self.bodies = {index: stand_in(index, own) for index, own in self.bodies.items()}
        self.states = state_indices(observations)
        self.tracers = self._make_tracers(observations, device)

    def body(self, observation: Observation) -> StaticBody:
        """Return the simulated body of an observation."""
        return self.bodies[observation.setup_index].body

    def _make_tracers(self, observations: Sequence[Observation], device: str) -> list[DepthTracer]:
        owners = pose_owners(observations)
        tracers: dict[int, DepthTracer] = {}
        for observation, owner in zip(observations, owners, strict=True):
            if owner not in tracers:
                shape = self.body(observation).discretisation
                tracers[owner] = DepthTracer(
                    shape.surface_triangles, shape.node_count, observation.camera, device=device
                )
        return [tracers[owner] for owner in owners]
