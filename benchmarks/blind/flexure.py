# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How what a clamp stands on shifts and turns by force and moment.

The end of a leaf spring, of a post or of an angle iron, a wrist of three joints, a square of foam
tape, the middle of a gantry's crossbar, the arm of a stand, a suction cup, a plate on rubber
bobbins, a gooseneck, a coil spring, a hairpin, a twisted strap, or a hexapod.
"""

import numpy as np

from benchmarks.blind.shapes import FloatArray

_STEEL = 0.3  # Poisson's ratio of a post.
_RISES = 1.5  # Height of a stand's boss over its foot, over its arm's length.
_STRONG = 0.25  # Bending of a thin angle iron about its strong axis over that about its weak one.
_SHEARED = 3.0  # How much more foam tape gives way along its plane than across.
_CUP_SHEARED = 2.0  # The same of the wall of a suction cup.
_BOBBIN_SHEARED = 2.5  # And of a rubber bobbin.
_ALONG_NECK = 12  # Places along a gooseneck, at which it is integrated.
_COIL = 0.25  # Radius of a coil spring over its height.
_HAIRPIN = 0.2  # Radius of a hairpin's bend over the length of its legs.
_STRAP = 6.0  # Width of a strap over its thickness.
# Of a hexapod's plate, over its height: how far it is below what is held, and both radii, of the
# ends of its legs above and below.
_PLATE, _ABOVE, _BELOW = 0.3, 0.7, 0.9
_PAIRED = 6.0  # Half the angle between two ends that lie beside each other [deg].
_APART = 0.6  # Of bobbins along y over those along x.
_ALONG, _UPRIGHT = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])


def flexure_compliance(by_turn: float, length: float) -> FloatArray:
    """Return shift [m] and turn [rad] by force [N] and moment [N m], shape (6, 6).

    The spring lies along the object's x and bends alike about y and z, by Bernoulli's beam; it
    twists as much by a moment about x, and does not grow longer.

    Args:
        by_turn: turn of its end by a moment on that: length over bending stiffness [rad/(N m)].
        length: [m].
    """
    return _end_compliance(by_turn, length, _ALONG, _round(_ALONG), by_turn)


def post_compliance(by_turn: float, length: float) -> FloatArray:
    """Return the same of a clamp on a round post of steel, which stands along the object's z.

    Its foot is below the clamp, whatever the pose: rig and post are turned together. It twists by
    the moment about z as a round rod does, by 1 + nu as much as it bends.

    Args:
        by_turn: turn of its end by a moment across: length over bending stiffness [rad/(N m)].
        length: from its foot to the clamp [m].
    """
    by_twist = (1.0 + _STEEL) * by_turn
    return _end_compliance(by_turn, length, _UPRIGHT, _round(_UPRIGHT), by_twist)


def angle_compliance(by_turn: float, length: float, slant: float) -> FloatArray:
    """Return the same of a clamp at the end of an angle iron that lies along the object's x.

    It bends aside of its load: four times as much about the axis through its corner as about the
    other (Timoshenko 1930, Strength of Materials, sec. 48: legs alike and thin). Plates on its
    ends keep it from twisting by more than it bends.

    Args:
        by_turn: turn of its end by a moment about its weak axis [rad/(N m)].
        length: [m].
        slant: of its weak axis, from the object's y towards z [deg].
    """
    angle = np.deg2rad(slant)
    weak = np.array([0.0, np.cos(angle), np.sin(angle)])
    strong = np.array([0.0, -np.sin(angle), np.cos(angle)])
    across = np.outer(weak, weak) + _STRONG * np.outer(strong, strong)
    return _end_compliance(by_turn, length, _ALONG, across, by_turn)


def wrist_compliance(by_turn: float, length: float) -> FloatArray:
    """Return the same of a clamp on a robot's wrist, whose three joints give way alike.

    The last turns about the object's x, the one before about y, some way behind the clamp, and
    the first about z, half as far again behind. What is between them is rigid.

    Args:
        by_turn: turn of each joint by the moment about it [rad/(N m)].
        length: from the joint about y to the clamp [m].
    """
    whole = np.zeros((6, 6))
    for axis, behind in zip(np.eye(3), (0.0, length, 1.5 * length), strict=True):
        carried = np.concatenate([np.cross(axis, behind * _ALONG), axis])
        whole += by_turn * np.outer(carried, carried)
    return whole


def tape_compliance(by_turn: float, edge: float) -> FloatArray:
    """Return the same of a clamp that a square of foam tape holds from below.

    The tape lies across the object's z, half its edge below the clamp, and gives way at each of
    its places by the pressure there, and three times as much by what shears it: by turns about
    x and y, about z by their integral over the square, and by shifts.

    Args:
        by_turn: turn about x or y by a moment about the tape's middle [rad/(N m)].
        edge: of the square [m].
    """
    by_force = by_turn * edge**2 / 12.0
    shifts = by_force * np.array([_SHEARED, _SHEARED, 1.0])
    turns = by_turn * np.array([1.0, 1.0, 0.5 * _SHEARED])
    return _carried(np.diag([*shifts, *turns]), 0.5 * edge * _UPRIGHT)


def gantry_compliance(by_turn: float, length: float) -> FloatArray:
    """Return the same of a clamp amid a round crossbar along the object's y, held at both ends.

    It twists most: each half by 1 + nu times as much as it bends, and both halves bear. By a
    moment across, its middle turns by an eighth of length over bending stiffness, and by a force
    across it shifts by a 24th of the cube of the length over that (Roark, Formulas for Stress and
    Strain, of beams with both ends fixed). It does not grow longer.

    Args:
        by_turn: turn about y by a moment about that [rad/(N m)].
        length: of each half [m].
    """
    bent = by_turn / (1.0 + _STEEL)  # Half of length over bending stiffness.
    shift = bent * length**2 / 12.0
    turn = 0.25 * bent
    return np.diag([shift, 0.0, shift, turn, by_turn, turn])


def stand_compliance(by_turn: float, length: float) -> FloatArray:
    """Return the same of a clamp on the arm of a stand, as chemists have.

    The arm goes from the clamp back along the object's x to a boss on a rod, whose foot is below
    the boss along the object's z, `_RISES` times as far. Both are of the same round steel: they
    bend alike, and twist by 1 + nu as much.

    Args:
        by_turn: turn about y by a moment about that, of arm and rod [rad/(N m)].
        length: of the arm [m].
    """
    arm = by_turn / (1.0 + _RISES)
    rod = post_compliance(_RISES * arm, _RISES * length)
    bends = _end_compliance(arm, length, _ALONG, _round(_ALONG), (1.0 + _STEEL) * arm)
    return bends + _carried(rod, length * _ALONG)


def suction_compliance(by_turn: float, width: float) -> FloatArray:
    """Return the same of a clamp that a round suction cup holds from behind.

    The cup lies across the object's x, its width behind the clamp, and its thin wall gives way at
    each of its places by the pull there, and twice as much by what shears it: by turns about y and
    z, about x by their integral over the wall's ring, and by shifts.

    Args:
        by_turn: turn about y or z by a moment about the cup's middle [rad/(N m)].
        width: of the cup, from wall to wall [m].
    """
    by_force = 0.5 * by_turn * (0.5 * width) ** 2
    shifts = by_force * np.array([1.0, _CUP_SHEARED, _CUP_SHEARED])
    turns = by_turn * np.array([0.5 * _CUP_SHEARED, 1.0, 1.0])
    return _carried(np.diag([*shifts, *turns]), width * _ALONG)


def bobbin_compliance(by_turn: float, length: float) -> FloatArray:
    """Return the same of a clamp on a plate that stands on four rubber bobbins, against shaking.

    They are the corners of a rectangle across the object's z, `length` apart along x and `_APART`
    times as far along y, half the length below the clamp. Each gives way along z by what presses
    it, and `_BOBBIN_SHEARED` times as much by what shears it.

    Args:
        by_turn: turn about y by a moment about the bobbins' middle [rad/(N m)].
        length: from bobbin to bobbin along x [m].
    """
    ahead, aside = (0.5 * length) ** 2, (0.5 * _APART * length) ** 2
    by_force = by_turn * ahead
    shifts = by_force * np.array([_BOBBIN_SHEARED, _BOBBIN_SHEARED, 1.0])
    turns = by_force * np.array([1.0 / aside, 1.0 / ahead, _BOBBIN_SHEARED / (ahead + aside)])
    return _carried(np.diag([*shifts, *turns]), 0.5 * length * _UPRIGHT)


def gooseneck_compliance(by_turn: float, radius: float) -> FloatArray:
    """Return the same of a clamp on a gooseneck, a round rod that is bent to a quarter circle.

    It leaves the clamp back along the object's x and comes down along its z to a foot, the radius
    behind and as far below. It bends alike about all axes across it, and twists by 1 + nu as much:
    Castigliano's theorem along it.

    Args:
        by_turn: turn about y by a moment about that: length over bending stiffness [rad/(N m)].
        radius: of the circle [m].
    """
    places, weights = np.polynomial.legendre.leggauss(_ALONG_NECK)
    whole = np.zeros((6, 6))
    for angle, weight in zip(0.25 * np.pi * (1.0 + places), 0.5 * weights, strict=True):
        way, ahead = np.array([-np.sin(angle), 0.0, np.cos(angle) - 1.0]), np.zeros(3)
        ahead[[0, 2]] = np.cos(angle), np.sin(angle)
        turns = np.zeros((6, 6))
        turns[3:, 3:] = _round(ahead) + (1.0 + _STEEL) * np.outer(ahead, ahead)
        whole += by_turn * weight * _carried(turns, -radius * way)
    return whole


def coil_compliance(by_turn: float, height: float) -> FloatArray:
    """Return the same of a clamp on top of a close coil spring, which stands along the object's z.

    Its round wire bends, and twists by 1 + nu as much. Over each of its turns that gives way to a
    moment across by 1 + nu / 2, to one along z by 1, to a force along z by 1 + nu times the square
    of the radius, and to one across by half of that square (Timoshenko 1930, Strength of
    Materials, sec. 63 and 64), all of which is carried from its height to the clamp.

    Args:
        by_turn: turn about y by a moment about that [rad/(N m)].
        height: of the spring [m].
    """
    across, square = 1.0 + 0.5 * _STEEL, (_COIL * height) ** 2
    shifts = square * np.array([0.5, 0.5, 1.0 + _STEEL])
    turn = by_turn / across * np.diag([*shifts, across, across, 1.0])
    # By Gauss's rule of two places, as it goes with the square of the height.
    places = 0.5 * height * (1.0 + np.array([-1.0, 1.0]) / np.sqrt(3.0))
    return np.mean([_carried(turn, place * _UPRIGHT) for place in places], axis=0)


def hairpin_compliance(by_turn: float, length: float) -> FloatArray:
    """Return the same of a clamp on a hairpin, a round rod that goes back and comes forward again.

    One leg goes back along the object's x, a half circle turns downwards, and the other leg comes
    forward below the first one to a foot. It bends alike about all axes across it, and twists by
    1 + nu as much: Castigliano's theorem along it.

    Args:
        by_turn: turn about y by a moment about that: length over bending stiffness [rad/(N m)].
        length: of each leg [m].
    """
    radius, whole = _HAIRPIN * length, np.zeros((6, 6))
    places, weights = np.polynomial.legendre.leggauss(_ALONG_NECK)
    legs, bend = length * _ALONG, np.pi * radius
    for part, weight in zip(0.5 * (1.0 + places), 0.5 * weights, strict=True):
        sine, cosine = np.sin(np.pi * part), np.cos(np.pi * part)
        around = -legs - radius * (sine * _ALONG + (1.0 - cosine) * _UPRIGHT)
        back = -legs * part - 2.0 * radius * _UPRIGHT
        for place, ahead, piece in (
            (-legs * part, _ALONG, length),
            (around, cosine * _ALONG + sine * _UPRIGHT, bend),
            (back, _ALONG, length),
        ):
            turns = np.zeros((6, 6))
            turns[3:, 3:] = _round(ahead) + (1.0 + _STEEL) * np.outer(ahead, ahead)
            whole += weight * piece * _carried(turns, -place)
    return by_turn / (2.0 * length + bend) * whole


def strap_compliance(by_turn: float, length: float) -> FloatArray:
    """Return the same of a clamp at the end of a flat strap of steel that is twisted by a quarter.

    It lies along the object's x. At the clamp it is flat and bends about y; it comes round, so
    that at its foot it stands upright and bends about z. It twists as thin
    strips do (Timoshenko 1930, Strength of Materials): Castigliano's theorem along it.

    Args:
        by_turn: turn about y by a moment about that [rad/(N m)].
        length: [m].
    """
    strong, whole = _STRAP**-2.0, np.zeros((6, 6))
    places, weights = np.polynomial.legendre.leggauss(_ALONG_NECK)
    for part, weight in zip(0.5 * (1.0 + places), 0.5 * weights, strict=True):
        angle = 0.5 * np.pi * part
        easy = np.array([0.0, np.cos(angle), np.sin(angle)])
        hard = np.cross(easy, _ALONG)
        turns = np.zeros((6, 6))
        turns[3:, 3:] = np.outer(easy, easy) + strong * np.outer(hard, hard)
        turns[3:, 3:] += 0.5 * (1.0 + _STEEL) * np.outer(_ALONG, _ALONG)
        whole += weight * _carried(turns, part * length * _ALONG)
    return 2.0 * by_turn / (1.0 + strong) * whole


def hexapod_ends(height: float) -> tuple[FloatArray, FloatArray]:
    """Return where the six legs of a hexapod end above and below [m], shape (6, 3) each.

    From the middle of what is held; above, ends lie in pairs between those below, and each leg
    leans to the pair beside it.

    Args:
        height: from the lower ends to the upper ones [m].
    """
    pairs, sides = np.repeat([0.0, 120.0, 240.0], 2), np.tile([-1.0, 1.0], 3)
    ends = []
    for angles, radius, down in (
        (pairs + sides * (60.0 - _PAIRED), _ABOVE, _PLATE),
        (pairs + sides * _PAIRED, _BELOW, 1.0 + _PLATE),
    ):
        turned = np.deg2rad(angles)
        around = radius * np.column_stack([np.cos(turned), np.sin(turned)])
        ends.append(height * np.column_stack([around, np.full(6, -down)]))
    return ends[0], ends[1]


def hexapod_compliance(by_turn: float, height: float) -> FloatArray:
    """Return the same of a clamp on a hexapod, whose six legs give way along themselves alone.

    Their joints are free, so that the plate's stiffness is the sum of what each leg bears along
    its own line (Gosselin 1990, IEEE Trans. Robot. Autom. 6).

    Args:
        by_turn: turn about y by a moment about that [rad/(N m)].
        height: of the hexapod, which stands along the object's z [m].
    """
    above, below = hexapod_ends(height)
    lines = (above - below) / np.linalg.norm(above - below, axis=1)[:, None]
    screws = np.column_stack([lines, np.cross(above, lines)])
    whole = np.linalg.inv(screws.T @ screws)
    return np.asarray(by_turn / whole[4, 4] * whole)


def _carried(compliance: FloatArray, way: FloatArray) -> FloatArray:
    """Return the compliance of a place that is rigidly carried by another one, shape (6, 6).

    Args:
        compliance: of that, shape (6, 6).
        way: from there to the place [m], shape (3,).
    """
    # Of force and moment on the one, what the other bears.
    borne = np.eye(6)
    borne[3:, :3] = np.cross(way, np.eye(3)).T
    return np.asarray(borne.T @ compliance @ borne)


def _round(ahead: FloatArray) -> FloatArray:
    """Return how a beam bends that bends alike about all axes across it, shape (3, 3)."""
    return np.eye(3) - np.outer(ahead, ahead)


def _end_compliance(
    by_turn: float, length: float, ahead: FloatArray, across: FloatArray, twist: float
) -> FloatArray:
    """Return shift and turn of the end of a beam by force and moment, shape (6, 6).

    Args:
        by_turn: turn of its end by a moment across [rad/(N m)].
        length: [m].
        ahead: direction from its foot to its end, shape (3,).
        across: turn by a moment across, over `by_turn`, shape (3, 3).
        twist: turn of its end by a moment along it [rad/(N m)].
    """
    along, arms = np.outer(ahead, ahead), np.cross(ahead, np.eye(3)).T
    turn_by_force = 0.5 * by_turn * length * (across @ arms)
    whole = np.empty((6, 6))
    whole[:3, :3] = by_turn * length**2 / 3.0 * (arms.T @ across @ arms)
    whole[3:, :3] = turn_by_force
    whole[:3, 3:] = turn_by_force.T
    whole[3:, 3:] = by_turn * across + twist * along
    return whole
