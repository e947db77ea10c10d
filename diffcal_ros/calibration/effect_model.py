# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""From amplitudes of effects to what they do to the body and to the sensor."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from diffcal_ros.calibration.parameters import Kind, Parameter, ParameterSet
from diffcal_ros.fem.applied_conditions import ConditionsChange
from diffcal_ros.fem.body_axes import body_axes, BodyAxes
from diffcal_ros.fem.conditions import Conditions, NO_CONDITIONS, Plane
from diffcal_ros.fem.creep import Creep
from diffcal_ros.fem.own_frame import own_origin
from diffcal_ros.rigid_motion import tilt_axes
from diffcal_ros.rigid_transform import apply, rotation_matrix
from diffcal_ros.scene.effects import EFFECTS
from diffcal_ros.scene.model import ObservationSetup, Scene
from diffcal_ros.scene.posing import world_positions
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Amplitudes = Mapping[str, Mapping[str, float]]

# An added mass is spread over this share of the body's length.
_MASS_WIDTH = 0.03
_NORMAL_STEP = 1e-5  # Of a finite difference that is exact to rounding [rad].
_RIGID_AXES = ('x', 'y', 'z', 'rx', 'ry', 'rz')
_BENDS = ('a', 'b')


@dataclass(frozen=True)
class SensorModel:
    """How a depth camera reads a true depth z: (1 + scale) z + bias.

    Attributes:
        scale: relative error.
        bias: [m].
        region_bias: of the second material [m].
    """

    scale: float = 0.0
    bias: float = 0.0
    region_bias: float = 0.0

    @property
    def is_exact(self) -> bool:
        """Tell whether it reads what is there."""
        return not (self.scale or self.bias or self.region_bias)

    def reading(self, depth: FloatArray, is_second: NDArray[np.bool_]) -> FloatArray:
        """Return what is read [m] of true depths [m], and where they are of another material."""
        wrong = self.scale * depth + self.bias
        return depth + wrong + self.region_bias * is_second


EXACT_SENSOR = SensorModel()


