# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What acts on a body in one pose, its clamp aside, in the object frame."""

from dataclasses import replace

import numpy as np

from benchmarks.blind.blower import blown
from benchmarks.blind.catenary import slung
from benchmarks.blind.contact import contact_laws
from benchmarks.blind.draught import (
    curtain_share,
    drawn_in,
    eddy_share,
    hollow_share,
    layer_share,
    lee_share,
    louvre_share,
    opposed_share,
    screened_share,
    spread_out,
    spreading_share,
    stream_share,
    wall_share,
)
from benchmarks.blind.equilibrium import Load
from benchmarks.blind.faults import Faults
from benchmarks.blind.flap import free_side, turned_flap
from benchmarks.blind.heights import by_height
from benchmarks.blind.magnetism import magnetic_forces
from benchmarks.blind.pulls import pulls, tether, turntable
from benchmarks.blind.rotations import applied, rotation
from benchmarks.blind.setups import GRAVITY, Observation, Setup
from benchmarks.blind.seventh_outside import pressed
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.springs import around, springs
from benchmarks.blind.updraught import updraught_push
from benchmarks.blind.whirl import whirled

# Forms of a tilt that leave gravity as it is, and push beside it.
_PUSHES = (
    'growing',
    'outer_push',
    'middle_push',
    'opposed',
    'thread',
    'turntable',
    'blower',
    'draught',
    'layer',
    'curtain',
    'hair dryer',
    'louvred',
    'lee',
    'screened',
    'hub',
    'eddy',
    'wall jet',
    'extractor',
    'downwash',
)
# Pushes that go another way at each place of the world [m], by one as large as they are stated.
_DRAWN = {'extractor': drawn_in, 'downwash': spread_out}
# How much of a push is felt at places of the world [m], by its way there.
_FELT = {
    'draught': stream_share,
    'layer': layer_share,
    'curtain': curtain_share,
    'hair dryer': spreading_share,
    'louvred': louvre_share,
    'lee': lee_share,
    'screened': screened_share,
    'hub': hollow_share,
    'eddy': eddy_share,
    'wall jet': wall_share,
}


def load_in_pose(
    specimen: Specimen, setup: Setup, observation: Observation, faults: Faults
) -> Load:
    """Return all that acts on a body in one pose, its clamp aside."""
    number = setup.pose_number(observation)
    if faults.contact_drops and faults.contact_height is not None:
        sunk = 1e-3 * faults.contact_drops[number]
        faults = replace(faults, contact_height=faults.contact_height - sunk)
    forces = _forces(specimen, setup, observation, faults)
    if faults.memory and number:
        before = _forces(specimen, setup, setup.observations[number - 1], faults)
        forces = (1.0 - faults.memory) * forces + faults.memory * before
    masses, shares = specimen.body.masses + specimen.added, specimen.shares
    laws = [
        *contact_laws(specimen.areas, shares, observation, faults),
        *pulls(masses, shares, observation, faults),
        *by_height(specimen.mesh.lattice, masses, shares, observation, faults),
    ]
    if faults.tilt_form == 'turntable':
        laws.append(turntable(masses, observation, _side(faults), faults.tilt_radius))
    if faults.mass_form == 'slung' and faults.added_mass:
        nodes = specimen.mesh.nodes
        laws.append(slung(nodes, specimen.body.masses, shares, observation, faults))
    if faults.hose:
        places = specimen.mesh.nodes + 1e-3 * np.array(faults.hose_offset)
        stiffness = around(faults.hose, faults.hose_at, specimen.body.masses, shares)
        laws.append(springs(places, stiffness))
    if faults.guy:
        post, nodes = 1e-3 * np.array(faults.guy_post), specimen.mesh.nodes
        stiffness = around(faults.guy, faults.guy_at, specimen.body.masses, shares)
        laws.append(tether(post, stiffness, np.linalg.norm(nodes - post, axis=1)))
    return Load(forces, tuple(laws))


def load_on_pan(
    specimen: Specimen, setup: Setup, observation: Observation, faults: Faults, sunk: float
) -> Load:
    """Return the load where a pan has sunk by so much [m], or a flap has turned by it [rad]."""
    assert faults.contact_height is not None
    if faults.contact_form == 'flap':
        side = free_side(observation, specimen.mesh.nodes, faults)
        turned = turned_flap(faults, sunk, side)
        return load_in_pose(specimen, setup, observation, turned)
    lower = replace(faults, contact_height=faults.contact_height - sunk)
    return load_in_pose(specimen, setup, observation, lower)


