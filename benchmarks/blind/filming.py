# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where the nodes of a released body are at the moments of its frames."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from benchmarks.blind.body import Body
from benchmarks.blind.creep import held_load
from benchmarks.blind.drag import make_drag
from benchmarks.blind.equilibrium import find_equilibrium, Load
from benchmarks.blind.faults import Faults
from benchmarks.blind.setups import GRAVITY, Observation, Setup
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.simulation import Specimen
from benchmarks.blind.swing import consistent_masses, Forces, swing
from benchmarks.blind.timing import LEDGE, Timing

_STEP = 1.0 / 600.0


def moments(timing: Timing, faults: Faults) -> list[float]:
    """Return when the frames were taken in truth, after the release [s]."""
    late = np.full(timing.frame_count, 1e-3 * faults.stamps_late)
    if faults.stamps_form == 'drift':
        late *= np.linspace(0.5, 1.5, len(late))
    if faults.stamps_form == 'jitter':
        random = np.random.default_rng(round(1e5 * abs(faults.stamps_late)))
        late *= 1.0 + random.choice([-1.0, 1.0], len(late)) / 3.0
    return [float(when) for when in np.array(timing.stamps) - late - timing.release]


def filmed_positions(
    specimen: Specimen, setup: Setup, observation: Observation, faults: Faults, timing: Timing
) -> list[FloatArray]:
    """Return node positions in every frame, object frame [m], shape (N, 3)."""
    object_from_world = observation.world_from_object[:3, :3].T
    gravity = object_from_world @ np.array([0.0, -GRAVITY, 0.0])
    load = Load(specimen.body.masses[:, None] * gravity)
    start = find_equilibrium(_supported(specimen, setup), load, specimen.mesh.nodes)
    when = moments(timing, faults)
    after = [moment for moment in when if moment > 0.0]
    moving = _after(specimen, setup, faults, timing, load, start, after)
    return [start] * (len(when) - len(after)) + moving


def _supported(specimen: Specimen, setup: Setup) -> Body:
    """Return the body whose end face is held, too."""
    face = np.flatnonzero(specimen.mesh.lattice[:, 0] >= setup.shape.length - LEDGE)
    return replace(specimen.body, held=np.union1d(specimen.body.held, face))


def _after(
    specimen: Specimen,
    setup: Setup,
    faults: Faults,
    timing: Timing,
    load: Load,
    start: FloatArray,
    times: Sequence[float],
) -> list[FloatArray]:
    if timing.is_slow:
        return held_load(specimen.body, load, start, times, _prony_pairs(faults))
    masses = consistent_masses(specimen.mesh.nodes, specimen.body, setup.density)
    drag = make_drag(specimen.mesh, 1e-4 * faults.drag_area, faults.drag_form)
    forces = Forces(load.forces, timing.damping, drag, setup.youngs_modulus)
    return swing(specimen.body, masses, forces, start, times, _STEP)


def _prony_pairs(faults: Faults) -> list[tuple[float, float]]:
    share, time = faults.creep_share, faults.creep_time
    if faults.creep_form == 'two':
        return [(0.5 * share, time), (0.5 * share, 5.0 * time)]
    return [(share, time)]
