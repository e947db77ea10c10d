# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where the nodes of a body come to rest, faults included."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.blind.amplitudes import weight_moment
from benchmarks.blind.body import Body, spread
from benchmarks.blind.contact import contact_laws, friction, half_space
from benchmarks.blind.equilibrium import find_equilibrium, Load
from benchmarks.blind.faults import Faults
from benchmarks.blind.hexahedra import CORNERS, HexMesh, integrate, mesh_hexahedra, Quadrature
from benchmarks.blind.material import stiffened
from benchmarks.blind.pulls import pulls
from benchmarks.blind.rest_shape import stress_free_nodes
from benchmarks.blind.rotations import about, applied, rotation
from benchmarks.blind.setups import GRAVITY, Observation, Setup
from benchmarks.blind.shapes import FloatArray

_MASS_REACH = 0.06  # Half the share of the free length over which an added mass is spread.
_POINT_REACH = 0.025  # The same of a mass on one side, and of one around the surface.
_SMEAR_REACH = 0.5
_JAW = 0.15  # Share of the free length over which a soft root gives way.
_TURN_TOLERANCE = 1e-6  # Of the compliant clamp's turn [rad].
_RUB_TOLERANCE = 1e-6  # Of the way between two rounds of friction [m].
_TORN = 0.05  # Half the share of the free length of a torn piece.


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
        heights: of the Gauss points, -1 at the lower face and 1 at the upper one, shape (C, 8).
    """

    mesh: HexMesh
    shares: FloatArray
    body: Body
    added: FloatArray
    tip_masses: FloatArray
    areas: FloatArray
    center: FloatArray
    heights: FloatArray


def make_specimen(setup: Setup, faults: Faults, refinement: float = 1.0) -> Specimen:
    """Build the true body."""
    one, other = setup.shape.taper
    shape = replace(
        setup.shape,
        waist=setup.shape.waist - faults.bulge,
        taper=(one + faults.cone, other + faults.cone),
    )
    mesh = mesh_hexahedra(shape, refinement)
    shares = shape.arc_share(mesh.lattice)
    stress_free = stress_free_nodes(mesh.nodes, shape, faults)
    quadrature = integrate(stress_free, mesh.cells)
    at_points = mesh.lattice[mesh.cells].swapaxes(1, 2) @ quadrature.values.T
    share = shares[mesh.cells] @ quadrature.values.T
    modulus = setup.youngs_modulus * np.exp(_log_modulus(setup, faults, share, at_points))
    numbers = stiffened(
        setup.rubber.numbers(modulus, setup.poissons_ratio, faults.yeoh_ratio),
        faults.stiffening_form,
        faults.stiffening,
    )
    count = len(mesh.nodes)
    masses = setup.density * quadrature.volumes
    body = Body(
        cells=mesh.cells,
        quadrature=_swollen(quadrature, (share > 0.5).astype(float), faults.swelling),
        numbers=numbers,
        masses=spread(masses, quadrature, mesh.cells, count),
        held=mesh.held,
    )
    return Specimen(
        mesh=mesh,
        shares=shares,
        body=body,
        added=_added_mass(setup, faults, share, at_points, quadrature, mesh),
        tip_masses=spread(masses * (share > 0.5), quadrature, mesh.cells, count),
        areas=_node_areas(mesh),
        center=np.array([0.5 * shape.clamp, 0.0, 0.0]),
        heights=at_points[:, 2] / (0.5 * setup.shape.section[1]),
    )


def _log_modulus(
    setup: Setup, faults: Faults, share: FloatArray, points: FloatArray
) -> FloatArray:
    """Return the change of log E at the Gauss points, shape (C, 8)."""
    outward = np.abs(points[:, 1:]) / (0.5 * np.array(setup.shape.section)[:, None])
    mode = {
        'split': np.where(share > 0.5, 0.5, -0.5),
        'linear': share - 0.5,
        'smooth': 0.5 * np.tanh((share - 0.4) / 0.15),
        'thirds': np.where(np.abs(share - 0.5) < 1.0 / 6.0, 0.5, -0.5),
        'skin': np.where(outward.max(axis=1) > 0.6, 0.5, -0.5),
        'cosine': -0.5 * np.cos(np.pi * np.clip(share, 0.0, 1.0)),
        'late': np.where(share > 0.7, 0.5, -0.5),
        'square': np.clip(share, 0.0, 1.0) ** 2 - 0.5,
        'spot': (np.abs(share - 0.3) < 0.1).astype(float),
    }[faults.contrast_mode]
    change = faults.contrast * mode
    if faults.clamp_form == 'jaw':
        # A root that is softer by as much as the clamp gives way.
        change = change - faults.clamp_compliance * (share < _JAW)
    height = points[:, 2] / (0.5 * setup.shape.section[1])
    change = change + faults.soft_skin * (height > 0.5)
    if faults.torn:
        change = change - 3.0 * _torn(faults, share, height)
    return change


def _torn(faults: Faults, share: FloatArray, height: FloatArray) -> FloatArray:
    """Return which Gauss points lie in a torn piece: the nearest, where none lies in it."""
    away = np.abs(share - faults.torn_at)
    is_there = away < max(_TORN, 1.01 * float(away.min()))
    above = height > min(1.0 - 2.0 * faults.torn, 0.99 * float(height.max()))
    return np.asarray((is_there & above).astype(float))


def _heated(specimen: Specimen, growth: float) -> Specimen:
    """Grow what has no stress by a percentage at the upper face, and not at the lower one."""
    upper = np.clip(0.5 * (1.0 + specimen.heights), 0.0, 1.0)
    quadrature = _swollen(specimen.body.quadrature, upper, growth)
    return replace(specimen, body=replace(specimen.body, quadrature=quadrature))


def _swollen(quadrature: Quadrature, where: FloatArray, swelling: float) -> Quadrature:
    """Grow the shape without stress by a percentage, times a share at each Gauss point."""
    growth = 1.0 + 0.01 * swelling * where
    return replace(
        quadrature,
        gradients=quadrature.gradients / growth[..., None, None],
        volumes=quadrature.volumes * growth**3,
    )


def _added_mass(
    setup: Setup,
    faults: Faults,
    share: FloatArray,
    points: FloatArray,
    quadrature: Quadrature,
    mesh: HexMesh,
) -> FloatArray:
    across = points[:, 1:] / (0.5 * np.array(setup.shape.section)[:, None])
    reach, where = {
        'hat': (_MASS_REACH, 1.0),
        'ring': (_POINT_REACH, np.abs(across).max(axis=1) > 0.5),
        'smear': (_SMEAR_REACH, 1.0),
        'point': (_POINT_REACH, across[:, 0] > 0.5),
        'two': (_POINT_REACH, np.abs(across).max(axis=1) > 0.5),
        'coat': (_POINT_REACH, 1.0),
        'opposite': (_POINT_REACH, np.abs(across[:, 0]) > 0.5),
    }[faults.mass_form]
    # At least the elements around the place, however long they are.
    away = np.abs(share - faults.added_mass_at)
    if faults.mass_form == 'opposite':
        inner = np.abs(share - 0.5 * faults.added_mass_at)
        away = np.where(across[:, 0] > 0.0, away, inner)
    if faults.mass_form == 'two':
        away = np.minimum(away, np.abs(share - 0.5 * faults.added_mass_at))
    if faults.mass_form == 'coat':
        away = np.where(share > faults.added_mass_at, 0.0, away)
    nearness = np.maximum(1.0 - away / max(reach, 1.01 * float(away.min())), 0.0)
    weights = nearness * where * (share > 0.0) * quadrature.volumes
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
    if faults.heat:
        share = faults.heat_shares[setup.pose_number(observation)]
        specimen = _heated(specimen, share * faults.heat)
    object_from_world = observation.world_from_object[:3, :3].T
    gravity = _gravity(setup, observation, faults)
    wind = object_from_world @ np.array([0.0, 0.0, faults.wind * GRAVITY])
    masses = specimen.body.masses + specimen.added
    forces = masses[:, None] * gravity + specimen.tip_masses[:, None] * wind
    if faults.tilt_form == 'growing':
        side = object_from_world @ _side(faults)
        forces = forces + (masses * np.maximum(specimen.shares, 0.0))[:, None] * side
    if faults.tilt_form == 'outer_push':
        side = object_from_world @ _side(faults)
        forces = forces + 2.0 * (masses * (specimen.shares > 0.6))[:, None] * side
    below = contact_laws(specimen.areas, specimen.shares, observation, faults)
    load = Load(forces, (*below, *pulls(masses, specimen.shares, observation, faults)))
    nominal = _clamp(specimen, setup, observation, faults)
    give = faults.clamp_compliance
    if faults.contact_height is not None and faults.contact_form == 'friction':
        return _settle_rubbing(specimen, load, nominal, *half_space(observation, faults))
    if faults.clamp_form == 'shear':
        return _settle_sliding(specimen, load, nominal, give)
    axes = {
        'uneven': np.diag([0.0, 1.0, 0.0]),
        'jaw': np.zeros((3, 3)),
        'about a corner': np.diag([1.0, 1.5, 0.5]),
    }
    compliance = give * axes.get(faults.clamp_form, np.eye(3))
    power = {'hardening': 0.5, 'softening': -0.4}.get(faults.clamp_form)
    if faults.clamp_form == 'about a corner':
        width, height = setup.shape.section
        corner = specimen.center + 0.5 * np.array([0.0, width, -height])
        specimen = replace(specimen, center=corner)
    if power is None:
        return _settle_clamped(specimen, load, nominal, compliance)
    _, usual = weight_moment(setup)
    return _settle_clamped(
        specimen, load, nominal, compliance, lambda moment: max(moment / usual, 1e-6) ** power
    )


def _clamp(
    specimen: Specimen, setup: Setup, observation: Observation, faults: Faults
) -> FloatArray:
    """Return where the held section is to be in a pose, shape (4, 4)."""
    slipped = _slipped(setup, observation, faults)
    more = np.zeros(6)
    if faults.clamp_scatter:
        more = np.array(faults.clamp_scatter[setup.pose_number(observation)])
    return about(
        rotation(slipped * np.deg2rad(faults.clamp_turn) + np.deg2rad(more[3:])),
        specimen.center,
        slipped * 1e-3 * np.array(faults.clamp_shift) + 1e-3 * more[:3],
    )


def _gravity(setup: Setup, observation: Observation, faults: Faults) -> FloatArray:
    """Return what pulls on every part, by its mass, object frame [m/s^2], shape (3,)."""
    object_from_world = observation.world_from_object[:3, :3].T
    down = np.array([0.0, -GRAVITY, 0.0])
    if faults.tilt_form == 'changing':
        middle = 0.5 * (len(setup.observations) - 1)
        share = 1.0 + 0.3 * (setup.pose_number(observation) - middle)
        return np.asarray(object_from_world @ _tilt(faults, share) @ down)
    if faults.tilt_form == 'tilt':
        return np.asarray(object_from_world @ _tilt(faults) @ down)
    side = _side(faults)
    if faults.tilt_form in ('growing', 'outer_push'):
        return np.asarray(object_from_world @ down)
    if faults.tilt_form == 'side_force':
        return np.asarray(object_from_world @ (down + side))
    # What it is in the first pose it stays, as seen from the rig.
    first = setup.observations[0].world_from_object[:3, :3].T
    return np.asarray(object_from_world @ down + first @ side)


def _tilt(faults: Faults, share: float = 1.0) -> FloatArray:
    return rotation(share * np.deg2rad([faults.gravity_tilt[0], 0.0, faults.gravity_tilt[1]]))


def _side(faults: Faults) -> FloatArray:
    """Return what a tilt pulls to the side, world frame [m/s^2], shape (3,)."""
    down = np.array([0.0, -GRAVITY, 0.0])
    side: FloatArray = _tilt(faults) @ down - down
    side[1] = 0.0
    return side


def _slipped(setup: Setup, observation: Observation, faults: Faults) -> float:
    """Return which share of the clamp's shift is there in a pose."""
    reached = setup.reached(observation)
    if faults.clamp_late:
        return float(reached > 0.5)
    return reached if faults.clamp_steps else 1.0


