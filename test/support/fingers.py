# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A notched finger with cables through its notches, in front of a tilted camera."""

from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth.tracer import DepthTracer
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.material import LameConvention
from diffcal_ros.rigid_transform import apply, looking_at
from diffcal_ros.scene.model import Cable, HeldPart, ObservationSetup, Quantity, Region, Scene
from diffcal_ros.synthetic.posed_body import pose_body
from diffcal_ros.tet_mesh import TetMesh
import numpy as np

from support.beams import beam_mesh, held_end
from support.scenes import noisy

SIZE = (0.14, 0.03, 0.03)
CAMERA = PinholeCamera(320, 240, 330.0, 342.0, 152.5, 131.25)
DEPTH_FROM_WORLD = looking_at(
    np.array([0.07, 0.012, 0.02]), np.array([0.05, -0.25, 0.09]), np.array([0.0, 0.1, 1.0])
)
GRAVITY = np.array([0.3, 0.0, -9.8])
_NOTCHES = ((0.03, 0.05), (0.07, 0.09), (0.11, 0.13))
_STIFFNESS = 5000.0


def finger_mesh(counts: tuple[int, int, int] = (14, 2, 2)) -> TetMesh:
    """Cut three notches into the upper half of a beam along x; counts must meet them."""
    beam = beam_mesh(counts, SIZE)
    x, _, z = beam.centroids.T
    is_air = np.zeros(beam.tet_count, dtype=bool)
    for low, high in _NOTCHES:
        is_air |= (x > low) & (x < high) & (z > 0.5 * SIZE[2])
    used, tets = np.unique(beam.tets[~is_air], return_inverse=True)
    return TetMesh(beam.rest_positions[used], tets.reshape(-1, 4).astype(np.int32))


def via_points(across: float = 0.015, height: float = 0.023) -> np.ndarray:
    """Points on both sides of every notch, and at the ends."""
    along = [0.002, 0.029, 0.051, 0.069, 0.091, 0.109, 0.131, 0.137]
    return np.array([[x, across, height] for x in along])


def cable(name: str, pull: float, points: np.ndarray) -> Cable:
    """A cable that is shortened by so much [m]."""
    length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    rest = Quantity(length - pull, 0.2 * length, 1.5 * length)
    return Cable(name, points, rest, Quantity(_STIFFNESS, 1.0, 1e7))


def finger_scene(
    *cables: Cable,
    counts: tuple[int, int, int] = (14, 2, 2),
    fit: tuple[str, ...] = ('rest_length',),
    element: Element = Element.QUADRATIC,
) -> Scene:
    """Make the scene in memory."""
    mesh = finger_mesh(counts)
    region = Region(
        name='body',
        tets=np.arange(mesh.tet_count, dtype=np.int32),
        youngs_modulus=Quantity(3e5, 1e3, 1e7),
        poissons_ratio=Quantity(0.45, 0.0, 0.499),
        density=Quantity(1080.0, 100.0, 1e4),
    )
    setup = ObservationSetup(
        name='pulled',
        world_from_object=np.eye(4),
        gravity=GRAVITY,
        held=(HeldPart('clamp', held_end(mesh, 0.011)),),
    )
    return Scene(
        name='finger',
        mesh=mesh,
        element=element,
        regions=(region,),
        convention=LameConvention.CONSISTENT,
        observations=(setup,),
        fit=fit,
        cables=tuple(cables),
    )


def filmed(*cables: Cable, seed: int = 4) -> Observation:
    """Depth of the finger from a finer mesh, with noise."""
    scene = finger_scene(*cables, counts=(28, 3, 4))
    body = pose_body(scene, scene.observations[0])
    points = apply(DEPTH_FROM_WORLD, body.positions)
    depth = DepthTracer(body.triangles, len(points), CAMERA).trace(points).full_depth()
    seen = noisy(depth, np.random.default_rng(seed))
    return Observation('finger', 0, seen, CAMERA, DEPTH_FROM_WORLD)
