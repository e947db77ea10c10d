# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Scenes and observations in memory: a beam that hangs in front of a tilted camera."""

from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth.tracer import DepthTracer
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.material import LameConvention, Material
from diffcal_ros.rigid_transform import apply, rotation_matrix, transform
from diffcal_ros.scene.model import (
    HeldPart,
    ObservationSetup,
    PoseSetup,
    Quantity,
    Region,
    Scene,
)
from diffcal_ros.scene.posing import world_positions
from diffcal_ros.tet_mesh import TetMesh
import numpy as np

from support.beams import beam_mesh, held_end

CAMERA = PinholeCamera(320, 240, 350.0, 365.0, 150.5, 128.25)
SIZE = (0.12, 0.024, 0.018)
MODULUS = 60e3
NU = 0.45
DENSITY = 1080.0
GRAVITY = np.array([0.0, -9.8, 0.0])
WORLD_FROM_OBJECT = transform(rotation_matrix(np.array([0.0, 0.1, 0.05])), np.array([0.01, 0, 0]))
EXACT_POSE = PoseSetup(position_std=0.0, rotation_std=0.0)
# The camera looks at the middle of the beam, tilted about every axis.
DEPTH_FROM_WORLD = transform(
    rotation_matrix(np.array([np.pi - 0.25, 0.2, 0.15])), np.array([-0.075, -0.02, 0.26])
)


def quantity(start: float, lower: float, upper: float) -> Quantity:
    """A number with bounds and no prior."""
    return Quantity(start, lower, upper)


def beam_scene(
    counts: tuple[int, int, int] = (8, 2, 2),
    *,
    modulus: float = MODULUS,
    element: Element = Element.QUADRATIC,
    fit: tuple[str, ...] = ('youngs_modulus',),
    region_count: int = 1,
    gravity: np.ndarray = GRAVITY,
) -> Scene:
    """Make the scene; several regions divide the beam along its length."""
    mesh = beam_mesh(counts, SIZE)
    place = np.minimum(
        (mesh.centroids[:, 0] / SIZE[0] * region_count).astype(int), region_count - 1
    )
    regions = tuple(
        Region(
            name=f'part_{index}',
            tets=np.flatnonzero(place == index).astype(np.int32),
            youngs_modulus=quantity(modulus, 1e3, 1e7),
            poissons_ratio=quantity(NU, 0.0, 0.499),
            density=quantity(DENSITY, 100.0, 1e4),
        )
        for index in range(region_count)
    )
    setup = ObservationSetup(
        name='hanging',
        world_from_object=WORLD_FROM_OBJECT,
        gravity=gravity,
        held=(HeldPart('clamp', held_end(mesh)),),
        pose=EXACT_POSE,
    )
    return Scene(
        name='beam',
        mesh=mesh,
        element=element,
        regions=regions,
        convention=LameConvention.CONSISTENT,
        observations=(setup,),
        fit=fit,
    )


# What was traced before: many tests look at the same beam.
_TRUE_DEPTHS: dict[tuple, np.ndarray] = {}


def true_depth(
    modulus: float | np.ndarray = MODULUS,
    *,
    counts: tuple[int, int, int] = (10, 3, 3),
    camera: PinholeCamera = CAMERA,
    depth_from_world: np.ndarray = DEPTH_FROM_WORLD,
    gravity: np.ndarray = GRAVITY,
) -> np.ndarray:
    """Depth [m] of the beam from another mesh than the scene's; NaN beside it."""
    arrays = (np.asarray(modulus), depth_from_world, gravity)
    key = (counts, camera, *(array.tobytes() for array in arrays))
    if key not in _TRUE_DEPTHS:
        _TRUE_DEPTHS[key] = _traced(modulus, counts, camera, depth_from_world, gravity)
    return _TRUE_DEPTHS[key].copy()


def _traced(
    modulus: float | np.ndarray,
    counts: tuple[int, int, int],
    camera: PinholeCamera,
    depth_from_world: np.ndarray,
    gravity: np.ndarray,
) -> np.ndarray:
    mesh = beam_mesh(counts, SIZE)
    rest = world_positions(mesh, beam_scene().observations[0])
    body = StaticBody(TetMesh(rest, mesh.tets), Element.QUADRATIC, held_end(mesh))
    ones = np.ones(mesh.tet_count)
    state = body.solve_equilibrium(Material(modulus * ones, NU * ones, DENSITY * ones), gravity)
    points = apply(depth_from_world, state.positions)
    tracer = DepthTracer(body.discretisation.surface_triangles, len(points), camera)
    return tracer.trace(points).full_depth()


def noisy(depth: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Add an L515's noise (0.14 mm) and steps (0.25 mm)."""
    shaken = depth + random.normal(scale=0.00014, size=depth.shape)
    return (np.round(shaken / 0.00025) * 0.00025).astype(np.float32)


def observation(
    depth: np.ndarray, *, camera: PinholeCamera = CAMERA, pose: np.ndarray = DEPTH_FROM_WORLD
) -> Observation:
    """Wrap a depth image."""
    return Observation('test', 0, depth.astype(np.float32), camera, pose)