def _settle_rubbing(
    specimen: Specimen, load: Load, clamp: FloatArray, normal: FloatArray, height: float
) -> FloatArray:
    """Find the equilibrium on a plane with friction: pushes known, then those that follow.

    Nodes come to the plane from where they hang without it. With known pushes friction has an
    energy (Tresca's law); repeated, its solution is that of Coulomb's (Panagiotopoulos 1975).
    """
    hanging = replace(load, potentials=())
    free = find_equilibrium(specimen.body, hanging, applied(clamp, specimen.mesh.nodes))
    if (free @ normal).min() > height:
        return free
    positions = find_equilibrium(specimen.body, load, free)
    for _ in range(60):
        pushes = np.linalg.norm(load.potentials[0](positions).gradient, axis=1)
        rubbed = replace(load, potentials=(*load.potentials, friction(normal, pushes, free)))
        before, positions = positions, find_equilibrium(specimen.body, rubbed, positions)
        if np.abs(positions - before).max() < _RUB_TOLERANCE:
            return positions
    raise RuntimeError('friction on the plane found no rest')


def _settle_sliding(
    specimen: Specimen, load: Load, clamp: FloatArray, compliance: float
) -> FloatArray:
    """Find the equilibrium where the held section gives way along the force on it."""
    # Its weight is all that a body asks of its clamp, contact aside: one step is exact then.
    held = specimen.body.held
    positions = find_equilibrium(specimen.body, load, applied(clamp, specimen.mesh.nodes))
    gradient = specimen.body.evaluate(positions, with_stiffness=False).gradient
    force = (load.forces - gradient)[held].sum(axis=0)
    return positions + compliance * force