class EffectModel:
    """The effects of one scene: those that it states, and those that are fitted."""

    def __init__(self, scene: Scene, parameters: ParameterSet) -> None:
        self._scene = scene
        self._parameters = parameters
        centroids = scene.mesh.rest_positions[scene.mesh.tets].mean(axis=1)
        self._object_axes = {
            index: _axes_of(scene, setup) for index, setup in enumerate(scene.observations)
        }
        share = self._object_axes[0].share(centroids)
        self._modes = _modulus_modes(scene, share)
        self._second_region = _second_region(scene, share, 'depth_bias_by_region')
        # A tilt about a world origin far away would lift a plane off the body, or bury it.
        rest = world_positions(scene.mesh, scene.observations[0])
        self._plane_pivot = own_origin(TetMesh(rest, scene.mesh.tets))

    def amplitudes(self, coordinates: FloatArray) -> Amplitudes:
        """Return the amplitudes at some coordinates, SI units, by effect and component."""
        found = {name: dict(given) for name, given in self._scene.effects.items()}
        for parameter, coordinate in zip(self._parameters, coordinates, strict=True):
            if parameter.kind is Kind.EFFECT:
                head, _, component = parameter.name.partition('.')
                settings = EFFECTS[head].settings
                found.setdefault(head, dict(settings))[component] = float(coordinate)
        return found

    def object_axes(self, setup_index: int) -> BodyAxes:
        """Return the body's axes in the object frame; postures may hold other parts."""
        return self._object_axes[setup_index]

    def axes(self, setup_index: int) -> BodyAxes:
        """Return the body's axes in the world frame of one posture."""
        own = self._object_axes[setup_index]
        placed = self._scene.observations[setup_index].world_from_object
        return BodyAxes(
            root=apply(placed, own.root),
            axes=own.axes @ placed[:3, :3].T,
            length=own.length,
            center=apply(placed, own.center),
        )

    def log_modulus(self, amplitudes: Amplitudes) -> FloatArray | None:
        """Return what is added to the logarithm of Young's modulus, shape (T,), or None."""
        contrast = amplitudes.get('stiffness_contrast', {})
        if not self._modes.keys() & contrast.keys():
            return None
        total = np.zeros(self._scene.mesh.tet_count)
        for name, mode in self._modes.items():
            total += contrast.get(name, 0.0) * mode
        return total

    def conditions(
        self, amplitudes: Amplitudes, setup_index: int, rest_nodes: FloatArray
    ) -> Conditions:
        """Return what acts on the body in one posture.

        Args:
            amplitudes: see `amplitudes`.
            setup_index: of the posture.
            rest_nodes: nodes at rest in the world frame [m], shape (N, 3).
        """
        conditions = NO_CONDITIONS
        clamp = amplitudes.get('clamp_offset', {})
        if any(clamp.values()):
            six = np.array([clamp.get(axis, 0.0) for axis in _RIGID_AXES])
            conditions = replace(conditions, clamp_motion=self._to_world(setup_index) @ six)
        compliance = amplitudes.get('compliant_clamp', {}).get('compliance', 0.0)
        if compliance:
            conditions = replace(conditions, clamp_compliance=compliance)
        mass = amplitudes.get('added_mass', {})
        if mass.get('mass', 0.0):
            weights = self._mass_weights(setup_index, rest_nodes, mass['at'])
            conditions = replace(conditions, added_masses=mass['mass'] * weights)
        bend = amplitudes.get('rest_curvature', {})
        if any(bend.values()):
            curvature = np.array([bend.get(axis, 0.0) for axis in _BENDS])
            conditions = replace(conditions, rest_curvature=curvature)
        ratio = amplitudes.get('strain_stiffening', {}).get('ratio', 0.0)
        if ratio:
            conditions = replace(conditions, strain_stiffening=ratio)
        fibres = amplitudes.get('anisotropy', {})
        if fibres.get('ratio', 0.0):
            conditions = replace(
                conditions,
                fibre_ratio=fibres['ratio'],
                fibre_direction=self._fibre_direction(setup_index, fibres),
            )
        area = amplitudes.get('air_drag', {}).get('area', 0.0)
        if area:
            conditions = replace(conditions, air_drag=area)
        plane = amplitudes.get('contact_plane')
        if plane is not None:
            # What tilts gravity in a fit does not tilt the plane.
            stated = self._scene.observations[setup_index].gravity
            normal = plane_normal(stated, plane)
            level = float((normal - upwards(stated)) @ self._plane_pivot)
            conditions = replace(conditions, plane=Plane(normal, plane['height'] + level))
        return conditions

    def change(
        self,
        parameter: Parameter,
        setup_index: int,
        rest_nodes: FloatArray,
        amplitudes: Amplitudes,
    ) -> ConditionsChange | None:
        """Return how a parameter acts on the body, or None where it does not as a condition."""
        head, _, component = parameter.name.partition('.')
        if head == 'clamp_offset':
            column = self._to_world(setup_index)[:, _RIGID_AXES.index(component)]
            return ConditionsChange(clamp_motion=column)
        if head == 'compliant_clamp':
            return ConditionsChange(clamp_compliance=1.0)
        if head == 'added_mass':
            at = amplitudes['added_mass']['at']
            weights = self._mass_weights(setup_index, rest_nodes, at)
            return ConditionsChange(added_masses=weights)
        if head == 'rest_curvature':
            return ConditionsChange(rest_curvature=np.eye(2)[_BENDS.index(component)])
        if head == 'strain_stiffening':
            return ConditionsChange(strain_stiffening=1.0)
        if head == 'anisotropy':
            direction = self._fibre_direction(setup_index, amplitudes['anisotropy'])
            return ConditionsChange(fibre_ratio=1.0, fibre_direction=direction)
        if head == 'air_drag':
            return ConditionsChange(air_drag=1.0)
        if head == 'contact_plane':
            return self._plane_change(component, setup_index, amplitudes['contact_plane'])
        return None

    def _fibre_direction(self, setup_index: int, fibres: Mapping[str, float]) -> FloatArray:
        """Return where fibres run at rest in the world frame; along the body by default."""
        given = np.array([fibres.get(name, 0.0) for name in 'xyz'])
        if not given.any():
            return self.axes(setup_index).axes[0]
        rotation = self._scene.observations[setup_index].world_from_object[:3, :3]
        return rotation @ given / np.linalg.norm(given)

    def _plane_change(
        self, component: str, setup_index: int, plane: Mapping[str, float]
    ) -> ConditionsChange:
        if component == 'height':
            return ConditionsChange(plane_height=1.0)
        gravity = self._scene.observations[setup_index].gravity
        normals = [
            plane_normal(gravity, {**plane, component: plane.get(component, 0.0) + step})
            for step in (_NORMAL_STEP, -_NORMAL_STEP)
        ]
        turned = (normals[0] - normals[1]) / (2.0 * _NORMAL_STEP)
        return ConditionsChange(
            plane_normal=turned, plane_height=float(turned @ self._plane_pivot)
        )

    def time_offset(self, amplitudes: Amplitudes) -> float:
        """Return by how much the stamps of depth images are late [s]."""
        return amplitudes.get('time_offset', {}).get('late', 0.0)

    def creep(self, amplitudes: Amplitudes) -> Creep:
        """Return how the material creeps under a held load."""
        pair = amplitudes.get('creep', {})
        return Creep(pair.get('share', 0.0), pair.get('tau', 0.0))

    def modulus_mode(self, parameter: Parameter) -> FloatArray | None:
        """Return d log E / d amplitude of a stiffness contrast, shape (T,), or None."""
        head, _, component = parameter.name.partition('.')
        return self._modes[component] if head == 'stiffness_contrast' else None

    def sensor(self, amplitudes: Amplitudes) -> SensorModel:
        """Return how the depth camera reads."""
        affine = amplitudes.get('depth_affine', {})
        region = amplitudes.get('depth_bias_by_region', {})
        return SensorModel(
            scale=affine.get('scale', 0.0),
            bias=affine.get('bias', 0.0),
            region_bias=region.get('bias', 0.0),
        )

    def second_triangles(
        self, nodes: NDArray[np.int32], triangles: NDArray[np.int32]
    ) -> NDArray[np.bool_]:
        """Tell which surface triangles show another material than the first, shape (F,).

        Args:
            nodes: of the elements, shape (T, n).
            triangles: of the surface, shape (F, 3).
        """
        count = int(nodes.max()) + 1
        votes, all_votes = np.zeros(count), np.zeros(count)
        np.add.at(votes, nodes, self._second_region[:, None].astype(np.float64))
        np.add.at(all_votes, nodes, 1.0)
        shares = votes / np.maximum(all_votes, 1.0)
        found: NDArray[np.bool_] = shares[triangles].mean(axis=1) > 0.5
        return found

    def _to_world(self, setup_index: int) -> FloatArray:
        """Return the rotation of shifts and turns from the object's frame, shape (6, 6)."""
        rotation = self._scene.observations[setup_index].world_from_object[:3, :3]
        both = np.zeros((6, 6))
        both[:3, :3] = both[3:, 3:] = rotation
        return both

    def _mass_weights(self, setup_index: int, rest_nodes: FloatArray, at: float) -> FloatArray:
        share = self.axes(setup_index).share(rest_nodes)
        weights = np.exp(-0.5 * ((share - at) / _MASS_WIDTH) ** 2)
        weights[share == 0.0] = 0.0
        return weights / weights.sum()


