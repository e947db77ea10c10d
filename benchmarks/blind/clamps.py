# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where a body comes to rest in a clamp that gives way."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from benchmarks.blind.amplitudes import weight_moment
from benchmarks.blind.bracket import bracket, TIGHT
from benchmarks.blind.equilibrium import find_equilibrium, Load, PotentialLaw
from benchmarks.blind.faults import Faults
from benchmarks.blind.rotations import about, applied, rotation
from benchmarks.blind.setups import Setup
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.specimen import Specimen
from benchmarks.blind.springs import foam_stiffness, LININGS, putty, springs

_TURN_TOLERANCE = 1e-6  # Of the compliant clamp's turn [rad].
_SHIFT_TOLERANCE = 1e-8  # Of its shift [m].


def wanted_turn(setup: Setup, faults: Faults) -> Callable[[FloatArray], FloatArray]:
    """Return by how much a clamp turns [rad] by the moment on it [N m], shape (3,) each."""
    axes = {
        'uneven': np.diag([0.0, 1.0, 0.0]),
        'jaw': np.zeros((3, 3)),
        'about a corner': np.diag([1.0, 1.5, 0.5]),
    }
    compliance = faults.clamp_compliance * axes.get(faults.clamp_form, np.eye(3))
    hardening = _hardening(setup, faults)
    if not compliance.any():
        return lambda moment: np.zeros(3)
    return lambda moment: np.asarray(compliance @ moment / hardening(moment))


def lagged(
    before: FloatArray, compliance: float, rub: float
) -> Callable[[FloatArray], FloatArray]:
    """Return the turn of a clamp that rubs, by the moment on it, shape (3,) each.

    Args:
        before: where it stayed [rad], shape (3,).
        compliance: of its spring [rad/(N m)].
        rub: moment that its friction bears, whatever its way [N m].
    """

    def wanted(moment: FloatArray) -> FloatArray:
        away = compliance * moment - before
        size = float(np.linalg.norm(away))
        # It goes on as far as the spring draws it by more than it rubs.
        return before + away * max(1.0 - compliance * rub / max(size, 1e-30), 0.0)

    return wanted


def crept(
    before: FloatArray, compliance: float, part: float
) -> Callable[[FloatArray], FloatArray]:
    """Return the turn of a clamp that creeps, by the moment on it, shape (3,) each.

    Args:
        before: where it was left [rad], shape (3,).
        compliance: of its spring, once all has crept [rad/(N m)].
        part: of the way to there that it goes in a pose.
    """
    return lambda moment: before + part * (compliance * moment - before)


def flowed(before: FloatArray, compliance: float) -> Callable[[FloatArray], FloatArray]:
    """Return the turn of a clamp that flows, by the moment on it, shape (3,) each.

    Args:
        before: where it was left [rad], shape (3,).
        compliance: by how much it flows in a pose [rad/(N m)].
    """
    return lambda moment: before + compliance * moment


def _hardening(setup: Setup, faults: Faults) -> Callable[[FloatArray], FloatArray | float]:
    """Return by how much less than its compliance says a clamp gives way, by the moment on it."""
    if faults.clamp_form == 'one-sided':
        way = np.array([0.0, *faults.clamp_way])
        return lambda moment: np.where(way * moment > 0.0, 1.0, np.inf)
    if faults.clamp_form == 'play':
        easy = faults.clamp_compliance / float(np.deg2rad(faults.clamp_play))
        return lambda moment: float(np.hypot(1.0, easy * np.linalg.norm(moment)))
    if faults.clamp_form == 'preloaded':
        least = faults.clamp_preload
        return lambda moment: 1.0 / max(1.0 - least / float(np.linalg.norm(moment)), 1e-12)
    power = {'hardening': 0.5, 'softening': -0.4}.get(faults.clamp_form)
    if power is None:
        return lambda moment: 1.0
    _, usual = weight_moment(setup)
    return lambda moment: max(float(np.linalg.norm(moment)) / usual, 1e-6) ** power


def settle_in_foam(
    specimen: Specimen, load: Load, clamp: FloatArray, faults: Faults
) -> FloatArray:
    """Find the equilibrium of a body in a jaw that is lined."""
    places = applied(clamp, specimen.mesh.nodes)
    held = replace(load, potentials=(*load.potentials, lining(specimen, places, faults)))
    return find_equilibrium(specimen.body, held, places)


def lining(specimen: Specimen, places: FloatArray, faults: Faults) -> PotentialLaw:
    """Return what holds a body in a lined jaw: springs, putty or a bracket; of gel, its springs.

    Args:
        specimen: the body.
        places: to which they draw its nodes [m], shape (N, 3).
        faults: say how soft they are, and what they are of.
    """
    stiffness = lining_stiffness(specimen, faults)
    if faults.clamp_form == 'putty':
        return putty(places, stiffness, 1e-3 * faults.putty_give)
    if faults.clamp_form == 'bracket':
        foot = np.array([0.0, 0.0, -1e-3 * faults.bracket_drop])
        return bracket(places, stiffness, foot, faults.clamp_compliance)
    return springs(places, stiffness)


