# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A clamped body at rest: equilibrium under gravity, its tangents and its adjoint."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from types import ModuleType

from diffcal_ros.fem.body_axes import body_axes, BodyAxes
from diffcal_ros.fem.clamp import Clamp
from diffcal_ros.fem.elements.elastic_body import ElasticBody
from diffcal_ros.fem.elements.element import discretise, Element
from diffcal_ros.fem.held_part import HeldPart, HeldPath, shifted_path
from diffcal_ros.fem.laws import stable_neo_hookean
from diffcal_ros.fem.own_frame import moved_mesh, own_origin
from diffcal_ros.fem.statics.applied_conditions import AppliedConditions
from diffcal_ros.fem.statics.clamp_way import find_way
from diffcal_ros.fem.statics.coupled_solver import coupled_solver
from diffcal_ros.fem.statics.equilibrium import Equilibrium, EquilibriumError
from diffcal_ros.fem.statics.force_changes import (
    Change,
    ForceChanges,
    gravity_loads,
    StaticGradient,
)
from diffcal_ros.fem.statics.static_derivatives import StaticDerivatives
from diffcal_ros.fem.statics.static_state import StaticState
from diffcal_ros.fem.statics.way_from_rest import WayFromRest
from diffcal_ros.fem.terms.cable import CableTerm
from diffcal_ros.fem.terms.cable_route import CableRoute
from diffcal_ros.fem.terms.conditions import Conditions, NO_CONDITIONS
from diffcal_ros.material import Material
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]

# A clamp that gives way has come to rest when its turn changes by less [rad].
_COMPLIANCE_TOLERANCE = 1e-8


