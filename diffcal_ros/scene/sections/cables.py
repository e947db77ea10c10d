# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Cables that run through the body: where, how long at rest, how stiff."""

from collections.abc import Sequence
from dataclasses import replace

from diffcal_ros.fem.terms.cable_route import CableRoute, route_through, RouteError
from diffcal_ros.fem.terms.conditions import CableState
from diffcal_ros.scene.model import Cable, ObservationSetup, Quantity, Scene
from diffcal_ros.scene.reading.problems import listed, shown, suggestion
from diffcal_ros.scene.reading.quantities import NAME, quantity_shape, QuantityRule, read_quantity
from diffcal_ros.scene.reading.section import finite_numbers, Section
from diffcal_ros.scene.reading.shapes import Flag, Interval, Keys, ListOf, Number, POSITIVE, vector
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# A fit may shorten a cable to this share of its route, or find it slack by a half.
_SHORTEST, _LONGEST = 0.2, 1.5
_STIFFNESSES = Interval(1.0, 1e7)  # From a rubber band to a steel rope of a hand's length.
_USUAL_STIFFNESS = 1e4
_VIA = 'give a list of via points, [x, y, z] each, in metres in the object frame'
_REST_LENGTH = QuantityRule("the cable's rest length", 'm', POSITIVE, POSITIVE)
_STIFFNESS = QuantityRule("the cable's stiffness", 'N/m', POSITIVE, _STIFFNESSES)

CABLES_SHAPE = Keys(
    about='cables that run through the body without friction and only pull; bodies at rest only',
    name_pattern=NAME.pattern,
    named=Keys(
        {
            'via': ListOf(
                vector(3, '[x, y, z] in m, object frame'),
                'via points from one end to the other; both ends are fixed to the body',
                fewest=2,
            ),
            'crosses_gaps': Flag('it may hang free between via points; default false'),
            'stiffness': quantity_shape(
                _STIFFNESS,
                'pull per stretch in N/m; default 1e4',
                Interval(0.0, _STIFFNESSES.high),
            ),
            'rest_length': quantity_shape(
                _REST_LENGTH, 'beyond it, it pulls, in m; default: as long as its route'
            ),
            'pull': Number('or instead: by how much it is shorter than its route, in m'),
        },
        ('via',),
    ),
)
PULLS_SHAPE = Keys(
    about='by how much each cable is shortened in this observation, in m', named=Number()
)


def read_cables(scene: Section, mesh: TetMesh | None) -> tuple[tuple[Cable, ...], list[str]]:
    """Read `cables`; return them, and notes on those that are left out.

    Args:
        scene: the whole file.
        mesh: to tell whether they run inside; without it only what is written is looked at.
    """
    section = scene.child('cables')
    if section is None:
        return (), []
    cables, notes = [], []
    for name in section.names:
        if not NAME.fullmatch(name):
            section.problems.add(
                section.at(name), 'is no name for a cable: use letters, digits and underscores'
            )
        if not section.has(name):
            section.wrong(name, 'give the via points of the cable')
            continue
        own = section.child(name)
        cable = None if own is None else _read_cable(own, name, mesh)
        if cable is None:
            continue
        if cable.stiffness.start == 0.0:
            notes.append(f'cable {name} has no stiffness and is left out')
        else:
            cables.append(cable)
    return tuple(cables), notes


def _read_cable(section: Section, name: str, mesh: TetMesh | None) -> Cable | None:
    via_points = _read_via_points(section)
    crosses_gaps = section.flag('crosses_gaps', default=False)
    if via_points is not None and mesh is not None:
        try:
            route_through(mesh, via_points, may_cross_gaps=crosses_gaps)
        except RouteError as error:
            section.problems.add(section.key, str(error))
            via_points = None
    length = 1.0 if via_points is None else _routed_length(via_points)
    stiffness = _read_stiffness(section)
    rest_length = _read_rest_length(section, length)
    section.refuse_unknown()
    if not section.is_sound or via_points is None or rest_length is None or stiffness is None:
        return None
    return Cable(name, via_points, rest_length, stiffness)


def _routed_length(via_points: FloatArray) -> float:
    return float(np.linalg.norm(np.diff(via_points, axis=0), axis=1).sum())


def _read_via_points(section: Section) -> FloatArray | None:
    if not section.required('via', _VIA):
        return None
    value = section.raw('via')
    points = [finite_numbers(item, 3) for item in value] if isinstance(value, list) else [None]
    wrong = [index for index, point in enumerate(points) if point is None]
    if wrong:
        item = value[wrong[0]] if isinstance(value, list) else value
        section.problems.add(section.at(f'via[{wrong[0]}]'), f'is {shown(item)}: {_VIA}')
        return None
    if len(points) < 2:
        section.problems.add(
            section.at('via'),
            f'has {len(points)} points: give at least two, from one end to the other',
        )
        return None
    return np.array(points)


def _read_stiffness(section: Section) -> Quantity | None:
    """Read the stiffness; 0 means that the cable is not there."""
    if not section.has('stiffness'):
        return Quantity(_USUAL_STIFFNESS, _STIFFNESSES.low, _STIFFNESSES.high)
    if section.raw('stiffness') == 0:
        return Quantity(0.0, _STIFFNESSES.low, _STIFFNESSES.high)
    return read_quantity(section, 'stiffness', _STIFFNESS)


def _read_rest_length(section: Section, length: float) -> Quantity | None:
    """Read `rest_length`, or `pull`, by which it is shorter than the route; default: as long."""
    usual = Interval(_SHORTEST * length, _LONGEST * length)
    has_pull, has_length = section.has('pull'), section.has('rest_length')
    if has_pull and has_length:
        section.problems.add(section.key, 'has rest_length and pull: keep one of the two')
        return None
    if has_length:
        return read_quantity(section, 'rest_length', replace(_REST_LENGTH, usual=usual))
    pull = section.number(
        'pull',
        default=0.0,
        allowed=Interval(length - usual.high, length - usual.low),
        needed=f'give by how many metres it is shortened, less than its route of {length:.4g} m',
    )
    return Quantity(length - pull, usual.low, usual.high)


def read_pulls(section: Section, cables: Sequence[Cable]) -> dict[str, float]:
    """Read `pulls` of an observation: by how much each cable is shortened in it [m]."""
    child = section.child('pulls')
    if child is None:
        return {}
    by_name = {cable.name: cable for cable in cables}
    for name in child.names:
        if name not in by_name:
            child.problems.add(
                child.at(name),
                f'is no cable of the scene{suggestion(name, by_name)} '
                f'(cables: {listed(by_name) or "none"})',
            )
    pulls = {}
    for name, cable in by_name.items():
        if child.has(name):
            pulls[name] = child.number(
                name,
                allowed=Interval(-cable.rest_length.upper, cable.rest_length.lower, is_open=True),
                needed='give by how many metres the cable is shortened; at its shortest rest '
                f'length, {cable.rest_length.lower:.4g} m, something must be left of it',
            )
    return pulls


def cable_routes(scene: Scene) -> list[CableRoute]:
    """Return where the cables run through the scene's mesh."""
    # Whether they leave the body was looked at when the scene was read.
    return [
        route_through(scene.mesh, cable.via_points, may_cross_gaps=True) for cable in scene.cables
    ]


def start_cables(scene: Scene, setup: ObservationSetup) -> tuple[CableState, ...]:
    """Return the cables that the scene's start values describe, in one posture."""
    return tuple(
        CableState(
            cable.rest_length.start - setup.pulls.get(cable.name, 0.0), cable.stiffness.start
        )
        for cable in scene.cables
    )