def upwards(gravity: FloatArray) -> FloatArray:
    """Return the unit vector against gravity, shape (3,)."""
    length = float(np.linalg.norm(gravity))
    return -gravity / length if length > 0.0 else np.array([0.0, 1.0, 0.0])


def plane_normal(gravity: FloatArray, plane: Mapping[str, float]) -> FloatArray:
    """Return the normal of a plane that is tilted against the horizontal, shape (3,)."""
    tilt = np.array([plane.get(name, 0.0) for name in _BENDS])
    if not tilt.any():
        return upwards(gravity)
    return rotation_matrix(tilt @ np.stack(tilt_axes(gravity))) @ upwards(gravity)


def _second_region(scene: Scene, share: FloatArray, effect: str) -> NDArray[np.bool_]:
    """Tell which tetrahedra an effect takes for another material than the first, shape (T,).

    A scene with one region is split at a share of the free part, which is a setting of the effect.
    """
    if len(scene.regions) == 1:
        given = scene.effects.get(effect, {})
        return share > given.get('at', EFFECTS[effect].settings['at'])
    others = np.ones(scene.mesh.tet_count, dtype=bool)
    others[scene.regions[0].tets] = False
    return others


def _axes_of(scene: Scene, setup: ObservationSetup) -> BodyAxes:
    held = np.unique(np.concatenate([part.vertices for part in setup.held]))
    return body_axes(scene.mesh.rest_positions, held.astype(np.int32))


def _modulus_modes(scene: Scene, share: FloatArray) -> dict[str, FloatArray]:
    second = _second_region(scene, share, 'stiffness_contrast')
    return {'split': np.where(second, 0.5, -0.5), 'along': share - 0.5}
