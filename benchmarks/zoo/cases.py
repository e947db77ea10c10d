# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""One case: a body, a cluttered view of it, and a scene that is far off."""

from dataclasses import dataclass, replace

from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.material import LameConvention
from diffcal_ros.scene.model import (
    DepthSensor,
    HeldPart,
    ObservationSetup,
    Quantity,
    Region,
    RigidOffset,
    Scene,
)
import numpy as np

from benchmarks.zoo.bodies import BODIES
from benchmarks.zoo.clutter import draw_kinds
from benchmarks.zoo.meshes import fit_mesh, held_vertices
from benchmarks.zoo.solids import FloatArray
from benchmarks.zoo.truth import BOUNDS, DENSITY, draw_truth, GRAVITY, Truth
from benchmarks.zoo.views import draw_sensor, draw_view, measure, stated_pose, View

FIT = ('youngs_modulus', 'rigid_offset')
PRIOR = RigidOffset(translation_std=0.010, rotation_std=np.deg2rad(3.5))
_LARGEST_SHIFT, _LARGEST_TURN = 0.030, np.deg2rad(10.0)
_OFF = 10.0  # Of the start's modulus.
_SEED = 20261122


@dataclass(frozen=True)
class Case:
    """What a fit is given, and the truth.

    Attributes:
        name: body and number.
        truth: the body as it is.
        kinds: of clutter.
        view: what the camera saw.
        offset: by which the stated pose is off: shift [m] and turn [rad], shape (6,).
        scene: what is stated.
        observation: with the stated pose.
    """

    name: str
    truth: Truth
    kinds: tuple[str, ...]
    view: View
    offset: FloatArray
    scene: Scene
    observation: Observation

    def from_truth(self) -> tuple[Scene, Observation]:
        """Return scene and observation that start at the true modulus and pose."""
        scene = with_start(self.scene, self.truth.youngs_modulus)
        return scene, replace(self.observation, depth_from_world=self.view.camera_from_world)


def draw_case(body: str, number: int) -> Case:
    """Draw a case; the same name gives the same case."""
    random = np.random.default_rng([_SEED, list(BODIES).index(body), number])
    truth = draw_truth(BODIES[body](), random)
    kinds = draw_kinds(random)
    view = draw_view(truth, kinds, random)
    sensor, lidar = draw_sensor(random)
    offset = np.concatenate(
        [
            _within(_LARGEST_SHIFT, random),
            _within(_LARGEST_TURN, random),
        ]
    )
    name = f'{body}_{number:02d}'
    depth = measure(view, lidar, random)
    pose = stated_pose(view.camera_from_world, truth.held_middle, offset)
    scene = make_scene(truth, sensor, FIT, PRIOR)
    return Case(
        name=name,
        truth=truth,
        kinds=kinds,
        view=view,
        offset=offset,
        scene=with_start(scene, _far_start(truth.youngs_modulus, random)),
        observation=Observation(name, 0, depth, view.camera, pose),
    )


def make_scene(
    truth: Truth,
    sensor: DepthSensor,
    fit: tuple[str, ...],
    prior: RigidOffset,
    fineness: float = 1.0,
) -> Scene:
    """Return what is stated of a body; it starts at the true modulus.

    Args:
        truth: the body.
        sensor: that films it.
        fit: names of the parameters.
        prior: of the rigid offset.
        fineness: of the mesh; see `fit_mesh`.
    """
    mesh = fit_mesh(truth.solid, fineness)
    region = Region(
        name='body',
        tets=np.arange(mesh.tet_count, dtype=np.int32),
        youngs_modulus=Quantity(truth.youngs_modulus, *BOUNDS),
        poissons_ratio=Quantity(truth.poissons_ratio, 0.0, 0.499),
        density=Quantity(DENSITY, 50.0, 2e4),
    )
    setup = ObservationSetup(
        name='hanging',
        world_from_object=truth.world_from_object,
        gravity=GRAVITY,
        held=(HeldPart('clamp', held_vertices(truth.solid, mesh)),),
    )
    return Scene(
        name=truth.solid.name,
        mesh=mesh,
        element=Element.QUADRATIC,
        regions=(region,),
        convention=LameConvention.CONSISTENT,
        observations=(setup,),
        fit=fit,
        sensor=sensor,
        rigid_offset=prior,
    )


def with_start(scene: Scene, modulus: float) -> Scene:
    """Return the scene with another start of Young's modulus [Pa]."""
    (region,) = scene.regions
    start = replace(region.youngs_modulus, start=modulus)
    return replace(scene, regions=(replace(region, youngs_modulus=start),))


def _far_start(modulus: float, random: np.random.Generator) -> float:
    """Return a modulus a decade off, up or down, within the bounds."""
    starts = [modulus * _OFF, modulus / _OFF]
    if random.random() < 0.5:
        starts.reverse()
    return next(start for start in starts if BOUNDS[0] < start < BOUNDS[1])


def _within(largest: float, random: np.random.Generator) -> FloatArray:
    """Draw a vector of any direction and of any size up to the largest."""
    vector = random.standard_normal(3)
    return vector * (largest * random.random() / np.linalg.norm(vector))