class StaticBody:
    """One body in one posture; keeps its last state and factorisation for the next solve.

    Attributes:
        mesh: the body at rest, world frame.
        discretisation: of that mesh.
        origin: of the body's own frame in the world [m], shape (3,), see `own_frame`. Whatever
            is called `own` is in that frame; `elastic`, `solver` and `clamp` know no other.
        own_mesh: the body at rest.
        own_discretisation: of `own_mesh`.
    """

    def __init__(
        self,
        mesh: TetMesh,
        element: Element,
        held_vertices: IntArray,
        *,
        law: ModuleType = stable_neo_hookean,
        solver: str = 'auto',
        device: str = 'cpu',
        cables: Sequence[CableRoute] = (),
        axes: BodyAxes | None = None,
    ) -> None:
        """Prepare elements, pattern and solver.

        Args:
            mesh: the body at rest, placed in the world frame.
            element: which finite element.
            held_vertices: clamped mesh vertices, shape (h,).
            law: energy law module.
            solver: name of the sparse solver.
            device: Warp device.
            cables: that run through the body; their states are among the conditions.
            axes: of the body, world frame, about which it bends; None: found from its shape.
        """
        self.mesh = mesh
        self.origin = own_origin(mesh)
        self.own_mesh = moved_mesh(mesh, -self.origin)
        self.own_discretisation = discretise(self.own_mesh, element)
        self.discretisation = replace(
            self.own_discretisation, rest_nodes=self.own_discretisation.rest_nodes + self.origin
        )
        self.held = HeldPart(self.discretisation, held_vertices)
        self.elastic = ElasticBody(self.own_discretisation, law=law, device=device)
        self.cable_routes = tuple(cables)
        self.cables = tuple(CableTerm(route, self.discretisation) for route in cables)
        self.solver = coupled_solver(self.elastic, self.held_nodes, self.cables, solver)
        rest = self.own_discretisation.rest_nodes
        self._way_from_rest = WayFromRest(self.solver, rest, self.cables)
        self._conditions = AppliedConditions(
            self.own_mesh,
            self.solver.stiffness,
            body_axes(rest, self.held_nodes) if axes is None else axes.moved(-self.origin),
            self.cables,
            self.origin,
        )
        self.force_changes = ForceChanges(self.elastic, self._conditions)
        self.clamp = Clamp(rest[self.held_nodes])
        self._clamp_was_moved = False
        self._held_path: HeldPath | None = None
        like_this = partial(StaticBody, law=law, solver=solver, device=device, cables=cables)
        self._make_guide = partial(like_this, mesh, Element.LINEAR, self.held_vertices)
        self._material: Material | None = None
        self._gravity = np.zeros(3)
        self._state: Equilibrium | None = None
        self._solved: StaticState | None = None

    @property
    def held_vertices(self) -> IntArray:
        """Clamped vertices, shape (h,)."""
        return self.held.vertices

    @property
    def held_nodes(self) -> IntArray:
        """Clamped nodes, shape (H,)."""
        return self.held.nodes

    @property
    def axes(self) -> BodyAxes:
        """The body's own axes in the world frame."""
        return self._conditions.axes.moved(self.origin)

    @property
    def state(self) -> Equilibrium:
        """The last equilibrium, in the world frame.

        Raises:
            RuntimeError: before the first one.
        """
        own = self.own_state
        return replace(own, positions=own.positions + self.origin)

    @property
    def own_state(self) -> Equilibrium:
        """The last equilibrium, in the body's own frame.

        Raises:
            RuntimeError: before the first one.
        """
        if self._state is None:
            raise RuntimeError('no equilibrium yet: call solve_equilibrium first')
        return self._state

    @property
    def solved(self) -> StaticState:
        """The last equilibrium with all that it depends on, see `go_to`.

        Raises:
            RuntimeError: before the first one.
        """
        if self._solved is None:
            raise RuntimeError('no equilibrium yet: call solve_equilibrium first')
        return self._solved

    def go_to(self, solved: StaticState) -> None:
        """Be again where this body has been solved for: nothing is solved."""
        if self._solved is solved:
            return
        self.prepare(solved.material, solved.gravity, solved.conditions)
        self._held_path, self.clamp.gave_way = solved.held_path, solved.clamp_gave_way
        self._clamp_was_moved = solved.conditions.moves_clamp
        self._state, self._solved = solved.own, solved

    def solve_equilibrium(
        self,
        material: Material,
        gravity: FloatArray,
        *,
        held_path: HeldPath | None = None,
        prediction: FloatArray | None = None,
        conditions: Conditions = NO_CONDITIONS,
    ) -> Equilibrium:
        """Find the equilibrium, from the last one where there is one.

        Args:
            material: one value per tetrahedron.
            gravity: acceleration in the world frame [m/s^2], shape (3,).
            held_path: positions of the held vertices in the world frame [m], shape (h, 3), at a
                fraction 0..1 of their motion; followed from rest the first time. None: they stay.
            prediction: expected displacement from the last equilibrium [m], shape (N, 3).
            conditions: effects on the body.

        Returns:
            The equilibrium in the world frame.

        Raises:
            EquilibriumError: when no equilibrium was found.
        """
        self.solve_own_equilibrium(
            material,
            gravity,
            held_path=shifted_path(held_path, -self.origin),
            prediction=prediction,
            conditions=conditions,
        )
        return self.state

    def solve_own_equilibrium(
        self,
        material: Material,
        gravity: FloatArray,
        *,
        held_path: HeldPath | None = None,
        prediction: FloatArray | None = None,
        conditions: Conditions = NO_CONDITIONS,
    ) -> Equilibrium:
        """Do as `solve_equilibrium` in the own frame, `held_path` and the result as well."""
        loads = self.prepare(material, gravity, conditions)
        self._held_path = held_path
        self.clamp.give_way_by(conditions.clamp_ways)
        if conditions.clamp_gives_way and prediction is not None and self._state is not None:
            self._follow_prediction(prediction)
        self._solve(loads, self._clamp_path(), prediction)
        if conditions.clamp_gives_way:
            self._solve_compliant_clamp(loads)
        self._clamp_was_moved = conditions.moves_clamp
        own = self.own_state
        self._solved = StaticState(
            material=material,
            gravity=self._gravity,
            conditions=conditions,
            held_path=held_path,
            clamp_gave_way=self.clamp.gave_way,
            own=own,
            positions=own.positions + self.origin,
        )
        return own

    def prepare(
        self, material: Material, gravity: FloatArray, conditions: Conditions = NO_CONDITIONS
    ) -> FloatArray:
        """Take a material, gravity and effects without settling; return the loads [N], (N, 3)."""
        material.require_conversion(self.elastic.law.CONVERSION)
        self._solved = None
        self._material, self._gravity = material, np.asarray(gravity, dtype=np.float64)
        lame_parameters = material.lame_parameters()
        self.elastic.set_lame_parameters(lame_parameters)
        self._conditions.apply(conditions, lame_parameters)
        loads = self.gravity_loads(material.density, self._gravity)
        if conditions.added_masses is not None:
            loads += conditions.added_masses[:, None] * self._gravity
        if conditions.forces is not None:
            loads += conditions.forces
        return loads

    def clamp_wrench(self) -> FloatArray:
        """Return the body's force on the clamp [N] and moment about its middle [N m], (6,)."""
        return self.clamp.wrench(
            self.own_state.positions[self.held_nodes], -self.own_state.reactions[self.held_nodes]
        )

    def _solve(
        self, loads: FloatArray, held_path: HeldPath | None, prediction: FloatArray | None
    ) -> None:
        held = self.held.node_path(held_path)
        if self._state is not None:
            try:
                self._state = self._from_last(loads, held, prediction)
                return
            except EquilibriumError:
                self._state = None
        is_linear = self.discretisation.element is Element.LINEAR
        linear = None if is_linear else partial(self._linear_shape, held_path)
        self._state = self._way_from_rest.solve(loads, held, linear)

    def _solve_compliant_clamp(self, loads: FloatArray) -> None:
        """Move the clamp until that is what the load on it asks for, by Newton's method."""
        per_load = self._conditions.now.clamp_compliance

        def missing_at(gave_way: FloatArray, displacement: FloatArray | None) -> FloatArray:
            if displacement is not None:
                self.clamp.gave_way = gave_way
                self._solve(loads, self._clamp_path(), displacement)
            return np.asarray(per_load @ self.clamp_wrench() - gave_way)

        find_way(
            self.clamp.gave_way,
            missing_at,
            lambda: self._derivatives().clamp_response(),
            _COMPLIANCE_TOLERANCE,
        )

    def _follow_prediction(self, prediction: FloatArray) -> None:
        """Let the clamp give way as far as its nodes are expected to move [m], shape (N, 3)."""
        held = self.held_nodes
        self.clamp.follow(
            self.held.spread(self._held_vertices_at(1.0)),
            self._conditions.now.clamp_motion,
            (self.own_state.positions + prediction)[held],
            self._conditions.now.clamp_ways,
        )

    def _clamp_path(self) -> HeldPath | None:
        """Return where held vertices go with the clamp's own motion; None: they stay at rest."""
        path, conditions = self._held_path, self._conditions.now
        if not conditions.moves_clamp:
            if path is None and self._clamp_was_moved:
                return lambda _: self._held_vertices_at(1.0)
            return path
        return lambda fraction: self.clamp.place(
            self._held_vertices_at(fraction), conditions.clamp_motion
        )

    def _held_vertices_at(self, fraction: float) -> FloatArray:
        """Return where held vertices should be after a fraction of their motion [m], (h, 3)."""
        if self._held_path is None:
            return self.own_mesh.rest_positions[self.held_vertices]
        return self._held_path(fraction)

    def forget(self) -> None:
        """Start the next solve from rest."""
        self._state = self._solved = None

    def gravity_loads(self, density: FloatArray, gravity: FloatArray) -> FloatArray:
        """Return nodal weights [N], shape (N, 3)."""
        return gravity_loads(self.discretisation, density, gravity)

    def tangents(self, changes: Sequence[Change]) -> FloatArray:
        """Return the displacement per unit of each change [m], shape (k, N, 3)."""
        return self._derivatives().tangents(changes)

    def factor(self) -> None:
        """Factor the stiffness at the last equilibrium: pays before many single solves."""
        self.solver.stiffness.factor_at(self.own_state.positions)

    def gradient(self, by_positions: FloatArray) -> StaticGradient:
        """Pull a derivative by node positions back to the inputs, effects included.

        One adjoint solve, and three more where the clamp gives way.

        Args:
            by_positions: derivative of a scalar by node positions [1/m], shape (N, 3).
        """
        solved, gradient = self.solved, self._derivatives().gradient(by_positions)
        here = gradient.by_effects
        assert here is not None

        def by_effects(change: Conditions) -> float:
            with self._back_at(solved):
                return here(change)

        return replace(gradient, by_effects=by_effects)

    @contextmanager
    def _back_at(self, solved: StaticState) -> Iterator[None]:
        """Be where this body has been solved for, and afterwards where it is now."""
        now = self._solved
        self.go_to(solved)
        yield
        if now is not None:
            self.go_to(now)

    def _derivatives(self) -> StaticDerivatives:
        return StaticDerivatives(
            state=self.own_state,
            stiffness=self.solver.stiffness,
            force_changes=self.force_changes,
            conditions=self._conditions,
            clamp=self.clamp,
            held_nodes=self.held_nodes,
            held_targets=self.held.spread(self._held_vertices_at(1.0)),
            material=self._current_material(),
            gravity=self._gravity,
        )

    def _current_material(self) -> Material:
        if self._material is None:
            raise RuntimeError('no material yet: call solve_equilibrium first')
        return self._material

    def _from_last(
        self, loads: FloatArray, held: HeldPath | None, prediction: FloatArray | None
    ) -> Equilibrium:
        start = self.own_state.positions
        if prediction is not None:
            start = self.solver.advance(start, prediction)
        end = None if held is None else held(1.0)
        return self.solver.solve(loads, start, held_positions=end, is_warm=True)

    def _linear_shape(self, held_path: HeldPath | None, with_cables: bool) -> FloatArray:
        """Return where linear elements end under the same loads [m], shape (N, 3)."""
        cables = self._conditions.now.cables if with_cables else ()
        followed = self._make_guide().solve_own_equilibrium(
            self._current_material(),
            self._gravity,
            held_path=held_path,
            conditions=Conditions(cables=cables),
        )
        return followed.positions[self.discretisation.node_parents].mean(axis=1)
