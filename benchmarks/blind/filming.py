# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where the nodes of a released body are at the moments of its frames."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from benchmarks.blind.balls import balls_under
from benchmarks.blind.body import Body, IntArray
from benchmarks.blind.breeze import breeze_push, make_breeze
from benchmarks.blind.clamps import lining, lining_stiffness
from benchmarks.blind.creep import held_load
from benchmarks.blind.drag import (
    Drag,
    make_cup,
    make_drag,
    make_felts,
    make_fur,
    make_sail,
    make_tuft,
    make_vane,
)
from benchmarks.blind.equilibrium import find_equilibrium, Load, PotentialLaw
from benchmarks.blind.faults import Faults
from benchmarks.blind.gust import with_gust
from benchmarks.blind.oiling import depth_below
from benchmarks.blind.pulls import tether
from benchmarks.blind.relaxation import GRADED, material_times, prony_pairs
from benchmarks.blind.remanence import with_remanence
from benchmarks.blind.rig_motion import acting, leaned
from benchmarks.blind.setups import GRAVITY, Observation, Setup
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.simulation import Specimen
from benchmarks.blind.springs import around, LININGS
from benchmarks.blind.swing import consistent_masses, Forces, swing, with_lumps
from benchmarks.blind.tearing import torn
from benchmarks.blind.timing import LEDGE, Timing
from benchmarks.blind.unrolling import unrolling
from benchmarks.blind.wadding import wadding_under

_STEP = 1.0 / 600.0
_EDGE = 0.99  # Of the way from the middle to a side, from which on a node is on that.


def positions_at(
    specimen: Specimen,
    setup: Setup,
    observation: Observation,
    faults: Faults,
    timing: Timing,
    times: Sequence[float],
) -> list[FloatArray]:
    """Return node positions, object frame [m], shape (N, 3), at times since the release [s].

    They are ascending; before the release a body lies on its ledge.
    """
    object_from_world = observation.world_from_object[:3, :3].T
    gravity = object_from_world @ np.array([0.0, -GRAVITY, 0.0])
    masses = specimen.body.masses + lumps(specimen, setup, faults)
    weight = masses[:, None] * gravity
    push = breeze_push(specimen, observation, faults)
    load = Load(weight + push, drawing(specimen, weight, faults))
    leaning = masses[:, None] * (object_from_world @ leaned(faults, 0.0))
    first = replace(load, forces=load.forces + leaning)
    start = find_equilibrium(_supported(specimen, setup), first, specimen.mesh.nodes)
    after = [float(time) for time in times if time > 0.0]
    if faults.leak_mass:
        moving = _leaking(specimen, faults, load, gravity, start, after)
    elif faults.curvature_form == 'unrolling':
        moving = unrolling(specimen, setup, faults, load, start, after)
    elif timing.is_slow:
        moving = _creeping(specimen, setup, faults, load, start, after)
    else:
        moving = _swinging(specimen, setup, observation, faults, timing, load, start, after)
    return [start] * (len(times) - len(after)) + moving


def drawing(specimen: Specimen, weight: FloatArray, faults: Faults) -> tuple[PotentialLaw, ...]:
    """Return energies of what draws a body wherever it swings.

    Args:
        specimen: the body.
        weight: of it, object frame [N], shape (N, 3).
        faults: say what there is.
    """
    laws = []
    if faults.clamp_form in LININGS:
        laws.append(lining(specimen, specimen.mesh.nodes, faults))
    if faults.leash:
        rest = find_equilibrium(specimen.body, Load(weight), specimen.mesh.nodes)
        laws.append(leash(specimen, rest, faults))
    possible = ((faults.wool, wadding_under), (faults.balls, balls_under))
    below = [law for stiffness, law in possible if stiffness]
    if below:
        up = -weight.sum(axis=0) / float(np.linalg.norm(weight.sum(axis=0)))
        rest = find_equilibrium(specimen.body, Load(weight), specimen.mesh.nodes)
        laws.extend(law(specimen, rest, up, faults) for law in below)
    return tuple(laws)


