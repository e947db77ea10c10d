# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""From amplitudes of effects to what they do to the body and to the sensor."""

from collections.abc import Iterator
from dataclasses import replace

from diffcal_ros.calibration.forward.sensor_model import SensorModel, SurfacePlaces
from diffcal_ros.calibration.parameters.parameters import Parameter, ParameterSet
from diffcal_ros.effects import surface_parts
from diffcal_ros.effects.effect import Effect, Numbers
from diffcal_ros.effects.registry import Amplitudes, edge_seen, EFFECTS, seen_boundary
from diffcal_ros.effects.site import SeenPixels, Site, Tets
from diffcal_ros.fem.body_axes import BodyAxes
from diffcal_ros.fem.elements.element import Discretisation
from diffcal_ros.fem.motion.inputs import GravityCourse
from diffcal_ros.fem.own_frame import own_origin
from diffcal_ros.fem.statics.creep import Creep, NO_CREEP
from diffcal_ros.fem.terms.conditions import Conditions, NO_CONDITIONS
from diffcal_ros.scene.model import Scene
from diffcal_ros.scene.posing import object_axes, world_positions
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_ONE_PIXEL = SeenPixels(np.ones(1), np.ones(1, dtype=bool))


class EffectModel:
    """The effects of one scene: those that it states, and those that are fitted."""

    def __init__(self, scene: Scene, parameters: ParameterSet) -> None:
        self._scene = scene
        self._parameters = parameters
        self._object_axes = {
            index: object_axes(scene.mesh, setup) for index, setup in enumerate(scene.observations)
        }
        self._tets = _tets_of(scene, self._object_axes[0])
        rest = world_positions(scene.mesh, scene.observations[0])
        self._pivot = own_origin(TetMesh(rest, scene.mesh.tets))

    def amplitudes(
        self,
        coordinates: FloatArray,
        setup_index: int | None = None,
        time: float | None = None,
    ) -> Amplitudes:
        """Return the amplitudes at some coordinates, SI units, by effect and component.

        Args:
            coordinates: shape (k,).
            setup_index: of the posture in which they are asked for; None: what they are in all.
            time: after the first frame [s]; None: what they are at all times.
        """
        found = {name: dict(given) for name, given in self._scene.effects.items()}
        for parameter, coordinate in zip(self._parameters, coordinates, strict=True):
            if not parameter.effect:
                continue
            own = found.setdefault(parameter.effect, {})
            if parameter.is_in_all:
                own[parameter.amplitude] = float(coordinate)
                continue
            weight = parameter.weight_in(setup_index, time)
            if weight:
                # It comes after what it adds to.
                _add(own, parameter, weight * float(coordinate))
        return {name: {**EFFECTS[name].settings, **own} for name, own in found.items()}

    def object_axes(self, setup_index: int) -> BodyAxes:
        """Return the body's axes in the object frame; postures may hold other parts."""
        return self._object_axes[setup_index]

    def axes(self, setup_index: int) -> BodyAxes:
        """Return the body's axes in the world frame of one posture."""
        return self.site(setup_index).axes

    def site(
        self,
        setup_index: int,
        rest_nodes: FloatArray | None = None,
        gravity: FloatArray | None = None,
        camera_pivot: FloatArray | None = None,
    ) -> Site:
        """Return what effects may know of the body in one posture.

        Args:
            setup_index: of the posture.
            rest_nodes: nodes at rest in the world frame [m], shape (N, 3); default: none.
            gravity: as it acts [m/s^2], world frame, shape (3,); default: as stated.
            camera_pivot: about which the camera's offset turns, in its frame [m], shape (3,).
        """
        setup = self._scene.observations[setup_index]
        return Site(
            self._object_axes[setup_index],
            setup.world_from_object,
            np.zeros((0, 3)) if rest_nodes is None else rest_nodes,
            setup.gravity,
            setup.gravity if gravity is None else gravity,
            self._pivot,
            camera_pivot,
        )

    def gravity(self, amplitudes: Amplitudes, setup_index: int) -> FloatArray:
        """Return gravity in the world frame of one posture [m/s^2], shape (3,)."""
        gravity = self._scene.observations[setup_index].gravity
        for effect, own in _there(amplitudes):
            gravity = effect.gravity(own, gravity)
        return gravity

    def gravity_course(self, coordinates: FloatArray, setup_index: int) -> GravityCourse:
        """Return what gravity is more in the course of one recording."""
        knots = dict.fromkeys(own.knot for own in self._parameters if own.knot is not None)
        if not knots:
            return ()
        usual = self.gravity(self.amplitudes(coordinates, setup_index), setup_index)
        course = []
        for knot in knots:
            there = self.amplitudes(coordinates, setup_index, knot.at)
            more = self.gravity(there, setup_index) - usual
            if more.any():
                course.append((knot, more))
        return tuple(course)

    def log_modulus(self, amplitudes: Amplitudes) -> FloatArray | None:
        """Return what is added to the logarithm of Young's modulus, shape (T,), or None."""
        modes = [
            (own[part.name], effect.log_modulus_mode(part.name, own, self._tets))
            for effect, own in _there(amplitudes)
            for part in effect.parts
            if own.get(part.name)
        ]
        added = [amplitude * mode for amplitude, mode in modes if mode is not None]
        return np.sum(added, axis=0) if added else None

    def conditions(
        self, amplitudes: Amplitudes, setup_index: int, rest_nodes: FloatArray
    ) -> Conditions:
        """Return what acts on the body in one posture.

        Args:
            amplitudes: see `amplitudes`.
            setup_index: of the posture.
            rest_nodes: nodes at rest in the world frame [m], shape (N, 3).
        """
        site, all_of_them = self.site(setup_index, rest_nodes), NO_CONDITIONS
        for effect, own in _there(amplitudes):
            all_of_them = all_of_them.joined(effect.conditions(own, site))
        return all_of_them

    def modulus_mode(self, parameter: Parameter, own: Numbers) -> FloatArray | None:
        """Return d log E / d amplitude of an effect's parameter, shape (T,), or None.

        Args:
            parameter: of the fit.
            own: amplitudes of its effect.
        """
        effect = EFFECTS[parameter.effect]
        return effect.log_modulus_mode(parameter.amplitude, own, self._tets)

    def time_offset(self, amplitudes: Amplitudes) -> float:
        """Return by how much the stamps of depth images are late [s]."""
        return sum(effect.lateness(own) for effect, own in _there(amplitudes))

    def creep(self, amplitudes: Amplitudes) -> Creep:
        """Return how the material creeps under a held load."""
        found = (effect.creep(own) for effect, own in _there(amplitudes))
        return next((creep for creep in found if creep is not None), NO_CREEP)

    def sensor(self, amplitudes: Amplitudes) -> SensorModel:
        """Return how the depth camera reads."""
        return SensorModel(
            tuple(
                (effect.identifier, own)
                for effect, own in _there(amplitudes)
                if effect.depth_error_mode(effect.components[0].name, _ONE_PIXEL) is not None
            )
        )

    def second_triangles(
        self, nodes: NDArray[np.int32], triangles: NDArray[np.int32]
    ) -> NDArray[np.bool_]:
        """Tell which surface triangles show another material than the first, shape (F,).

        Args:
            nodes: of the elements, shape (T, n).
            triangles: of the surface, shape (F, 3).
        """
        is_second = self._tets.second(self._scene.effects.get(seen_boundary().identifier, {}))
        count = int(nodes.max()) + 1
        votes, all_votes = np.zeros(count), np.zeros(count)
        np.add.at(votes, nodes, is_second[:, None].astype(np.float64))
        np.add.at(all_votes, nodes, 1.0)
        fractions = votes / np.maximum(all_votes, 1.0)
        found: NDArray[np.bool_] = fractions[triangles].mean(axis=1) > 0.5
        return found

    def surface(
        self, setup_index: int, shape: Discretisation, triangles: NDArray[np.int32]
    ) -> SurfacePlaces:
        """Return what a depth camera's errors may know of a body's surface in one posture.

        Args:
            setup_index: of the posture.
            shape: the body at rest, world frame.
            triangles: of its surface, shape (F, 3).
        """
        rest, axes = shape.rest_nodes, self.axes(setup_index)
        is_second = self.second_triangles(shape.nodes, triangles)
        surface = SurfacePlaces(
            is_second,
            axes.on_surface(rest, triangles),
            axes.sides(rest, triangles),
            edge=edge_seen(self._scene.effects, setup_index),
        )
        stated = self._scene.effects.get(seen_boundary().identifier)
        if self._tets.is_second is not None or stated is None:
            return surface
        return replace(surface, parts=surface_parts.parts_of(stated))


def _add(own: dict[str, float], parameter: Parameter, more: float) -> None:
    """Add to an amplitude what it is more in one posture, within its bounds."""
    part = parameter.part
    whole = own.get(part.name, 0.0) + more
    own[part.name] = float(np.clip(whole, part.lower, part.upper))


def _there(amplitudes: Amplitudes) -> Iterator[tuple[Effect, Numbers]]:
    """Return the effects that do anything, with their amplitudes."""
    for identifier, effect in EFFECTS.items():
        own = amplitudes.get(identifier)
        if own is not None and effect.is_there(own):
            yield effect, own


def _tets_of(scene: Scene, axes: BodyAxes) -> Tets:
    fraction = axes.fraction(scene.mesh.rest_positions[scene.mesh.tets].mean(axis=1))
    if len(scene.regions) == 1:
        return Tets(fraction, None)
    others = np.ones(scene.mesh.tet_count, dtype=bool)
    others[scene.regions[0].tets] = False
    return Tets(fraction, others)