def _settle_clamped(
    specimen: Specimen,
    load: Load,
    clamp: FloatArray,
    compliance: FloatArray,
    hardening: Callable[[float], float] = lambda moment: 1.0,
) -> FloatArray:
    """Find the equilibrium; a compliant clamp turns until its spring bears the moment.

    Args:
        specimen: the body.
        load: on it.
        clamp: where the held section is to be, shape (4, 4).
        compliance: turn by moment about the object's axes [rad/(N m)], shape (3, 3).
        hardening: by how much less it is at a moment [N m].
    """
    nodes = specimen.mesh.nodes
    positions = find_equilibrium(specimen.body, load, applied(clamp, nodes))
    if not compliance.any():
        return positions
    center = applied(clamp, specimen.center)
    turn = np.zeros(3)
    for _ in range(60):
        moment = _clamp_moment(specimen, load, positions, center)
        wanted = compliance @ moment / hardening(float(np.linalg.norm(moment)))
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
    raise RuntimeError(f'the compliant clamp found no rest at {compliance.max():g} rad/(N m)')


def _clamp_moment(
    specimen: Specimen, load: Load, positions: FloatArray, center: FloatArray
) -> FloatArray:
    """Return the moment that the body exerts on its clamp about a point [N m]."""
    pull = load.forces - specimen.body.evaluate(positions, with_stiffness=False).gradient
    held = specimen.body.held
    moment: FloatArray = np.cross(positions[held] - center, pull[held]).sum(axis=0)
    return moment
