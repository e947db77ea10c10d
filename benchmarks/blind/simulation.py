# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where the nodes of a body come to rest, faults included."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from benchmarks.blind.body import Body, IntArray, spread
from benchmarks.blind.clamps import (
    crept,
    flowed,
    lagged,
    settle_clamped,
    settle_in_foam,
    settle_on_flexure,
    settle_sliding,
    wanted_turn,
)
from benchmarks.blind.cloth import cloth_masses
from benchmarks.blind.contact import friction, half_space
from benchmarks.blind.cradle import cradled_masses
from benchmarks.blind.equilibrium import find_equilibrium, Load
from benchmarks.blind.faults import Faults
from benchmarks.blind.filling import filling_masses
from benchmarks.blind.flap import hinge_moment
from benchmarks.blind.flexure import (
    angle_compliance,
    bobbin_compliance,
    coil_compliance,
    flexure_compliance,
    gantry_compliance,
    gooseneck_compliance,
    hairpin_compliance,
    hexapod_compliance,
    post_compliance,
    stand_compliance,
    strap_compliance,
    suction_compliance,
    tape_compliance,
    wrist_compliance,
)
from benchmarks.blind.hexahedra import CORNERS, HexMesh, integrate, mesh_hexahedra, Quadrature
from benchmarks.blind.hourglass import hourglass_masses
from benchmarks.blind.hung import hung_masses
from benchmarks.blind.jaws import bowed, pinched
from benchmarks.blind.loads import load_in_pose, load_on_pan
from benchmarks.blind.loose import ring_masses
from benchmarks.blind.masses import added_mass
from benchmarks.blind.material import softened
from benchmarks.blind.moduli import cavity, log_modulus, SEAM_LAYERS
from benchmarks.blind.motor_heat import heated_on, HEATS
from benchmarks.blind.network import laid_along, on_upper_side, reinforced
from benchmarks.blind.ooze import oozed_masses
from benchmarks.blind.pan import settle_on_pan
from benchmarks.blind.rest_shape import stress_free_nodes, true_shape
from benchmarks.blind.rope import rope_give
from benchmarks.blind.rotations import about, applied, rotation
from benchmarks.blind.setups import Observation, Setup
from benchmarks.blind.seventh_outside import warmed
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.slider import slider_masses
from benchmarks.blind.slinky import slinky_masses
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.sponge import sponge_masses
from benchmarks.blind.springs import LININGS
from benchmarks.blind.wear import worn
from benchmarks.blind.wick import wick_masses

_GLUED_CELLS = 4  # Along what is held, where glue holds its lower face alone.
_RUB_TOLERANCE = 1e-6  # Of the way between two rounds of friction [m].
# Masses that are not the same, or not at the same place, in every pose.
_BY_POSE = {
    'loose': ring_masses,
    'drying': cloth_masses,
    'sponge': sponge_masses,
    'oozing': oozed_masses,
    'wicking': wick_masses,
    'hung on': hung_masses,
    'cradled': cradled_masses,
    'filling': filling_masses,
    'sliding': slider_masses,
    'slinky': slinky_masses,
    'hourglass': hourglass_masses,
}
# How a clamp turns that stays where the pose before left it: rules by that turn and the faults.
_LASTING: dict[str, Callable[[FloatArray, Faults], Callable[[FloatArray], FloatArray]]] = {
    'rubbing': lambda turn, faults: lagged(turn, faults.clamp_compliance, faults.clamp_rub),
    'creeping': lambda turn, faults: crept(turn, faults.clamp_compliance, faults.clamp_crept),
    'waxed': lambda turn, faults: flowed(turn, faults.clamp_compliance),
}
# How what a clamp stands on gives way to force and moment.
_BEAMS: dict[str, Callable[[Faults], FloatArray]] = {
    'flexure': lambda faults: flexure_compliance(faults.clamp_compliance, faults.clamp_length),
    'post': lambda faults: post_compliance(faults.clamp_compliance, faults.clamp_length),
    'angle iron': lambda faults: angle_compliance(
        faults.clamp_compliance, faults.clamp_length, faults.clamp_slant
    ),
    'wrist': lambda faults: wrist_compliance(faults.clamp_compliance, faults.clamp_length),
    'taped': lambda faults: tape_compliance(faults.clamp_compliance, faults.clamp_length),
    'gantry': lambda faults: gantry_compliance(faults.clamp_compliance, faults.clamp_length),
    'stand': lambda faults: stand_compliance(faults.clamp_compliance, faults.clamp_length),
    'suction': lambda faults: suction_compliance(faults.clamp_compliance, faults.clamp_length),
    'bobbins': lambda faults: bobbin_compliance(faults.clamp_compliance, faults.clamp_length),
    'gooseneck': lambda faults: gooseneck_compliance(faults.clamp_compliance, faults.clamp_length),
    'coil spring': lambda faults: coil_compliance(faults.clamp_compliance, faults.clamp_length),
    'hairpin': lambda faults: hairpin_compliance(faults.clamp_compliance, faults.clamp_length),
    'hexapod': lambda faults: hexapod_compliance(faults.clamp_compliance, faults.clamp_length),
    'twisted strap': lambda faults: strap_compliance(faults.clamp_compliance, faults.clamp_length),
}
# By how much that sinks on which a body lies [m]: rules by the force on it [N]; of a flap, how far
# it turns [rad], by the moment on it [N m].
_SINKING: dict[str, Callable[[Faults], Callable[[float], float]]] = {
    'pan': lambda faults: lambda force: faults.contact_give * force,
    'rope': rope_give,
    'flap': lambda faults: lambda moment: faults.contact_give * moment,
}

