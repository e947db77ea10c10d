# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""From parameters to what the simulated body takes: material, gravity, and their changes."""

from dataclasses import replace

from diffcal_ros.calibration.forward.effect_model import EffectModel
from diffcal_ros.calibration.parameters.parameters import Kind, Parameter, ParameterSet
from diffcal_ros.effects.registry import EFFECTS
from diffcal_ros.fem.laws import find_law
from diffcal_ros.fem.motion.inputs import in_course, MotionChange
from diffcal_ros.fem.statics.force_changes import Change
from diffcal_ros.fem.terms.conditions import CableState, Conditions
from diffcal_ros.material import Material
from diffcal_ros.scene.model import Scene
from diffcal_ros.scene.sections.cables import start_cables
from diffcal_ros.scene.start_material import start_constant
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_CABLE = (Kind.REST_LENGTH, Kind.CABLE_STIFFNESS)
_MATERIAL = (Kind.YOUNGS_MODULUS, Kind.POISSONS_RATIO, Kind.DENSITY)


class BodyInputs:
    """What the parameters of a fit mean for the body."""

    def __init__(self, scene: Scene, parameters: ParameterSet, effects: EffectModel) -> None:
        self._scene = scene
        self._parameters = parameters
        self._effects = effects

    def material(self, coordinates: FloatArray) -> Material:
        """Return the material of every tetrahedron."""
        scene = self._scene
        modulus, ratio, density = (self._constant(kind, coordinates) for kind in _MATERIAL)
        if scene.relative_modulus is not None:
            modulus *= scene.relative_modulus
        contrast = self._effects.log_modulus(self._effects.amplitudes(coordinates))
        if contrast is not None:
            modulus *= np.exp(contrast)
        return Material(
            modulus,
            ratio,
            density,
            convention=scene.convention,
            conversion=find_law(scene.law).CONVERSION,
        )

    def damping(self, coordinates: FloatArray) -> FloatArray:
        """Return the damping of every tetrahedron by strain rates [Pa s], shape (T,)."""
        return self._constant(Kind.DAMPING, coordinates)

    def _constant(self, kind: Kind, coordinates: FloatArray) -> FloatArray:
        """Return a constant of every tetrahedron, fitted or as it starts, shape (T,)."""
        column = start_constant(self._scene, kind.value)
        for parameter, coordinate in zip(self._parameters, coordinates, strict=True):
            if parameter.kind is kind:
                column[self._scene.regions[parameter.target].tets] = parameter.value(coordinate)
        return column

    def cables(self, setup_index: int, coordinates: FloatArray) -> tuple[CableState, ...]:
        """Return what the cables are like in one posture."""
        setup = self._scene.observations[setup_index]
        states = list(start_cables(self._scene, setup))
        for parameter, coordinate in zip(self._parameters, coordinates, strict=True):
            number, value = parameter.target, parameter.value(coordinate)
            if parameter.kind is Kind.REST_LENGTH:
                pull = setup.pulls.get(self._scene.cables[number].name, 0.0)
                states[number] = replace(states[number], rest_length=value - pull)
            elif parameter.kind is Kind.CABLE_STIFFNESS:
                states[number] = replace(states[number], stiffness=value)
        return tuple(states)

    def release_time(self, setup_index: int, coordinates: FloatArray) -> float:
        """Return when the support of one posture lets go, after its first frame [s]."""
        motion = self._scene.observations[setup_index].motion
        for parameter, coordinate in zip(self._parameters, coordinates, strict=True):
            if parameter.kind is Kind.RELEASE_TIME and parameter.target == setup_index:
                return float(coordinate)
        return 0.0 if motion is None else motion.release_time.start

    def gravity(self, setup_index: int, coordinates: FloatArray) -> FloatArray:
        """Return gravity in the world frame of one posture [m/s^2], shape (3,)."""
        return self._effects.gravity(
            self._effects.amplitudes(coordinates, setup_index), setup_index
        )

    def change(
        self, index: int, setup_index: int, rest_nodes: FloatArray, coordinates: FloatArray
    ) -> Change | None:
        """Return how a parameter acts on the body in one posture, or None where it does not.

        Args:
            index: of the parameter.
            setup_index: of the posture.
            rest_nodes: nodes at rest in the world frame [m], shape (N, 3).
            coordinates: shape (k,).
        """
        parameter: Parameter = self._parameters.parameters[index]
        if parameter.effect:
            return self._effect_change(parameter, setup_index, rest_nodes, coordinates)
        if parameter.kind in (Kind.DAMPING, Kind.RELEASE_TIME):
            return self._motion_change(parameter, setup_index, coordinates[index])
        if parameter.kind in _CABLE:
            return Change(conditions=self._cable_change(parameter, coordinates[index]))
        if parameter.kind not in _MATERIAL:
            return None
        column = np.zeros(self._scene.mesh.tet_count)
        tets = self._scene.regions[parameter.target].tets
        column[tets] = 1.0
        if parameter.kind is Kind.YOUNGS_MODULUS:
            return Change(youngs_modulus=column * self.material(coordinates).youngs_modulus)
        if parameter.kind is Kind.DENSITY:
            return Change(density=column * parameter.value(coordinates[index]))
        return Change(poissons_ratio=column)

    def _cable_change(self, parameter: Parameter, coordinate: float) -> Conditions:
        rates = [CableState(0.0, 0.0) for _ in self._scene.cables]
        rates[parameter.target] = (
            CableState(1.0, 0.0)
            if parameter.kind is Kind.REST_LENGTH
            else CableState(0.0, parameter.value(coordinate))
        )
        return Conditions(cables=tuple(rates))

    def _motion_change(
        self, parameter: Parameter, setup_index: int, coordinate: float
    ) -> MotionChange | None:
        if self._scene.observations[setup_index].motion is None:
            return None
        if parameter.kind is Kind.RELEASE_TIME:
            is_own = parameter.target == setup_index
            return MotionChange(release_time=1.0) if is_own else None
        column = np.zeros(self._scene.mesh.tet_count)
        column[self._scene.regions[parameter.target].tets] = parameter.value(coordinate)
        return MotionChange(damping=column)

    def _effect_change(
        self,
        parameter: Parameter,
        setup_index: int,
        rest_nodes: FloatArray,
        coordinates: FloatArray,
    ) -> Change | None:
        if parameter.posture not in (None, setup_index):
            return None
        knot = parameter.knot
        time = None if knot is None else knot.at
        found = self._effect_change_at(parameter, setup_index, rest_nodes, coordinates, time)
        return found if found is None or knot is None else in_course(found, knot)

    def _effect_change_at(
        self,
        parameter: Parameter,
        setup_index: int,
        rest_nodes: FloatArray,
        coordinates: FloatArray,
        time: float | None,
    ) -> Change | None:
        """Return how an amplitude acts where all are as at a time [s]; None: at all times."""
        is_moving = self._scene.observations[setup_index].motion is not None
        if EFFECTS[parameter.effect].needs_motion and not is_moving:
            return None
        amplitudes = self._effects.amplitudes(coordinates, setup_index, time)
        own = amplitudes[parameter.effect]
        mode = self._effects.modulus_mode(parameter, own)
        if mode is not None:
            return Change(youngs_modulus=mode * self.material(coordinates).youngs_modulus)
        gravity = self._effects.gravity(amplitudes, setup_index)
        site = self._effects.site(setup_index, rest_nodes, gravity)
        return EFFECTS[parameter.effect].change(parameter.amplitude, own, site)
