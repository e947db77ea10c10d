# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body that rests on a support until that lets go: one simulation for all of its frames."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from diffcal_ros.calibration.forward.finer_motion import is_affordable, refined_inputs
from diffcal_ros.calibration.forward.known_motions import fingerprint, KnownMotions
from diffcal_ros.calibration.forward.posture import make_body, PostureInputs
from diffcal_ros.damping import Damping
from diffcal_ros.fem.elements.prolongation import refine
from diffcal_ros.fem.motion.inputs import HeldMotion, Release
from diffcal_ros.fem.motion.moving_body import LONGEST_STEP, Motion, MovingBody, TIME_STEP
from diffcal_ros.fem.motion.path import Path
from diffcal_ros.fem.statics.force_changes import Change, StaticGradient
from diffcal_ros.fem.statics.mesh_error import MeshError
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.scene.body_plan import plan_body
from diffcal_ros.scene.model import ObservationSetup, Scene
from diffcal_ros.scene.refinement import refined_scene
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


_SECOND_ORDER = 'implicit'
# Share of a second-order error that half the step removes.
_BY_HALVING = 1.0 - 0.5**2
# So many times its tolerance a step may err before that is told.
_COARSE = 2.0


@dataclass(frozen=True)
class MovingStates:
    """A body in motion.

    Attributes:
        inputs: what it depends on.
        motion: at its frames.
    """

    inputs: PostureInputs
    motion: Motion

    @property
    def positions(self) -> FloatArray:
        """The nodes, world frame [m], shape (S, N, 3)."""
        return self.motion.positions