# A flap turns where a body's inner part may lie on it, which is stiff.
_SINK_PARTS = {'pan': 0.6, 'rope': 0.6, 'flap': 0.2}


def make_specimen(setup: Setup, faults: Faults, refinement: float = 1.0) -> Specimen:
    """Build the true body."""
    shape = true_shape(setup.shape, faults)
    cells = _GLUED_CELLS if faults.clamp_form == 'glued' else 1
    mesh = mesh_hexahedra(shape, refinement, cells, SEAM_LAYERS if faults.unglued else 1)
    shares = shape.arc_share(mesh.lattice)
    stress_free = stress_free_nodes(mesh.nodes, shape, faults)
    quadrature = integrate(stress_free, mesh.cells)
    at_points = mesh.lattice[mesh.cells].swapaxes(1, 2) @ quadrature.values.T
    share = shares[mesh.cells] @ quadrature.values.T
    modulus = setup.youngs_modulus * np.exp(log_modulus(setup, faults, share, at_points))
    plain = setup.rubber.numbers(modulus, setup.poissons_ratio, faults.yeoh_ratio)
    heights = at_points[:, 2] / (0.5 * setup.shape.section[1])
    outward = np.abs(at_points[:, 1:]) / (0.5 * np.array(setup.shape.section)[:, None])
    beside = laid_along(outward, faults)
    numbers = reinforced(plain, modulus, faults, outward.max(axis=1), beside, heights)
    numbers = on_upper_side(numbers, modulus, heights, faults)
    count = len(mesh.nodes)
    masses = setup.density * quadrature.volumes
    if faults.hollow:
        masses = masses * (1.0 - cavity(setup, faults, share, at_points))
    body = Body(
        cells=mesh.cells,
        quadrature=_swollen(quadrature, (share > 0.5).astype(float), faults.swelling),
        numbers=numbers,
        masses=spread(masses, quadrature, mesh.cells, count),
        held=_held(mesh, faults),
    )
    return Specimen(
        mesh=mesh,
        shares=shares,
        body=body,
        added=added_mass(setup, faults, share, at_points, quadrature, mesh),
        tip_masses=spread(masses * (share > 0.5), quadrature, mesh.cells, count),
        areas=_node_areas(mesh),
        center=np.array([0.5 * shape.clamp, 0.0, 0.0]),
        heights=heights,
    )


def _held(mesh: HexMesh, faults: Faults) -> IntArray:
    """Return the nodes that a clamp moves, shape (H,)."""
    if faults.clamp_form in LININGS:
        # What lies in foam moves like all else.
        return mesh.held[:0]
    if faults.clamp_form == 'glued':
        heights = mesh.lattice[:, 2]
        return mesh.held[heights[mesh.held] < heights.min() + 1e-9]
    return mesh.held