def _forces(
    specimen: Specimen, setup: Setup, observation: Observation, faults: Faults
) -> FloatArray:
    """Return what pulls on the nodes wherever they are, object frame [N], shape (N, 3)."""
    object_from_world = observation.world_from_object[:3, :3].T
    gravity = _gravity(setup, observation, faults)
    wind = object_from_world @ np.array([0.0, 0.0, faults.wind * GRAVITY])
    masses, shares = specimen.body.masses + specimen.added, specimen.shares
    forces = masses[:, None] * gravity + specimen.tip_masses[:, None] * wind
    if faults.tilt_form in ('growing', 'outer_push', 'middle_push', 'opposed'):
        where = {
            'growing': np.maximum(shares, 0.0),
            'outer_push': 2.0 * (shares > 0.6),
            'middle_push': 6.0 * (np.abs(shares - 0.5) < 1.0 / 6.0),
            'opposed': opposed_share(shares, faults.tilt_at, faults.tilt_back),
        }[faults.tilt_form]
        forces = forces + (masses * where)[:, None] * (object_from_world @ _side(faults))
    if faults.tilt_form == 'thread':
        free = masses * (shares > 0.0)
        pull = around(float(free.sum()), faults.tilt_at, masses, shares)
        forces = forces + pull[:, None] * (object_from_world @ _side(faults))
    if faults.tilt_form == 'blower':
        free = float((masses * (shares > 0.0)).sum())
        push = free * (object_from_world @ _side(faults))
        forces = forces + blown(specimen.mesh, shares, push, setup.shape)
    if faults.tilt_form in _FELT:
        places = applied(observation.world_from_object, specimen.mesh.nodes)
        felt = _FELT[faults.tilt_form](places, _side(faults), faults) * masses * (shares > 0.0)
        forces = forces + felt[:, None] * (object_from_world @ _side(faults))
    if faults.tilt_form in _DRAWN:
        places = applied(observation.world_from_object, specimen.mesh.nodes)
        drawn = _DRAWN[faults.tilt_form](places, _side(faults), faults)
        drawn = drawn * (masses * (shares > 0.0))[:, None]
        forces = forces + drawn @ object_from_world.T
    if faults.whirl:
        places = applied(observation.world_from_object, specimen.mesh.nodes)
        pushed = whirled(places, faults) * (masses * (shares > 0.0))[:, None]
        forces = forces + pushed @ object_from_world.T
    if faults.updraught:
        places = applied(observation.world_from_object, specimen.mesh.nodes)
        lifted = updraught_push(places, faults) * masses * (shares > 0.0)
        forces = forces + lifted[:, None] * observation.world_from_object[1, :3]
    if faults.magnetized:
        field = faults.magnetized * (object_from_world @ np.array(faults.magnetic_way))
        forces = forces + magnetic_forces(specimen.body, field)
    if faults.jet:
        share = faults.jet_shares[setup.pose_number(observation)]
        forces = forces + pressed(
            faults.jet, faults.jet_at, faults.jet_normal, share, specimen.body.masses, shares
        )
    return forces


def _gravity(setup: Setup, observation: Observation, faults: Faults) -> FloatArray:
    """Return what pulls on every part, by its mass, object frame [m/s^2], shape (3,)."""
    object_from_world = observation.world_from_object[:3, :3].T
    down = np.array([0.0, -GRAVITY, 0.0])
    if faults.tilt_form == 'changing':
        middle = 0.5 * (len(setup.observations) - 1)
        share = 1.0 + 0.3 * (setup.pose_number(observation) - middle)
        return np.asarray(object_from_world @ _tilt(faults, share) @ down)
    if faults.tilt_form in ('rocking', 'deflating'):
        share = faults.tilt_shares[setup.pose_number(observation)]
        return np.asarray(object_from_world @ _tilt(faults, share) @ down)
    if faults.tilt_form == 'castors':
        turned = np.deg2rad(faults.tilt_turn) * setup.pose_number(observation)
        room = rotation(np.array([0.0, turned, 0.0]))
        return np.asarray(object_from_world @ room @ _tilt(faults) @ down)
    if faults.tilt_form == 'floating':
        more = faults.tilt_scatter[setup.pose_number(observation)]
        x, z = (float(one + other) for one, other in zip(faults.gravity_tilt, more, strict=True))
        return np.asarray(object_from_world @ _tilt(replace(faults, gravity_tilt=(x, z))) @ down)
    if faults.tilt_form == 'braking':
        push = np.array(faults.tilt_pushes[setup.pose_number(observation)])
        return np.asarray(object_from_world @ (down + push))
    if faults.tilt_form == 'tilt':
        return np.asarray(object_from_world @ _tilt(faults) @ down)
    side = _side(faults)
    if faults.tilt_form == 'fan':
        share = faults.tilt_shares[setup.pose_number(observation)]
        return np.asarray(object_from_world @ (down + share * side))
    if faults.tilt_form in _PUSHES:
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
