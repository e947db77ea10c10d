# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The true body at rest: its material, how it is held, and where its surface comes to lie."""

from dataclasses import dataclass

from diffcal_ros.rigid_transform import apply, rotation_matrix, transform
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_solve_banded, cholesky_banded

from benchmarks.blind.body import Body, make_body
from benchmarks.blind.equilibrium import find_equilibrium, Load, NoEquilibriumError
from benchmarks.blind.hexahedra import HexMesh, shape_functions
from benchmarks.blind.material import constants
from benchmarks.blind.surface import grid_triangles
from benchmarks.zoo.meshes import true_mesh
from benchmarks.zoo.solids import FloatArray, Solid

IntArray = NDArray[np.int32]

DENSITY = 1080.0  # [kg/m^3]
GRAVITY = np.array([0.0, -9.81, 0.0])  # World frame, y up [m/s^2].
BOUNDS = (10e3, 10e6)  # Of the fit [Pa].
_MODULI = (15e3, 3e6)  # Truths [Pa].
_SAG = (0.05, 0.50)  # Of the free length.
_LINEAR_SAG = (0.055, 0.75)  # What stiffness at rest foretells where that is likely.
_MOST_DRAWS = 60
_STEPS = (1.0, 0.5, 0.25, 0.12)  # First share of the load where all of it at once is too much.
_CUTS = 2  # Of a face along each side.


@dataclass(frozen=True)
class Truth:
    """A body as it is.

    Attributes:
        solid: its shape.
        world_from_object: its placement, shape (4, 4).
        youngs_modulus: [Pa].
        poissons_ratio: dimensionless.
        points: of its surface at rest under gravity, world frame [m], shape (N, 3).
        triangles: outward, shape (F, 3).
        sag: largest displacement over the free length.
    """

    solid: Solid
    world_from_object: FloatArray
    youngs_modulus: float
    poissons_ratio: float
    points: FloatArray
    triangles: IntArray
    sag: float

    @property
    def held_middle(self) -> FloatArray:
        """Middle of the held section in the world frame [m], shape (3,)."""
        return apply(self.world_from_object, np.array([0.5 * self.solid.clamp, 0.0, 0.0]))


def draw_truth(solid: Solid, random: np.random.Generator) -> Truth:
    """Draw size, direction and material until the body sags visibly.

    Raises:
        RuntimeError: when no draw sags as wanted.
    """
    for _ in range(_MOST_DRAWS):
        own = solid.scaled(random.uniform(0.85, 1.15))
        placement = _draw_placement(random)
        poissons_ratio = round(float(random.uniform(0.45, 0.49)), 4)
        # Small sags go with one over the modulus.
        compliance = _linear_sag(own, placement, poissons_ratio)
        low, high = (compliance / sag for sag in reversed(_LINEAR_SAG))
        low, high = max(low, _MODULI[0]), min(high, _MODULI[1])
        if low >= high:
            continue
        modulus = float(np.exp(random.uniform(np.log(low), np.log(high))))
        try:
            truth = bend(own, placement, modulus, poissons_ratio)
        except NoEquilibriumError:
            continue
        if _SAG[0] < truth.sag < _SAG[1]:
            return truth
    raise RuntimeError(f'no {solid.name} sags by {_SAG} of its length in {_MOST_DRAWS} draws')


def bend(
    solid: Solid, world_from_object: FloatArray, youngs_modulus: float, poissons_ratio: float
) -> Truth:
    """Let a body come to rest.

    Raises:
        NoEquilibriumError: when it finds none.
    """
    mesh = true_mesh(solid)
    body = elastic_body(mesh, youngs_modulus, poissons_ratio)
    positions = _settled(body, mesh, world_from_object[:3, :3].T @ GRAVITY)
    points, triangles = body_surface(mesh, positions)
    sag = np.linalg.norm(positions - mesh.nodes, axis=1).max() / solid.free_length
    return Truth(
        solid=solid,
        world_from_object=world_from_object,
        youngs_modulus=youngs_modulus,
        poissons_ratio=poissons_ratio,
        points=apply(world_from_object, points),
        triangles=triangles,
        sag=float(sag),
    )