def lining_stiffness(specimen: Specimen, faults: Faults) -> FloatArray:
    """Return how stiff a lining is at each node at first, 0 outside [N/m], shape (N,)."""
    nodes, mouth = specimen.mesh.nodes, 2.0 * float(specimen.center[0])
    softer, give = LININGS[faults.clamp_form], faults.clamp_compliance
    if faults.clamp_form == 'bracket':
        give /= TIGHT
    return foam_stiffness(nodes, specimen.areas, specimen.mesh.held, mouth, give, softer)


def settle_sliding(
    specimen: Specimen, load: Load, clamp: FloatArray, compliance: float
) -> FloatArray:
    """Find the equilibrium where the held section gives way along the force on it."""
    # Its weight is all that a body asks of its clamp, contact aside: one step is exact then.
    positions = find_equilibrium(specimen.body, load, applied(clamp, specimen.mesh.nodes))
    return positions + compliance * _clamp_pull(specimen, load, positions).sum(axis=0)


def settle_clamped(
    specimen: Specimen, load: Load, clamp: FloatArray, wanted: Callable[[FloatArray], FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """Find the equilibrium; a compliant clamp turns until its spring bears the moment.

    Args:
        specimen: the body.
        load: on it.
        clamp: where the held section is to be, shape (4, 4).
        wanted: its turn about the object's axes [rad] by the moment on it [N m], shape (3,) each.

    Returns:
        Node positions [m], shape (N, 3), and that turn.
    """
    nodes = specimen.mesh.nodes
    positions = find_equilibrium(specimen.body, load, applied(clamp, nodes))
    center = applied(clamp, specimen.center)
    turn = np.zeros(3)
    for _ in range(60):
        moment = _clamp_moment(specimen, load, positions, center)
        # Half a step: the moment itself falls as the clamp gives way.
        change = 0.7 * (wanted(moment) - turn)
        if np.linalg.norm(change) < _TURN_TOLERANCE:
            return positions, turn
        old, turn = rotation(turn), turn + change
        # The whole body turns along: a start with almost no new strain.
        motion = about(rotation(turn) @ old.T, center, np.zeros(3))
        start = applied(motion, positions)
        held = specimen.body.held
        start[held] = applied(
            about(rotation(turn), center, np.zeros(3)), applied(clamp, nodes[held])
        )
        positions = find_equilibrium(specimen.body, load, start)
    raise RuntimeError('the compliant clamp found no rest')


def settle_on_flexure(
    specimen: Specimen, load: Load, clamp: FloatArray, compliance: FloatArray
) -> FloatArray:
    """Find the equilibrium where the held section shifts and turns by both force and moment.

    Args:
        specimen: the body.
        load: on it.
        clamp: where the held section is to be, shape (4, 4).
        compliance: shift [m] and turn [rad] by force [N] and moment [N m], shape (6, 6).
    """
    nodes, held = specimen.mesh.nodes, specimen.body.held
    positions = find_equilibrium(specimen.body, load, applied(clamp, nodes))
    center, given = applied(clamp, specimen.center), np.zeros(6)
    for _ in range(60):
        force = _clamp_pull(specimen, load, positions).sum(axis=0)
        moment = _clamp_moment(specimen, load, positions, center + given[:3])
        # As far as a compliant clamp that only turns.
        change = 0.7 * (compliance @ np.concatenate([force, moment]) - given)
        small = np.linalg.norm(change[:3]) < _SHIFT_TOLERANCE
        if small and np.linalg.norm(change[3:]) < _TURN_TOLERANCE:
            return positions
        before = about(rotation(given[3:]), center, given[:3])
        given = given + change
        after = about(rotation(given[3:]), center, given[:3])
        start = applied(after @ np.linalg.inv(before), positions)
        start[held] = applied(after @ clamp, nodes[held])
        positions = find_equilibrium(specimen.body, load, start)
    raise RuntimeError('the clamp on a flexure found no rest')


def _clamp_pull(specimen: Specimen, load: Load, positions: FloatArray) -> FloatArray:
    """Return the forces that the body exerts on its clamp at the held nodes [N], shape (H, 3)."""
    pull = load.forces - specimen.body.evaluate(positions, with_stiffness=False).gradient
    return np.asarray(pull[specimen.body.held])


def _clamp_moment(
    specimen: Specimen, load: Load, positions: FloatArray, center: FloatArray
) -> FloatArray:
    """Return the moment that the body exerts on its clamp about a point [N m]."""
    pull = _clamp_pull(specimen, load, positions)
    arms = positions[specimen.body.held] - center
    moment: FloatArray = np.cross(arms, pull).sum(axis=0)
    return moment