def dashpots(specimen: Specimen, faults: Faults) -> FloatArray | None:
    """Return what a lining of gel holds nodes back with by their speed [N s/m], shape (N,)."""
    if faults.clamp_form != 'gel':
        return None
    return faults.clamp_time * lining_stiffness(specimen, faults)


def leash(specimen: Specimen, rest: FloatArray, faults: Faults) -> PotentialLaw:
    """Return a cord to the rig that is slack where a body rests, at nodes (N, 3) [m]."""
    post = 1e-3 * np.array(faults.leash_post)
    near, far = (np.linalg.norm(each - post, axis=1) for each in (specimen.mesh.nodes, rest))
    stiffness = around(faults.leash, faults.leash_at, specimen.areas, specimen.shares)
    return tether(post, stiffness, near + faults.leash_taut * (far - near))


def lumps(specimen: Specimen, setup: Setup, faults: Faults) -> FloatArray:
    """Return the masses of what is stuck on a body at each node [kg], shape (N,)."""
    stuck = end_lumps(specimen, setup, faults) + chain_lumps(specimen, setup, faults)
    return stuck + leak_lumps(specimen, faults, 0.0) + pack_lumps(specimen, setup, faults)


def chain_lumps(specimen: Specimen, setup: Setup, faults: Faults) -> FloatArray:
    """Return the mass of a chain along one side at each node [kg], shape (N,)."""
    if not faults.chain_mass:
        return np.zeros(len(specimen.areas))
    across = specimen.mesh.lattice[:, 1] / (0.5 * setup.shape.section[0])
    is_there = (faults.chain_side * across > _EDGE) & (specimen.shares >= faults.chain_from)
    weights = np.where(is_there, specimen.areas, 0.0)
    return np.asarray(1e-3 * faults.chain_mass * weights / weights.sum())


def pack_lumps(specimen: Specimen, setup: Setup, faults: Faults) -> FloatArray:
    """Return the mass of a flat pack below a body at each node [kg], shape (N,).

    It is soft, and even from one place to the other: a bag of shot.
    """
    if not faults.pack_mass:
        return np.zeros(len(specimen.areas))
    height = specimen.mesh.lattice[:, 2] / (0.5 * setup.shape.section[1])
    along = (specimen.shares >= faults.pack_from) & (specimen.shares <= faults.pack_until)
    weights = np.where(along & (height < -_EDGE), specimen.areas, 0.0)
    return np.asarray(1e-3 * faults.pack_mass * weights / weights.sum())


def leak_lumps(specimen: Specimen, faults: Faults, time: float) -> FloatArray:
    """Return the mass at each node of water that runs out of a cup [kg], shape (N,).

    By a hole in its bottom, through which it comes the slower the lower it stands (Torricelli).

    Args:
        specimen: the body.
        faults: say how much there is at first, where, and how long it runs.
        time: since the release [s].
    """
    if not faults.leak_mass:
        return np.zeros(len(specimen.areas))
    left = 1e-3 * faults.leak_mass * max(1.0 - time / faults.leak_time, 0.0) ** 2
    return around(left, faults.leak_at, specimen.areas, specimen.shares)


def end_lumps(specimen: Specimen, setup: Setup, faults: Faults) -> FloatArray:
    """Return the mass of a plate on the end face at each node [kg], shape (N,)."""
    return 1e-3 * faults.end_mass * _end_shares(specimen, setup)


def _end_face(specimen: Specimen, setup: Setup) -> IntArray:
    """Return the nodes of the end face, which a ledge holds."""
    return np.flatnonzero(specimen.mesh.lattice[:, 0] >= setup.shape.length - LEDGE)


