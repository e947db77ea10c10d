# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a body may lie on, as penalties of its nodes in the object frame."""

from dataclasses import replace

import numpy as np

from benchmarks.blind.air_table import air_table
from benchmarks.blind.brush import brush
from benchmarks.blind.corrugated import corrugated, corrugated_tops
from benchmarks.blind.crate import crate, crate_tops
from benchmarks.blind.dish import dish, dish_tops
from benchmarks.blind.equilibrium import Potential, PotentialLaw
from benchmarks.blind.faults import Faults
from benchmarks.blind.felt import felt
from benchmarks.blind.gel_pad import gel_pad
from benchmarks.blind.groove import groove, groove_tops
from benchmarks.blind.knob import knob, rounded
from benchmarks.blind.packing import packing
from benchmarks.blind.pipe import pipe, pipe_tops
from benchmarks.blind.rim import rim, rim_tops
from benchmarks.blind.rubber_balls import rubber_balls
from benchmarks.blind.saddle import saddle, saddle_tops
from benchmarks.blind.setups import Observation
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.tent import tent, tent_tops

_CONTACT_STIFFNESS = 5.0e8  # [Pa/m]: a soft body sinks in by some micrometres.
_FOAM_STIFFNESS = 4.0e7  # [Pa/m^2]: by some millimetres.
_MAT_STIFFNESS = 1.0e5  # Of a mat at first [Pa/m]: a body sinks in by a millimetre or two.
_MAT = 0.003  # Thickness of a mat [m].
_PRESSED = 0.9  # Share of that up to which a mat is followed; then it is as stiff as there.
FRICTION = 0.5  # Force across over the one that presses.
_STICKING = 1e-4  # Over which friction sets in [m].
_ROLL_STIFFNESS = 3.0e8  # Of a roll of foam [Pa/m^2]: by some millimetres.
BAR = 0.010  # Radius of a bar [m].
_ROLL = 0.018  # Of a roll of foam [m].
_ROPE = 0.006  # Of a rubber rope [m].
_RACK = 0.008  # Of the bars of a drying rack [m].
_BARS = 6  # Of a rack to either side of the one below a body's outer part.
# Share of the free length at which what lies below the outer part alone begins.
OUTER = {
    'step': 0.45,
    'dish': 0.6,
    'cushion': 0.4,
    'flap': 0.4,
    'pipe': 0.4,
    'saddle': 0.6,
    'rim': 0.6,
}
# What is not level below all of a body.
_WAVED = {'crate': crate, 'corrugated': corrugated, 'tent': tent, 'saddle': saddle, 'rim': rim}
_WAVED_TOPS = {
    'crate': crate_tops,
    'corrugated': corrugated_tops,
    'tent': tent_tops,
    'saddle': saddle_tops,
    'rim': rim_tops,
}
# Half-spaces that push by a force which is told, and by a length.
_PRESSED_BY = {
    'brush': brush,
    'felt': felt,
    'hovering': air_table,
    'packing': packing,
    'gel pad': gel_pad,
    'rubber balls': rubber_balls,
}
# Radius of what is round, along the world's z [m].
ROUND = {'edge': BAR, 'roll': _ROLL, 'rope': _ROPE, 'rack': _RACK}
# What reaches below a body's root as well, which is to stay above it.
LONG = ('pipe', 'rack')


