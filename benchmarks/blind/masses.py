# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Masses that are added to a body."""

from collections.abc import Callable

import numpy as np

from benchmarks.blind.body import spread
from benchmarks.blind.faults import Faults
from benchmarks.blind.harness import wires_share
from benchmarks.blind.hexahedra import HexMesh, Quadrature
from benchmarks.blind.setups import Setup
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.vine import vine_weight

_MASS_REACH = 0.06  # Half the share of the free length over which an added mass is spread.
_POINT_REACH = 0.025  # The same of a mass on one side, and of one around the surface.
_SMEAR_REACH = 0.5
_DRIPPED_FROM = 0.4  # Of the way from the section's middle to its surface, for drips.


def added_mass(
    setup: Setup,
    faults: Faults,
    share: FloatArray,
    points: FloatArray,
    quadrature: Quadrature,
    mesh: HexMesh,
) -> FloatArray:
    """Return further masses of the nodes [kg], shape (N,).

    Args:
        setup: the rig.
        faults: say how much there is, and how it is spread.
        share: of the free length at which Gauss points lie, shape (C, 8).
        points: their places before the shape's map [m], shape (C, 3, 8).
        quadrature: over the shape without stress.
        mesh: the body.
    """
    across = points[:, 1:] / (0.5 * np.array(setup.shape.section)[:, None])
    reach, where = _spread_out(faults, across)
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
    if faults.mass_form in _ALONG:
        nearness = _ALONG[faults.mass_form](share, across, faults)
    volumes = where * (share > 0.0) * quadrature.volumes
    masses = _shared(faults.added_mass, nearness * volumes)
    if faults.mass_form == 'cable':
        cable = _shared(faults.added_mass, (share < faults.added_mass_at) * volumes)
        masses = 0.5 * (masses + cable)
    if faults.mass_form in ('arm', 'tool'):
        arm = np.array([0.0, *faults.mass_arm]) + faults.mass_ahead * tip_direction(setup)
        masses = masses * _carried(masses, arm, quadrature, mesh)
    if faults.mass_form == 'markers':
        masses = _markers(faults, share, quadrature, mesh)
    if faults.mass_form == 'spattered':
        masses = _drips(faults, share, across, (share > 0.0) * quadrature.volumes)
    return spread(masses, quadrature, mesh.cells, len(mesh.nodes))


def _spread_out(faults: Faults, across: FloatArray) -> tuple[float, FloatArray | float]:
    """Return half the share of the free length over which a mass is, and where across that.

    Args:
        faults: say how a mass is spread.
        across: of Gauss points, over half the width and the height, shape (C, 2, 8).
    """
    forms: dict[str, tuple[float, FloatArray | float]] = {
        'hat': (_MASS_REACH, 1.0),
        'ring': (_POINT_REACH, np.abs(across).max(axis=1) > 0.5),
        'smear': (_SMEAR_REACH, 1.0),
        'point': (_POINT_REACH, across[:, 0] > 0.5),
        'two': (_POINT_REACH, np.abs(across).max(axis=1) > 0.5),
        'coat': (_POINT_REACH, 1.0),
        'opposite': (_POINT_REACH, np.abs(across[:, 0]) > 0.5),
        'arm': (_MASS_REACH, 1.0),
        'cable': (_MASS_REACH, across[:, 1] > 0.5),
        # What lies on the table as far as it does not hang is no mass of its own.
        'trailing': (_MASS_REACH, 0.0),
        # Where a loose ring lies, and how wet a cloth is, each pose tells.
        'loose': (_MASS_REACH, 0.0),
        'drying': (_MASS_REACH, 0.0),
        # From the clamp to the tip: how thick it is there is set below.
        'drained': (_SMEAR_REACH, np.abs(across).max(axis=1) > 0.5),
        # Likewise: how close the turns of a wire are.
        'solder': (_SMEAR_REACH, np.abs(across).max(axis=1) > 0.5),
        # And how thick a spray can left its paint.
        'spray can': (_SMEAR_REACH, np.abs(across).max(axis=1) > 0.5),
        # And how many wires of a harness go on, on the upper side.
        'harness': (_SMEAR_REACH, across[:, 1] > 0.5),
        # On which side a wire is that winds around is set below as well.
        'vine': (_SMEAR_REACH, 1.0),
        # Where a liquid is, the body's own heights tell.
        'pooled': (_MASS_REACH, 0.0),
        # Each of several has a place of its own.
        'markers': (_MASS_REACH, 0.0),
        'tool': (_MASS_REACH, 1.0),
        # How much of a cable hangs from a body, each pose tells.
        'slung': (_MASS_REACH, 0.0),
        # So it does where the water of a sponge is.
        'sponge': (_MASS_REACH, 0.0),
        # And how far a lump has oozed.
        'oozing': (_MASS_REACH, 0.0),
        # And how far a cord is wet.
        'wicking': (_MASS_REACH, 0.0),
        # And whether a clip hangs there yet.
        'hung on': (_MASS_REACH, 0.0),
        # And how far a loose spring is drawn out.
        'slinky': (_MASS_REACH, 0.0),
        # And where a weight on a spring is.
        'sliding': (_MASS_REACH, 0.0),
        # And how full a cup is.
        'filling': (_MASS_REACH, 0.0),
        # And which of two bulbs has how much sand.
        'hourglass': (_MASS_REACH, 0.0),
        # And which of two threads bears how much of a weight.
        'cradled': (_MASS_REACH, 0.0),
        # Each of some drips has a place of its own, too.
        'spattered': (_POINT_REACH, 0.0),
    }
    return forms[faults.mass_form]


