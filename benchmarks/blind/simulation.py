# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where the nodes of a body come to rest, faults included."""

from dataclasses import dataclass, replace

import numpy as np

from benchmarks.blind.body import Body, spread
from benchmarks.blind.equilibrium import find_equilibrium, Load, Potential, PotentialLaw
from benchmarks.blind.faults import Faults
from benchmarks.blind.hexahedra import CORNERS, HexMesh, integrate, mesh_hexahedra, Quadrature
from benchmarks.blind.material import constants
from benchmarks.blind.rotations import about, applied, rotation
from benchmarks.blind.setups import GRAVITY, Observation, Setup
from benchmarks.blind.shapes import bend, FloatArray

_MASS_REACH = 0.06  # Half the share of the free length over which an added mass is spread.
_CONTACT_STIFFNESS = 5.0e8  # [Pa/m]: a soft body sinks in by some micrometres.
_TURN_TOLERANCE = 1e-6  # Of the compliant clamp's turn [rad].


@dataclass(frozen=True)
class Specimen:
    """A body with the faults that go with it into every pose.

    Attributes:
        mesh: the nominal body.
        shares: of the free length at which its nodes lie, shape (N,).
        body: with the true material and the true shape without stress.
        added: further mass of the nodes [kg], shape (N,).
        tip_masses: mass of the nodes that belongs to the half at the tip [kg], shape (N,).
        areas: surface that belongs to each node [m^2], shape (N,).
        center: middle of the held section [m], shape (3,).
    """

    mesh: HexMesh
    shares: FloatArray
    body: Body
    added: FloatArray
    tip_masses: FloatArray
    areas: FloatArray
    center: FloatArray


def make_specimen(setup: Setup, faults: Faults, refinement: float = 1.0) -> Specimen:
    """Build the true body."""
    shape = replace(setup.shape, waist=setup.shape.waist - faults.bulge)
    mesh = mesh_hexahedra(shape, refinement)
    shares = shape.arc_share(mesh.lattice)
    stress_free = bend(mesh.nodes, shape.clamp, np.array([0.0, *faults.rest_curvature]))
    quadrature = integrate(stress_free, mesh.cells)
    at_points = mesh.lattice[mesh.cells].swapaxes(1, 2) @ quadrature.values.T
    share = shares[mesh.cells] @ quadrature.values.T
    modulus = setup.youngs_modulus * np.exp(_log_modulus(setup, faults, share, at_points))
    numbers = constants(modulus, setup.poissons_ratio, faults.yeoh_ratio)
    count = len(mesh.nodes)
    masses = setup.density * quadrature.volumes
    body = Body(
        cells=mesh.cells,
        quadrature=_swollen(quadrature, share, faults.swelling),
        numbers=numbers,
        masses=spread(masses, quadrature, mesh.cells, count),
        held=mesh.held,
    )
    return Specimen(
        mesh=mesh,
        shares=shares,
        body=body,
        added=_added_mass(faults, share, quadrature, mesh),
        tip_masses=spread(masses * (share > 0.5), quadrature, mesh.cells, count),
        areas=_node_areas(mesh),
        center=np.array([0.5 * shape.clamp, 0.0, 0.0]),
    )


def _log_modulus(
    setup: Setup, faults: Faults, share: FloatArray, points: FloatArray
) -> FloatArray:
    """Return the change of log E at the Gauss points, shape (C, 8)."""
    if faults.contrast_mode == 'split':
        change = faults.contrast * np.where(share > 0.5, 0.5, -0.5)
    else:
        change = faults.contrast * (share - 0.5)
    height = points[:, 2] / (0.5 * setup.shape.section[1])
    return change + faults.soft_skin * (height > 0.5)


def _swollen(quadrature: Quadrature, share: FloatArray, swelling: float) -> Quadrature:
    """Grow the shape without stress in the half at the tip."""
    growth = 1.0 + 0.01 * swelling * (share > 0.5)
    return replace(
        quadrature,
        gradients=quadrature.gradients / growth[..., None, None],
        volumes=quadrature.volumes * growth**3,
    )


def _added_mass(
    faults: Faults, share: FloatArray, quadrature: Quadrature, mesh: HexMesh
) -> FloatArray:
    nearness = np.maximum(1.0 - np.abs(share - faults.added_mass_at) / _MASS_REACH, 0.0)
    weights = nearness * (share > 0.0) * quadrature.volumes
    masses = 1e-3 * faults.added_mass * weights / max(float(weights.sum()), 1e-30)
    return spread(masses, quadrature, mesh.cells, len(mesh.nodes))