def _settled(body: Body, mesh: HexMesh, gravity: FloatArray) -> FloatArray:
    """Apply the weight, in steps where Newton does not take it at once."""
    for first in _STEPS:
        positions = mesh.nodes
        try:
            for share in np.linspace(first, 1.0, round(1.0 / first)):
                load = Load(share * body.masses[:, None] * gravity)
                positions = find_equilibrium(body, load, positions)
            return positions
        except NoEquilibriumError:
            continue
    raise NoEquilibriumError('the body finds no rest, with its weight in steps either')


def _linear_sag(solid: Solid, world_from_object: FloatArray, poissons_ratio: float) -> float:
    """Return the sag that stiffness at rest foretells for a modulus of 1 Pa."""
    down = world_from_object[:3, :3].T @ GRAVITY
    _, moves = small_moves(true_mesh(solid), poissons_ratio, down[None])
    return float(np.linalg.norm(moves[0], axis=1).max() / solid.free_length)


def small_moves(
    mesh: HexMesh, poissons_ratio: float, accelerations: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return weights [N] and what stiffness at rest makes of them [m], for a modulus of 1 Pa.

    Args:
        mesh: of the body.
        poissons_ratio: dimensionless.
        accelerations: of the whole body [m/s^2], shape (k, 3).

    Returns:
        Shape (k, N, 3) each.
    """
    body = elastic_body(mesh, 1.0, poissons_ratio)
    blocks = body.evaluate(mesh.nodes).blocks
    assert blocks is not None
    factor = cholesky_banded(body.band.assemble(blocks), lower=True, overwrite_ab=True)
    loads = body.masses[:, None] * accelerations[:, None]
    flat, free = loads.reshape(len(loads), -1), body.band.numbers
    moves = np.zeros_like(flat)
    moves[:, free] = cho_solve_banded((factor, True), flat[:, free].T).T
    return loads, moves.reshape(loads.shape)


def elastic_body(mesh: HexMesh, youngs_modulus: float, poissons_ratio: float) -> Body:
    """Make a body of one material from a mesh."""
    numbers = constants(np.full((len(mesh.cells), 8), youngs_modulus), poissons_ratio)
    return make_body(mesh.nodes, mesh.cells, mesh.held, numbers, DENSITY)


def _draw_placement(random: np.random.Generator) -> FloatArray:
    """Draw how the body sticks out of its clamp: rolled at will, level or hanging down."""
    roll = rotation_matrix(np.array([random.uniform(0.0, 2.0 * np.pi), 0.0, 0.0]))
    rise = rotation_matrix(np.array([0.0, 0.0, np.deg2rad(random.uniform(-50.0, 20.0))]))
    yaw = rotation_matrix(np.array([0.0, random.uniform(0.0, 2.0 * np.pi), 0.0]))
    return transform(yaw @ rise @ roll, random.uniform(-0.05, 0.05, size=3))


def body_surface(mesh: HexMesh, positions: FloatArray) -> tuple[FloatArray, IntArray]:
    """Cut the curved faces into triangles that share their corners.

    Returns:
        Points [m], shape (N, 3), and outward triangles, shape (F, 3).
    """
    ticks = np.linspace(-1.0, 1.0, _CUTS + 1)
    square = np.stack(np.meshgrid(ticks, ticks, indexing='ij'), axis=-1).reshape(-1, 2)
    rest, bent, triangles, count = [], [], [], 0
    for axis in range(3):
        for side in (-1, 1):
            chosen = (mesh.faces[:, 1] == axis) & (mesh.faces[:, 2] == side)
            values = shape_functions(np.insert(square, axis, float(side), axis=1))
            nodes = mesh.cells[mesh.faces[chosen, 0]]
            # Rows and columns of the square turn against axes 0 and 2, and with axis 1.
            is_turned = (side > 0) != (axis == 1)
            pattern = grid_triangles(_CUTS)[:, ::-1] if is_turned else grid_triangles(_CUTS)
            starts = count + len(square) * np.arange(len(nodes))
            triangles.append((starts[:, None, None] + pattern).reshape(-1, 3))
            rest.append((values @ mesh.nodes[nodes]).reshape(-1, 3))
            bent.append((values @ positions[nodes]).reshape(-1, 3))
            count += len(square) * len(nodes)
    places = np.round(np.concatenate(rest) / 1e-8).astype(np.int64)
    _, first, merged = np.unique(places, axis=0, return_index=True, return_inverse=True)
    faces = merged.ravel()[np.concatenate(triangles)].astype(np.int32)
    return np.concatenate(bent)[first], faces