def _markers(
    faults: Faults, share: FloatArray, quadrature: Quadrature, mesh: HexMesh
) -> FloatArray:
    """Return the masses of Gauss points that carry balls on stalks [kg], shape (C, 8).

    Args:
        faults: say how heavy all balls are, how many, from where to where, and how far off.
        share: of the free length at which the points lie, shape (C, 8).
        quadrature: of the body.
        mesh: the same.
    """
    stalk, found = np.array([0.0, *faults.mass_arm]), np.zeros(share.shape)
    for at in np.linspace(*faults.mass_stops, faults.mass_count):
        weights = _nearness(share, at, _MASS_REACH) * (share > 0.0) * quadrature.volumes
        foot = _shared(faults.added_mass / faults.mass_count, weights)
        found += foot * _carried(foot, stalk, quadrature, mesh)
    return found


def _drips(
    faults: Faults, share: FloatArray, across: FloatArray, volumes: FloatArray
) -> FloatArray:
    """Return the masses of Gauss points on which glue dripped [kg], shape (C, 8).

    Args:
        faults: say how heavy all drips are, and of each where it is and its share of that.
        share: of the free length at which the points lie, shape (C, 8).
        across: of these, over half the width and the height, shape (C, 2, 8).
        volumes: of the free body at each [m^3], shape (C, 8).
    """
    found = np.zeros(share.shape)
    for at, degrees, part in faults.mass_drips:
        way = np.array([np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))])
        is_beside = np.einsum('i,cig->cg', way, across) > _DRIPPED_FROM
        weights = _nearness(share, at, _POINT_REACH) * is_beside * volumes
        found += _shared(part * faults.added_mass, weights)
    return found


def _nearness(share: FloatArray, at: float, reach: float) -> FloatArray:
    """Return how near places are to one, 1 there; at least the nearest are within reach.

    Args:
        share: of the free length, any shape.
        at: that of the place.
        reach: over which it falls to none, as a share of the free length.
    """
    away = np.abs(share - at)
    return np.asarray(np.maximum(1.0 - away / max(reach, 1.01 * float(away.min())), 0.0))


def tip_direction(setup: Setup) -> FloatArray:
    """Return where a body's middle line points at its tip, object frame, shape (3,)."""
    length = setup.shape.length
    line = setup.shape.place(np.array([[(1.0 - 1e-4) * length, 0.0, 0.0], [length, 0.0, 0.0]]))
    return np.asarray((line[1] - line[0]) / np.linalg.norm(line[1] - line[0]))


def film_thickness(share: FloatArray) -> FloatArray:
    """Return how thick a film is that drained down a body which hung by its clamp, 1 at the tip.

    By the root of the way from where it began (Jeffreys 1930, Proc. Camb. Phil. Soc. 26).

    Args:
        share: of the free length, any shape.
    """
    return np.asarray(np.sqrt(np.maximum(share, 0.0)))


def turn_density(share: FloatArray, closer: float) -> FloatArray:
    """Return how close the turns of a wire are that was wound on by hand, 1 at the tip.

    The less of it is left on the roll, the more of it each turn of the hand puts on: by the
    exponential of the way.

    Args:
        share: of the free length, any shape.
        closer: share over which there come to be three times as many.
    """
    return np.asarray(np.exp((share - 1.0) / closer))


def spray_density(share: FloatArray, at: float, high: float) -> FloatArray:
    """Return how thick a paint is below a can that was held still, 1 straight before it.

    Drops fly straight from a nozzle that sprays by the cosine. As they fly farther aside and meet
    what is aslant, there lies as much as the cosine's fourth power, as of light.

    Args:
        share: of the free length, any shape.
        at: that before the nozzle.
        high: how far away that is, as a share of the free length.
    """
    return np.asarray((1.0 + ((share - at) / high) ** 2) ** -2.0)


def _shared(grams: float, weights: FloatArray) -> FloatArray:
    """Share a mass [g] among points by weights [kg]."""
    return 1e-3 * grams * weights / max(float(weights.sum()), 1e-30)


def _carried(
    masses: FloatArray, arm: FloatArray, quadrature: Quadrature, mesh: HexMesh
) -> FloatArray:
    """Return factors that carry the middle of masses to the end of an arm, shape (C, 8).

    The arm is rigid and fixed to the affine map that is nearest to how its foot moves: the mass
    goes where that takes the arm's end, and some parts of the foot are lifted by it.

    Args:
        masses: of Gauss points, the arm's foot [kg], shape (C, 8).
        arm: from the middle of its foot to the mass, object frame [mm], shape (3,).
        quadrature: of the body.
        mesh: the same.
    """
    places = quadrature.values @ mesh.nodes[mesh.cells]
    weights = masses / max(float(masses.sum()), 1e-30)
    away = places - np.einsum('cg,cgi->i', weights, places)
    spread_out = np.einsum('cg,cgi,cgj->ij', weights, away, away)
    slopes = np.linalg.lstsq(spread_out, 1e-3 * arm, rcond=None)[0]
    return np.asarray(1.0 + away @ slopes)


# How much there is of what lies along all of a body, by shares of the free length at which Gauss
# points lie, shape (C, 8), their places over half the width and the height, shape (C, 2, 8), and
# the faults.
_ALONG: dict[str, Callable[[FloatArray, FloatArray, Faults], FloatArray]] = {
    'drained': lambda share, across, faults: film_thickness(share),
    'solder': lambda share, across, faults: turn_density(share, faults.mass_closer),
    'spray can': lambda share, across, faults: spray_density(
        share, faults.added_mass_at, faults.mass_spray
    ),
    'harness': lambda share, across, faults: wires_share(share, faults.mass_gauges),
    'vine': vine_weight,
}
