# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Air across a bench.

A round stream, as of a ventilator, a layer that the bench slows down, air that a mouth draws, two
fans that blow against each other, a curtain of air, a jet that spreads, what a grille lets
through, what goes past a post or the edge of a screen, a stream that is hollow behind a hub,
that over the edge of a box, which comes back below, a jet along a wall, or air that spreads on a
bench on which it was blown down.
"""

import numpy as np
from scipy.special import erf

from benchmarks.blind.faults import Faults
from benchmarks.blind.shapes import FloatArray

_SPREADS = 0.107  # Of a jet's way from its mouth, over which its speed falls to a third.
_MOUTH = 0.2  # Of the way where a jet is stated, before which it does not spread.


def stream_share(places: FloatArray, way: FloatArray, faults: Faults) -> FloatArray:
    """Return how much of a stream's push is felt at places, 1 on its axis, shape (N,).

    The pressure of a free round stream falls by the square of the distance's exponential from
    its axis (Pope 2000, Turbulent Flows, sec. 5.1); along it, over a body, it hardly changes.

    Args:
        places: world [m], shape (N, 3).
        way: in which it blows, world, shape (3,).
        faults: say where its axis is, and how wide it is.
    """
    along = way / max(float(np.linalg.norm(way)), 1e-30)
    beside = places - np.array(faults.tilt_point)
    squares = (beside**2).sum(axis=1) - (beside @ along) ** 2
    return np.asarray(np.exp(-squares / faults.tilt_width**2))


def spreading_share(places: FloatArray, way: FloatArray, faults: Faults) -> FloatArray:
    """Return how much of a spreading jet's push is felt at places, 1 amid it where it is stated.

    The speed of a round jet falls by the way from its mouth, and beside its axis by the
    exponential of the square of the distance over a tenth of that way (Fischer et al. 1979, Mixing
    in Inland and Coastal Waters, sec. 9.2); its pressure goes with the square of the speed.

    Args:
        places: world [m], shape (N, 3).
        way: in which it blows, world, shape (3,).
        faults: say where its axis is, and how far from its mouth it is stated there.
    """
    along = way / max(float(np.linalg.norm(way)), 1e-30)
    beside = places - np.array(faults.tilt_point)
    ahead = beside @ along
    from_mouth = np.maximum(faults.tilt_away + ahead, _MOUTH * faults.tilt_away)
    squares = (beside**2).sum(axis=1) - ahead**2
    felt = np.exp(-2.0 * squares / (_SPREADS * from_mouth) ** 2)
    return np.asarray((faults.tilt_away / from_mouth) ** 2 * felt)


def curtain_share(places: FloatArray, way: FloatArray, faults: Faults) -> FloatArray:
    """Return how much of a curtain's push is felt at places, 1 amid it, shape (N,).

    An upright sheet of air, whose speed falls beside it by the square of the hyperbolic cosine
    (Bickley 1937, Phil. Mag. 23: a plane jet), and its pressure by the square of that. Along it it
    hardly changes.

    Args:
        places: world [m], shape (N, 3).
        way: in which it blows, level, world, shape (3,).
        faults: say through which point it goes, and how wide it is.
    """
    across = np.cross([0.0, 1.0, 0.0], way)
    across = across / max(float(np.linalg.norm(across)), 1e-30)
    beside = (places - np.array(faults.tilt_point)) @ across
    return np.asarray(np.cosh(beside / faults.tilt_width) ** -4.0)


def layer_share(places: FloatArray, way: FloatArray, faults: Faults) -> FloatArray:
    """Return how much is felt of air that a bench slows down, 1 where the camera looks, (N,).

    Its speed goes with the height above the bench (Couette's flow), and its pressure with the
    square of that.

    Args:
        places: world [m], shape (N, 3).
        way: in which it blows; it is alike along that, shape (3,).
        faults: say how far the bench lies below where the camera looks.
    """
    heights = np.maximum(places[:, 1] + faults.tilt_above, 0.0)
    return np.asarray((heights / faults.tilt_above) ** 2)


def opposed_share(shares: FloatArray, border: float, back: float) -> FloatArray:
    """Return how much of the outer fan's push is felt where an inner one blows back, shape (N,).

    Args:
        shares: of the free length, shape (N,).
        border: share from which on the outer one is felt, and up to which the inner one.
        back: by which share of the outer one's push the inner one blows the other way.
    """
    return np.asarray(np.where(shares > border, 1.0, -back * (shares > 0.0)))


def drawn_in(places: FloatArray, side: FloatArray, faults: Faults) -> FloatArray:
    """Return by how much parts are drawn to a mouth, world frame [m/s^2], shape (N, 3).

    The speed of air far before a small mouth falls with the square of the distance (a sink: Dalla
    Valle 1952, Exhaust Hoods), and its push with the square of that.

    Args:
        places: world [m], shape (N, 3).
        side: as large as what is felt where the camera looks [m/s^2], shape (3,).
        faults: say where the mouth is.
    """
    mouth = np.array(faults.tilt_point)
    ahead = mouth - places
    distance = np.linalg.norm(ahead, axis=1)[:, None]
    push = float(np.linalg.norm(side)) * (np.linalg.norm(mouth) / distance) ** 4
    return np.asarray(push * ahead / distance)


def louvre_share(places: FloatArray, way: FloatArray, faults: Faults) -> FloatArray:
    """Return how much of a push is felt behind a grille of upright slats, 1 amid two, shape (N,).

    Args:
        places: world [m], shape (N, 3).
        way: in which it blows, level, world, shape (3,).
        faults: say amid which slats air comes through, and how far these are apart.
    """
    along = way / max(float(np.linalg.norm(way)), 1e-30)
    aside = np.cross(along, [0.0, 1.0, 0.0])
    slats = (places - np.array(faults.tilt_point)) @ aside / faults.tilt_wave
    return np.asarray(np.cos(np.pi * slats) ** 2)


def lee_share(places: FloatArray, way: FloatArray, faults: Faults) -> FloatArray:
    """Return how much of a push is felt behind an upright post, 1 far beside it, shape (N,).

    What air lacks behind a post goes with the exponential of the square of the way beside it
    (Schlichting 1979, Boundary-Layer Theory, ch. XXIV); along a body's width it hardly changes.

    Args:
        places: world [m], shape (N, 3).
        way: in which it blows, level, world, shape (3,).
        faults: say through what the middle of the lee goes, and how wide it is.
    """
    along = way / max(float(np.linalg.norm(way)), 1e-30)
    aside = np.cross(along, [0.0, 1.0, 0.0])
    beside = (places - np.array(faults.tilt_point)) @ aside / faults.tilt_width
    return np.asarray(1.0 - np.exp(-(beside**2)))


def screened_share(places: FloatArray, way: FloatArray, faults: Faults) -> FloatArray:
    """Return how much of a push is felt past a screen's upright edge, 1 far beside it, shape (N,).

    Between what blows and what rests the speed goes with the error function of the way across
    (Goertler 1942, ZAMM 22: a mixing layer), and the pressure with its square.

    Args:
        places: world [m], shape (N, 3).
        way: in which it blows, level, world, shape (3,).
        faults: say through what the layer's middle goes, and how wide it is; below 0: the screen
            is on the other side.
    """
    along = way / max(float(np.linalg.norm(way)), 1e-30)
    aside = np.cross(along, [0.0, 1.0, 0.0])
    beside = (places - np.array(faults.tilt_point)) @ aside / faults.tilt_width
    return np.asarray((0.5 * (1.0 + erf(beside))) ** 2)


def hollow_share(places: FloatArray, way: FloatArray, faults: Faults) -> FloatArray:
    """Return how much is felt of a fan's stream that is hollow behind its hub, shape (N,).

    With q the square of the way from the axis over the ring's radius it is q exp(1 - q): none on
    the axis, and 1 on the ring.

    Args:
        places: world [m], shape (N, 3).
        way: in which it blows, world, shape (3,).
        faults: say where its axis is, and how wide the ring is.
    """
    along = way / max(float(np.linalg.norm(way)), 1e-30)
    beside = np.cross(places - np.array(faults.tilt_point), along)
    squares = (beside**2).sum(axis=1) / faults.tilt_width**2
    return np.asarray(squares * np.exp(1.0 - squares))


def eddy_share(places: FloatArray, way: FloatArray, faults: Faults) -> FloatArray:
    """Return how much is felt of air that blows over a box and comes back below, shape (N,).

    Its speed goes by the hyperbolic tangent of the height over the box's edge, as between two
    streams that mix, and it pushes by the square of that, the other way below.

    Args:
        places: world [m], shape (N, 3).
        way: in which it blows above, world, shape (3,); wherever that points, it is level.
        faults: say how high the edge is, and over which height the speed changes.
    """
    speed = np.tanh((places[:, 1] - faults.tilt_point[1]) / faults.tilt_width)
    return np.asarray(speed * np.abs(speed))


def wall_share(places: FloatArray, way: FloatArray, faults: Faults) -> FloatArray:
    """Return how much is felt of a jet along an upright wall, 1 where it is fastest, shape (N,).

    With q the way from the wall over that to where it is fastest, its speed goes with
    q exp(1 - q): none on the wall, and little far away from it, as of Glauert's jets (1956, J.
    Fluid Mech. 1). It pushes by the square of that.

    Args:
        places: world [m], shape (N, 3).
        way: in which it blows, level and along the wall, world, shape (3,).
        faults: say through what the wall goes, and how far from it the jet is fastest; below 0:
            what is felt is on the left of who goes with it.
    """
    along = way / max(float(np.linalg.norm(way)), 1e-30)
    aside = np.cross(along, [0.0, 1.0, 0.0])
    away = (places - np.array(faults.tilt_point)) @ aside / faults.tilt_width
    away = np.maximum(away, 0.0)
    return np.asarray((away * np.exp(1.0 - away)) ** 2)


def spread_out(places: FloatArray, side: FloatArray, faults: Faults) -> FloatArray:
    """Return by how much parts are pushed by air that comes down and spreads, shape (N, 3).

    It goes level away from where it comes down. With q the way from there over that to where it is
    fastest, its speed goes with 2 q / (1 + q^2): at first with the way, as where a jet meets a
    plate, and far out with the inverse of that, as what spreads on a bench does.

    Args:
        places: world [m], shape (N, 3).
        side: as large as what is felt where it is fastest, world [m/s^2], shape (3,).
        faults: say where it comes down, and how far from there it is fastest.
    """
    away = (places - np.array(faults.tilt_point)) * [1.0, 0.0, 1.0]
    far = np.linalg.norm(away, axis=1)[:, None]
    speed = 2.0 * far * faults.tilt_width / (far**2 + faults.tilt_width**2)
    return np.asarray(float(np.linalg.norm(side)) * speed**2 * away / np.maximum(far, 1e-30))
