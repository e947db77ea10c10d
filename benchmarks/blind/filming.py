# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where the nodes of a released body are at the moments of its frames."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from benchmarks.blind.body import Body, IntArray
from benchmarks.blind.creep import held_load
from benchmarks.blind.drag import Drag, make_drag, make_sail
from benchmarks.blind.equilibrium import find_equilibrium, Load
from benchmarks.blind.faults import Faults
from benchmarks.blind.relaxation import prony_pairs
from benchmarks.blind.rig_motion import acting
from benchmarks.blind.setups import GRAVITY, Observation, Setup
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.simulation import Specimen
from benchmarks.blind.swing import consistent_masses, Forces, swing, with_lumps
from benchmarks.blind.timing import LEDGE, Timing

_STEP = 1.0 / 600.0


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
    masses = specimen.body.masses + end_lumps(specimen, setup, faults)
    load = Load(masses[:, None] * gravity)
    start = find_equilibrium(_supported(specimen, setup), load, specimen.mesh.nodes)
    after = [float(time) for time in times if time > 0.0]
    if timing.is_slow:
        moving = _creeping(specimen, faults, load, start, after)
    else:
        moving = _swinging(specimen, setup, observation, faults, timing, load, start, after)
    return [start] * (len(times) - len(after)) + moving


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
    specimen: Specimen, faults: Faults, load: Load, start: FloatArray, times: Sequence[float]
) -> list[FloatArray]:
    body = specimen.body
    share = specimen.shares[body.cells] @ body.quadrature.values.T
    is_graded = faults.creep_form == 'power'
    pairs = prony_pairs(faults, share)
    return held_load(body, load, start, times, pairs, is_graded=is_graded)


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
    lumps = end_lumps(specimen, setup, faults)
    masses = consistent_masses(specimen.mesh.nodes, specimen.body, setup.density)
    masses = with_lumps(masses, specimen.body, lumps)
    nodal, end = specimen.body.masses + lumps, _end_shares(specimen, setup)
    forces = Forces(
        load.forces,
        timing.damping,
        _drag(specimen, faults),
        setup.youngs_modulus,
        acting(observation, faults, nodal, end),
    )
    return swing(specimen.body, masses, forces, start, times, _STEP)


def _drag(specimen: Specimen, faults: Faults) -> Drag:
    area = 1e-4 * faults.drag_area
    if faults.drag_form == 'sail':
        return make_sail(area, faults.drag_at, specimen.body.masses, specimen.shares)
    return make_drag(specimen.mesh, area, faults.drag_form)