def contact_laws(
    areas: FloatArray, shares: FloatArray, observation: Observation, faults: Faults
) -> tuple[PotentialLaw, ...]:
    """Return what a body lies on in one pose, without friction.

    Args:
        areas: surface that belongs to each node [m^2], shape (N,).
        shares: of the free length at which nodes lie, shape (N,).
        observation: the pose.
        faults: say what there is, and where.
    """
    if faults.contact_height is None:
        return ()
    stiffness = (faults.contact_stiffness or _CONTACT_STIFFNESS) * areas
    if faults.contact_form in ('edge', 'rope'):
        return (_bar(observation, faults, stiffness, 1),)
    if faults.contact_form == 'rack':
        places = faults.contact_at + faults.contact_wave * np.arange(-_BARS, _BARS + 1)
        bars = [replace(faults, contact_at=float(place)) for place in places]
        return tuple(_bar(observation, bar, stiffness, 1) for bar in bars)
    if faults.contact_form == 'roll':
        return (_bar(observation, faults, _ROLL_STIFFNESS * areas, 2),)
    if faults.contact_form == 'vee':
        return (groove(observation, faults.contact_height, faults.contact_at, stiffness),)
    if faults.contact_form in ('dish', 'cushion', 'pipe'):
        below = shares > OUTER[faults.contact_form]
        round_law = pipe if faults.contact_form == 'pipe' else dish
        return (round_law(observation, faults, stiffness * below),)
    if faults.contact_form == 'knob':
        return (knob(faults, stiffness),)
    if faults.contact_form in _WAVED:
        # What rises without end, or a rim, lies below the outer part alone.
        below = shares > OUTER.get(faults.contact_form, -1.0)
        return (_WAVED[faults.contact_form](observation, faults, stiffness * below),)
    normal, height = half_space(observation, faults)
    if faults.contact_form == 'shelf':
        stiffness = stiffness * (shares > 0.55)
    if faults.contact_form in ('foam', 'mat', *_PRESSED_BY):
        return (_soft(normal, height, areas, faults),)
    outer, heights = np.outer(normal, normal), height - lowered(shares, faults)

    def penalty(positions: FloatArray) -> Potential:
        depth = np.maximum(heights - positions @ normal, 0.0)
        push = stiffness * depth
        return Potential(
            energy=0.5 * float((push * depth).sum()),
            gradient=-push[:, None] * normal,
            diagonal=(stiffness * (depth > 0.0))[:, None, None] * outer,
        )

    return (penalty,)


def _soft(normal: FloatArray, height: float, areas: FloatArray, faults: Faults) -> PotentialLaw:
    """Return a half-space whose pressure is not in proportion to the dent.

    Args:
        normal: object frame, shape (3,).
        height: of its surface along that [m].
        areas: surface that belongs to each node [m^2], shape (N,).
        faults: say what it is made of.
    """
    if faults.contact_form == 'foam':
        return _foam(normal, height, _FOAM_STIFFNESS * areas)
    if faults.contact_form == 'mat':
        return _mat(normal, height, _MAT_STIFFNESS * areas)
    law = _PRESSED_BY[faults.contact_form]
    return law(normal, height, faults.contact_pressure * areas, faults.contact_bend)


def half_space(observation: Observation, faults: Faults) -> tuple[FloatArray, float]:
    """Return normal, shape (3,), and height [m] of a half-space in the object frame."""
    assert faults.contact_height is not None
    if faults.contact_form == 'rig':
        return np.array(faults.contact_normal), faults.contact_height
    matrix = observation.world_from_object
    world_normal = np.array(faults.contact_normal)
    normal = matrix[:3, :3].T @ world_normal
    return normal, faults.contact_height - float(world_normal @ matrix[:3, 3])


def lowered(shares: FloatArray, faults: Faults) -> FloatArray:
    """Return by how much lower what is below nodes lies than its height [m], shape (N,).

    Args:
        shares: of the free length at which nodes lie, shape (N,).
        faults: say what is below; infinite where that is nothing.
    """
    if faults.contact_form not in OUTER:
        return np.zeros(len(shares))
    down = 1e-3 * faults.contact_step * (shares > faults.contact_share)
    return np.where(shares > OUTER[faults.contact_form], down, np.inf)


def highest_tops(points: FloatArray, faults: Faults) -> FloatArray:
    """Return how high what is below may reach before it touches each node [m], shape (N,).

    Args:
        points: in the world [m], shape (N, 3).
        faults: say what is below; their height does not matter.
    """
    if faults.contact_form == 'vee':
        return groove_tops(points, faults.contact_at)
    if faults.contact_form == 'pipe':
        return pipe_tops(points, faults)
    if faults.contact_form in ('dish', 'cushion'):
        return dish_tops(points, faults)
    if faults.contact_form in _WAVED_TOPS:
        return _WAVED_TOPS[faults.contact_form](points, faults)
    if faults.contact_form not in ROUND:
        return np.asarray(points @ np.array(faults.contact_normal))
    radius = ROUND[faults.contact_form]
    away = points[:, 0] - faults.contact_at
    if faults.contact_form == 'rack':
        # From the nearest bar.
        away = away - faults.contact_wave * np.round(away / faults.contact_wave)
    squares = radius**2 - away**2
    beside = np.sqrt(np.maximum(squares, 0.0)) - radius
    return np.where(squares > 0.0, points[:, 1] - beside, np.inf)