def _end_shares(specimen: Specimen, setup: Setup) -> FloatArray:
    """Return each node's share in the end face, by the surface that belongs to it, shape (N,)."""
    shares, face = np.zeros(len(specimen.areas)), _end_face(specimen, setup)
    shares[face] = specimen.areas[face] / specimen.areas[face].sum()
    return shares


def _supported(specimen: Specimen, setup: Setup) -> Body:
    """Return the body whose end face is held, too."""
    held = np.union1d(specimen.body.held, _end_face(specimen, setup))
    return replace(specimen.body, held=held)


def _creeping(
    specimen: Specimen,
    setup: Setup,
    faults: Faults,
    load: Load,
    start: FloatArray,
    times: Sequence[float],
) -> list[FloatArray]:
    body = specimen.body
    share = specimen.shares[body.cells] @ body.quadrature.values.T
    is_graded = faults.creep_form in GRADED
    pairs = prony_pairs(faults, share, depth_below(specimen, setup))
    when = material_times(faults, times)
    return held_load(body, load, start, when, pairs, is_graded=is_graded)


def _leaking(
    specimen: Specimen,
    faults: Faults,
    load: Load,
    gravity: FloatArray,
    start: FloatArray,
    times: Sequence[float],
) -> list[FloatArray]:
    """Return where a body rests while its load runs out; nothing of it creeps."""
    whole, places = leak_lumps(specimen, faults, 0.0), start
    found = []
    for time in times:
        gone = whole - leak_lumps(specimen, faults, time)
        lighter = replace(load, forces=load.forces - gone[:, None] * gravity)
        places = find_equilibrium(specimen.body, lighter, places)
        found.append(places)
    return found


def _swinging(
    specimen: Specimen,
    setup: Setup,
    observation: Observation,
    faults: Faults,
    timing: Timing,
    load: Load,
    start: FloatArray,
    times: Sequence[float],
) -> list[FloatArray]:
    stuck = lumps(specimen, setup, faults)
    masses = consistent_masses(specimen.mesh.nodes, specimen.body, setup.density)
    masses = with_lumps(masses, specimen.body, stuck)
    nodal, end = specimen.body.masses + stuck, _end_shares(specimen, setup)
    changing = with_remanence(acting(observation, faults, nodal, end), end, faults)
    forces = Forces(
        # What a breeze does to a body that stands is in its drag as well.
        load.forces - breeze_push(specimen, observation, faults),
        timing.damping,
        _drag(specimen, observation, faults),
        setup.youngs_modulus,
        with_gust(changing, specimen, faults),
        load.potentials,
        dashpots(specimen, faults),
    )
    then = (faults.tearing_time, torn(specimen, faults)) if faults.tearing else None
    return swing(specimen.body, masses, forces, start, times, _STEP, then)


def _drag(specimen: Specimen, observation: Observation, faults: Faults) -> Drag:
    area = 1e-4 * faults.drag_area
    if faults.tilt_form == 'breeze':
        return make_breeze(specimen, observation, faults)
    if faults.rubbed:
        return make_felts(faults.rubbed, faults.rubbed_at, specimen.areas, specimen.shares)
    if faults.drag_form == 'furred':
        return make_fur(area, faults.drag_at, specimen.areas, specimen.shares)
    if faults.drag_form == 'sail':
        return make_sail(area, faults.drag_at, specimen.body.masses, specimen.shares)
    if faults.drag_form == 'cup':
        mouth, areas = faults.drag_mouth, specimen.areas
        return make_cup(area, faults.drag_at, mouth, areas, specimen.shares)
    if faults.drag_form == 'vane':
        slant, areas = faults.drag_slant, specimen.areas
        return make_vane(area, faults.drag_at, slant, areas, specimen.shares)
    if faults.drag_form == 'tuft':
        bends, areas = faults.drag_bends, specimen.areas
        return make_tuft(area, faults.drag_at, bends, areas, specimen.shares)
    return make_drag(specimen.mesh, area, faults.drag_form)