def _node_areas(mesh: HexMesh) -> FloatArray:
    """Share each surface face's area among its eight nodes, alike: corner weights stay > 0."""
    areas = np.zeros(len(mesh.nodes))
    for number, axis, side in mesh.faces:
        nodes = mesh.cells[number, CORNERS[:, axis] == side]
        points = mesh.nodes[nodes]
        flat = points - points.mean(axis=0)
        spans = np.linalg.svd(flat, compute_uv=False)[:2]
        # The eight points of a rectangle a x b: singular values a sqrt(3/2), b sqrt(3/2).
        areas[nodes] += spans.prod() / 1.5 / 8.0
    return areas


def settle(
    specimen: Specimen, setup: Setup, observation: Observation, faults: Faults
) -> FloatArray:
    """Return node positions in one pose, object frame [m], shape (N, 3)."""
    object_from_world = observation.world_from_object[:3, :3].T
    tilt = rotation(np.deg2rad([faults.gravity_tilt[0], 0.0, faults.gravity_tilt[1]]))
    gravity = object_from_world @ tilt @ np.array([0.0, -GRAVITY, 0.0])
    wind = object_from_world @ np.array([0.0, 0.0, faults.wind * GRAVITY])
    masses = specimen.body.masses + specimen.added
    forces = masses[:, None] * gravity + specimen.tip_masses[:, None] * wind
    load = Load(forces, _contact(specimen, observation, faults))
    nominal = about(
        rotation(np.deg2rad(faults.clamp_turn)),
        specimen.center,
        1e-3 * np.array(faults.clamp_shift),
    )
    return _settle_clamped(specimen, load, nominal, faults.clamp_compliance)


def _settle_clamped(
    specimen: Specimen, load: Load, clamp: FloatArray, compliance: float
) -> FloatArray:
    """Find the equilibrium; a compliant clamp turns until its spring bears the moment."""
    nodes = specimen.mesh.nodes
    positions = find_equilibrium(specimen.body, load, applied(clamp, nodes))
    if compliance == 0.0:
        return positions
    center = applied(clamp, specimen.center)
    turn = np.zeros(3)
    for _ in range(60):
        moment = _clamp_moment(specimen, load, positions, center)
        wanted = compliance * moment
        # Half a step: the moment itself falls as the clamp gives way.
        change = 0.7 * (wanted - turn)
        if np.linalg.norm(change) < _TURN_TOLERANCE:
            return positions
        old, turn = rotation(turn), turn + change
        # The whole body turns along: a start with almost no new strain.
        motion = about(rotation(turn) @ old.T, center, np.zeros(3))
        start = applied(motion, positions)
        held = specimen.body.held
        start[held] = applied(
            about(rotation(turn), center, np.zeros(3)), applied(clamp, nodes[held])
        )
        positions = find_equilibrium(specimen.body, load, start)
    raise RuntimeError(f'the compliant clamp found no rest at {compliance:g} rad/(N m)')


def _clamp_moment(
    specimen: Specimen, load: Load, positions: FloatArray, center: FloatArray
) -> FloatArray:
    """Return the moment that the body exerts on its clamp about a point [N m]."""
    pull = load.forces - specimen.body.evaluate(positions, with_stiffness=False).gradient
    held = specimen.body.held
    moment: FloatArray = np.cross(positions[held] - center, pull[held]).sum(axis=0)
    return moment


def _contact(
    specimen: Specimen, observation: Observation, faults: Faults
) -> tuple[PotentialLaw, ...]:
    """Return the penalty of a half-space, in the object frame."""
    if faults.contact_height is None:
        return ()
    matrix = observation.world_from_object
    world_normal = np.array(faults.contact_normal)
    normal = matrix[:3, :3].T @ world_normal
    height = faults.contact_height - float(world_normal @ matrix[:3, 3])
    stiffness = _CONTACT_STIFFNESS * specimen.areas
    outer = np.outer(normal, normal)

    def penalty(positions: FloatArray) -> Potential:
        depth = np.maximum(height - positions @ normal, 0.0)
        push = stiffness * depth
        return Potential(
            energy=0.5 * float((push * depth).sum()),
            gradient=-push[:, None] * normal,
            diagonal=(stiffness * (depth > 0.0))[:, None, None] * outer,
        )

    return (penalty,)