def _foam(normal: FloatArray, height: float, stiffness: FloatArray) -> PotentialLaw:
    """Return a half-space whose pressure grows with the square of the dent.

    Args:
        normal: object frame, shape (3,).
        height: of its surface along that [m].
        stiffness: force by the square of the dent at each node [N/m^2], shape (N,).
    """
    outer = np.outer(normal, normal)

    def penalty(positions: FloatArray) -> Potential:
        dent = np.maximum(height - positions @ normal, 0.0)
        return Potential(
            energy=float((stiffness * dent**3).sum()) / 3.0,
            gradient=-(stiffness * dent**2)[:, None] * normal,
            diagonal=(2.0 * stiffness * dent)[:, None, None] * outer,
        )

    return penalty


def _mat(normal: FloatArray, height: float, stiffness: FloatArray) -> PotentialLaw:
    """Return a half-space under a mat: stiffness dent / (1 - dent / thickness) presses back.

    Args:
        normal: object frame, shape (3,).
        height: of the mat's upper side along that [m].
        stiffness: force by dent at each node, at first [N/m], shape (N,).
    """
    outer = np.outer(normal, normal)
    steep = 1.0 / (1.0 - _PRESSED) ** 2

    def penalty(positions: FloatArray) -> Potential:
        dent = np.maximum(height - positions @ normal, 0.0) / _MAT
        part = np.minimum(dent, _PRESSED)
        beyond = dent - part
        push = part / (1.0 - part) + steep * beyond
        energy = -np.log1p(-part) - part + (part / (1.0 - part) + 0.5 * steep * beyond) * beyond
        slope = (dent > 0.0) / (1.0 - part) ** 2
        return Potential(
            energy=float((stiffness * energy).sum()) * _MAT**2,
            gradient=-(stiffness * _MAT * push)[:, None] * normal,
            diagonal=(stiffness * slope)[:, None, None] * outer,
        )

    return penalty


def _bar(
    observation: Observation, faults: Faults, stiffness: FloatArray, power: int
) -> PotentialLaw:
    """Return a round bar along the world's z.

    Args:
        observation: the pose.
        faults: say where its axis is along the world's x and how high it reaches along y [m].
        stiffness: force at each node by a power of the dent [N/m^power], shape (N,).
        power: 1 of a hard bar, 2 of foam.
    """
    assert faults.contact_height is not None
    radius, at, top = ROUND[faults.contact_form], faults.contact_at, faults.contact_height
    turn, shift = observation.world_from_object[:3, :3], observation.world_from_object[:3, 3]
    on_axis = turn.T @ (np.array([at, top - radius, 0.0]) - shift)
    across = np.eye(3) - np.outer(turn[2], turn[2])
    return rounded(on_axis, across, radius, stiffness, power)


def friction(normal: FloatArray, pushes: FloatArray, touched: FloatArray) -> PotentialLaw:
    """Return friction of nodes that are pressed on by known forces.

    Its energy is FRICTION push (sqrt(u^2 + e^2) - e) of the way u along the surface: a force that
    is FRICTION times the one that presses, once a node has slid some tenths of a millimetre.

    Args:
        normal: of the surface, shape (3,).
        pushes: forces that press each node [N], shape (N,).
        touched: where nodes come to it [m], shape (N, 3).
    """
    along = np.eye(3) - np.outer(normal, normal)
    most = FRICTION * pushes

    def penalty(positions: FloatArray) -> Potential:
        way = (positions - touched) @ along
        size = np.sqrt((way**2).sum(axis=1) + _STICKING**2)
        unit = way / size[:, None]
        bent = along - unit[:, :, None] * unit[:, None, :]
        return Potential(
            energy=float((most * (size - _STICKING)).sum()),
            gradient=most[:, None] * unit,
            diagonal=(most / size)[:, None, None] * bent,
        )

    return penalty