def _heated(specimen: Specimen, growth: float) -> Specimen:
    """Grow what has no stress by a percentage at the upper face, and not at the lower one."""
    upper = np.clip(0.5 * (1.0 + specimen.heights), 0.0, 1.0)
    quadrature = _swollen(specimen.body.quadrature, upper, growth)
    return replace(specimen, body=replace(specimen.body, quadrature=quadrature))


def _shrunk(specimen: Specimen, growth: float) -> Specimen:
    """Let all of a body grow by a percentage, and what it weighs with its volume."""
    body = specimen.body
    quadrature = _swollen(body.quadrature, np.ones(specimen.heights.shape), growth)
    masses = body.masses * (1.0 + 0.01 * growth) ** 3
    return replace(specimen, body=replace(body, quadrature=quadrature, masses=masses))


def _recovered(
    specimen: Specimen, setup: Setup, observation: Observation, faults: Faults
) -> Specimen:
    """Bend what has no stress by as much as is left of its curvature in a pose."""
    left, (y, z) = faults.curvature_shares[setup.pose_number(observation)], faults.rest_curvature
    milder, mesh = replace(faults, rest_curvature=(left * y, left * z)), specimen.mesh
    stress_free = stress_free_nodes(mesh.nodes, true_shape(setup.shape, faults), milder)
    quadrature = integrate(stress_free, mesh.cells)
    return replace(specimen, body=replace(specimen.body, quadrature=quadrature))


def _softened(specimen: Specimen, factor: float) -> Specimen:
    """Make all of a body softer by a factor."""
    numbers = softened(specimen.body.numbers, factor)
    return replace(specimen, body=replace(specimen.body, numbers=numbers))


def _worn(specimen: Specimen, setup: Setup, observation: Observation, faults: Faults) -> Specimen:
    """Make a body softer where the poses before one strained it."""
    fresh = replace(faults, worn=0.0)
    views = setup.observations[: setup.pose_number(observation)]
    rests = [partial(settle, setup=setup, observation=view, faults=fresh) for view in views]
    return worn(specimen, lambda body, number: rests[number](body), len(rests), faults.worn)


def _dragged(specimen: Specimen, faults: Faults) -> Specimen:
    """Shear the held section along x; all else starts from where that turns it."""
    mesh, (by_y, by_z) = specimen.mesh, faults.clamp_drag
    if not (by_y or by_z):
        return specimen
    mouth = 2.0 * specimen.center
    nodes = applied(about(rotation(np.array([0.0, by_z, -by_y])), mouth, np.zeros(3)), mesh.nodes)
    nodes[mesh.held] = mesh.nodes[mesh.held]
    nodes[mesh.held, 0] += mesh.nodes[mesh.held, 1:] @ np.array([by_y, by_z])
    return replace(specimen, mesh=replace(mesh, nodes=nodes))


def _swollen(quadrature: Quadrature, where: FloatArray, swelling: float) -> Quadrature:
    """Grow the shape without stress by a percentage, times a share at each Gauss point."""
    growth = 1.0 + 0.01 * swelling * where
    return replace(
        quadrature,
        gradients=quadrature.gradients / growth[..., None, None],
        volumes=quadrature.volumes * growth**3,
    )


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


def _in_pose(
    specimen: Specimen, setup: Setup, observation: Observation, faults: Faults
) -> Specimen:
    """Return a body as it is in one pose, where that is not the same in all."""
    if faults.heat:
        share = faults.heat_shares[setup.pose_number(observation)]
        specimen = _heated(specimen, share * faults.heat)
    if faults.shrinking:
        share = faults.shrinking_shares[setup.pose_number(observation)]
        specimen = _shrunk(specimen, -share * faults.shrinking)
    if faults.curvature_shares:
        specimen = _recovered(specimen, setup, observation, faults)
    if faults.warming:
        specimen = _softened(specimen, warmed(setup, observation, faults.warming))
    if faults.contrast_mode in HEATS:
        specimen = heated_on(specimen, setup.pose_number(observation), faults)
    if faults.worn:
        specimen = _worn(specimen, setup, observation, faults)
    if faults.mass_form not in _BY_POSE or not faults.added_mass:
        return specimen
    masses, shares = specimen.body.masses, specimen.shares
    added = _BY_POSE[faults.mass_form](masses, shares, setup, observation, faults)
    return replace(specimen, added=added)