class MovingPosture:
    """A body in motion; its last march is kept for the derivatives.

    Attributes:
        body: held by the parts that stay.
    """

    def __init__(
        self,
        scene: Scene,
        setup: ObservationSetup,
        times: Sequence[float],
        solver: str,
        device: str,
        *,
        has_derivatives: bool = True,
    ) -> None:
        """Prepare one body.

        Args:
            scene: mesh and material law.
            setup: its motion and held parts.
            times: of the frames, after the first one [s], shape (S,).
            solver: name of the sparse solver.
            device: Warp device.
            has_derivatives: whether tangents or gradients will be asked for.

        Raises:
            ValueError: for an observation that does not move.
        """
        if setup.motion is None:
            raise ValueError(f'{setup.name} is at rest: it has no motion to simulate')
        self._times = np.array(times, dtype=np.float64)
        self._plan = plan = plan_body(scene, setup)
        self._scene, self._setup = scene, setup
        self._solver, self._device = solver, device
        self.body = self._make_body()
        targets = plan.mesh.rest_positions.copy()
        targets[plan.held.vertices] = plan.held.positions
        self._clamped_at = targets[plan.staying.vertices]
        released = plan.released
        self._release = Release(released, setup.motion.release_time.start, targets[released])
        self._name, self._integrator = setup.name, setup.motion.integrator
        self._tolerance = setup.motion.tolerance
        usual = TIME_STEP if self._tolerance is None else LONGEST_STEP
        self._time_step = setup.motion.time_step or usual
        self._moving = MovingBody(
            self.body,
            self._release,
            integrator=self._integrator,
            time_step=self._time_step,
            tolerance=self._tolerance,
            has_derivatives=has_derivatives,
        )
        self._at: MovingStates | None = None
        self._known: KnownMotions[MovingStates] = KnownMotions()
        self._is_turned = plan.staying.path is not None

    def _make_body(self) -> StaticBody:
        return make_body(self._plan, self._plan.staying, self._solver, self._device)

    def solve(
        self,
        inputs: PostureInputs,
        warm: MovingStates | None = None,
        prediction: FloatArray | None = None,
    ) -> MovingStates:
        """Simulate; the motion starts from rest and needs no prediction.

        Where a tolerance chooses the steps, those of the warm states stay: tangents and adjoint
        are exact for fixed steps, and a cost whose steps were chosen anew would jump by what the
        tolerance allows wherever one of them changes, which no gradient knows of.
        """
        rungs = () if warm is None else self._rungs(warm)
        near = None if warm is None else self._moving.path

        def simulate() -> MovingStates:
            self._at = MovingStates(inputs, self._simulate(self._moving, inputs, rungs, near))
            return self._at

        # Without a tolerance all motions have the same steps, unless one does not converge.
        if self._tolerance is not None:
            return simulate()
        return self._known.states(fingerprint(inputs), simulate)

    def _rungs(self, states: MovingStates) -> tuple[int, ...]:
        """Return the steps that were chosen; none where they are fixed."""
        return () if self._tolerance is None else states.motion.rungs

    def _there(self, states: MovingStates) -> MovingBody:
        """Return the body after the motion of some states, which it may have to run again."""
        if self._at is not states:
            rungs = self._rungs(states)
            self._simulate(self._moving, states.inputs, rungs, self._moving.path)
            self._at = states
        return self._moving

    def _simulate(
        self,
        moving: MovingBody,
        inputs: PostureInputs,
        rungs: Sequence[int],
        near: Path | None,
    ) -> Motion:
        return moving.simulate(
            inputs.material,
            Damping(inputs.damping),
            inputs.gravity,
            self._times,
            held_motion=self._held_motion(),
            conditions=inputs.conditions,
            release_time=inputs.release_time,
            time_offset=inputs.time_offset,
            gravity_course=inputs.gravity_course,
            rungs=rungs or None,
            near=near,
        )

    def tangents(self, states: MovingStates, changes: Sequence[Change]) -> FloatArray:
        """Return how all frames follow changes of the inputs [m], shape (k, S, N, 3)."""
        if not changes:
            return np.zeros((0, *states.positions.shape))
        key = fingerprint(states.inputs), states.motion.rungs
        return self._known.tangents(
            key, changes, lambda missing: self._there(states).tangents(missing)
        )

    def gradient(self, states: MovingStates, by_positions: FloatArray) -> StaticGradient:
        """Pull a derivative by positions, shape (S, N, 3), back to the inputs."""
        return self._there(states).gradient(by_positions)

    def mesh_moves(self, states: MovingStates, solver: str) -> FloatArray:
        """Return about how half the mesh size and step would move the nodes [m], (S, N, 3)."""
        steps = _BY_HALVING * self.step_moves(states)
        if is_affordable(self._scene, states.inputs) and not self._is_turned:
            return self._on_finer_mesh(states) - states.positions + steps
        return self._stiffness_moves(states, solver) + steps

    def _on_finer_mesh(self, states: MovingStates) -> FloatArray:
        """Return where the nodes are if half the mesh size moves them [m], shape (S, N, 3)."""
        scene = refined_scene(replace(self._scene, observations=(self._setup,)))
        (setup,) = scene.observations
        times = self._times.tolist()
        finer = MovingPosture(
            scene, setup, times, self._solver, self._device, has_derivatives=False
        )
        inputs = refined_inputs(states.inputs, self._scene.mesh)
        path = self._there(states).path
        if path is not None:
            enrichment = refine(self._scene.mesh, self.body.discretisation)
            path = path.mapped(enrichment.fine_from_coarse)
        moved = finer._simulate(finer._moving, inputs, self._rungs(states), path)
        # Vertices and middles of edges, in the order of the coarse nodes, come first.
        return moved.positions[:, : scene.mesh.vertex_count]

    def _stiffness_moves(self, states: MovingStates, solver: str) -> FloatArray:
        """Return about how a better mesh would move the nodes [m], shape (S, N, 3).

        A coarse mesh is above all too stiff. How much, the body at rest in its clamp tells, in
        which the better mesh is affordable: that change of stiffness is followed in the motion,
        and what stiffness does not explain grows with how far the body sags in each frame.
        """
        inputs = states.inputs
        stiffer = Change(youngs_modulus=inputs.material.youngs_modulus)
        (by_stiffness,) = self.tangents(states, [stiffer])
        body, path = self._make_body(), self._held_motion()
        body.solve_equilibrium(
            inputs.material, inputs.gravity, held_path=path, conditions=inputs.conditions
        )
        (static,) = body.tangents([stiffer])
        error = MeshError(body, solver=solver)
        moved = error.displacement(inputs.material, inputs.gravity, path)
        fraction = float((static * moved).sum() / max(float((static**2).sum()), 1e-300))
        sag = body.state.positions - body.discretisation.rest_nodes
        sagged = states.positions - body.discretisation.rest_nodes
        follows = np.einsum('sni,ni->s', sagged, sag) / max(float((sag**2).sum()), 1e-300)
        rest = follows[:, None, None] * (moved - fraction * static)
        return fraction * by_stiffness + rest

    def step_moves(self, states: MovingStates) -> FloatArray:
        """Return how steps too short to matter would move the nodes [m], shape (S, N, 3).

        By Richardson's extrapolation from half the step; zero for the semi-implicit integrator,
        whose steps are as short as its stability asks for.
        """
        if self._integrator != _SECOND_ORDER:
            return np.zeros_like(states.positions)
        halved = MovingBody(
            self._make_body(),
            self._release,
            time_step=0.5 * self._time_step,
            has_derivatives=False,
        )
        # Every step in two where a tolerance chose them.
        rungs = [rung for rung in self._rungs(states) for _ in range(2)]
        halfway = self._simulate(halved, states.inputs, rungs, self._there(states).path)
        return (halfway.positions - states.positions) / _BY_HALVING

    def warnings(self, states: MovingStates) -> list[str]:
        """Say so when the time step had to be halved, or steps err more than they may."""
        halvings = states.motion.halvings
        if self._tolerance is not None:
            return self._coarse_steps(states.motion, self._tolerance)
        if not halvings:
            return []
        return [
            f'{self._name}: the time step of {self._time_step:.2g} s did not converge and was '
            f'halved {halvings} times on the way; a shorter `motion.time_step` in the scene '
            'avoids that'
        ]

    def _coarse_steps(self, motion: Motion, tolerance: float) -> list[str]:
        largest = float(motion.step_errors.max(initial=0.0))
        if largest <= _COARSE * tolerance:
            return []
        return [
            f'{self._name}: the time steps were chosen for the start values, and now one of them '
            f'is off by {largest:.2g} m where `motion.tolerance` is {tolerance:.2g}: fit again '
            'from the fitted scene'
        ]

    def _held_motion(self) -> HeldMotion | None:
        """Return where the clamp holds its vertices at any time; None: at rest."""
        return (lambda _: self._clamped_at) if self._is_turned else None