def settle(
    specimen: Specimen, setup: Setup, observation: Observation, faults: Faults
) -> FloatArray:
    """Return node positions in one pose, object frame [m], shape (N, 3)."""
    specimen = _in_pose(specimen, setup, observation, faults)
    load = load_in_pose(specimen, setup, observation, faults)
    specimen = bowed(pinched(_dragged(specimen, faults), faults), faults)
    nominal = _clamp(specimen, setup, observation, faults)
    give = faults.clamp_compliance
    if faults.contact_height is not None and faults.contact_form == 'friction':
        return _settle_rubbing(specimen, load, nominal, *half_space(observation, faults))
    if faults.contact_height is not None and faults.contact_form in _SINKING:
        loads = partial(load_on_pan, specimen, setup, observation, faults)
        start = applied(nominal, specimen.mesh.nodes)
        sinks = _SINKING[faults.contact_form](faults)
        pressing = _pressing(observation, faults)
        part = _SINK_PARTS[faults.contact_form]
        return settle_on_pan(specimen.body, start, loads, pressing, sinks, part)
    if faults.clamp_form in LININGS:
        return settle_in_foam(specimen, load, nominal, faults)
    if faults.clamp_form == 'shear':
        return settle_sliding(specimen, load, nominal, give)
    if faults.clamp_form in _BEAMS:
        return settle_on_flexure(specimen, load, nominal, _BEAMS[faults.clamp_form](faults))
    if faults.clamp_form == 'about a corner':
        width, height = setup.shape.section
        corner = specimen.center + 0.5 * np.array([0.0, width, -height])
        specimen = replace(specimen, center=corner)
    wanted = wanted_turn(setup, _warmed_clamp(setup, observation, faults))
    if faults.clamp_form in _LASTING:
        before = _stayed(specimen, setup, observation, faults)
        wanted = _LASTING[faults.clamp_form](before, faults)
    return settle_clamped(specimen, load, nominal, wanted)[0]


def _warmed_clamp(setup: Setup, observation: Observation, faults: Faults) -> Faults:
    """Return faults whose clamp gives way by as much as it does in one pose."""
    if not faults.clamp_shares:
        return faults
    share = faults.clamp_shares[setup.pose_number(observation)]
    return replace(faults, clamp_compliance=share * faults.clamp_compliance)


def _pressing(
    observation: Observation, faults: Faults
) -> Callable[[FloatArray, FloatArray], float]:
    """Return force on a pan or a rope [N], or moment on a flap [N m], by a body's places."""
    if faults.contact_form == 'flap':
        return hinge_moment(observation, faults)
    normal = half_space(observation, faults)[0]
    return lambda positions, gradient: -float((gradient @ normal).sum())


def _stayed(
    specimen: Specimen, setup: Setup, observation: Observation, faults: Faults
) -> FloatArray:
    """Return the turn at which a clamp that keeps it was left by the poses before [rad]."""
    turn = np.zeros(3)
    for before in setup.observations[: setup.pose_number(observation)]:
        load = load_in_pose(specimen, setup, before, faults)
        nominal = _clamp(specimen, setup, before, faults)
        wanted = _LASTING[faults.clamp_form](turn, faults)
        turn = settle_clamped(specimen, load, nominal, wanted)[1]
    return turn


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
        slipped * 1e-3 * np.array(faults.clamp_shift)
        + 1e-3 * more[:3]
        + np.array([1e-3 * faults.clamp_slid, 0.0, 0.0]),
    )


def _slipped(setup: Setup, observation: Observation, faults: Faults) -> float:
    """Return which share of the clamp's shift is there in a pose."""
    if faults.clamp_by_load:
        down = observation.world_from_object[1, :3]
        return max(float(np.hypot(down[1], down[2])) - 0.7, 0.0) / 0.3
    if faults.clamp_growth:
        last = max(len(setup.observations) - 1, 1)
        part, whole = faults.clamp_growth ** np.array([setup.pose_number(observation), last]) - 1.0
        return float(part / whole)
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
