# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forces that come from a point of the world, as energies of nodes in the object frame."""

import numpy as np

from benchmarks.blind.equilibrium import Potential, PotentialLaw
from benchmarks.blind.faults import Faults
from benchmarks.blind.setups import Observation
from benchmarks.blind.shapes import FloatArray

MAGNETIC_FROM = 0.6  # Share of the free length from which on a body is drawn by a magnet.
_TIED = 0.97  # Share from which on nodes are tied to a tether, or to the cord of a reel.


def pulls(
    masses: FloatArray, shares: FloatArray, observation: Observation, faults: Faults
) -> tuple[PotentialLaw, ...]:
    """Return what pulls on a body in one pose.

    Args:
        masses: of nodes [kg], shape (N,).
        shares: of the free length at which they lie, shape (N,).
        observation: the pose.
        faults: say what there is.
    """
    matrix = observation.world_from_object
    point = matrix[:3, :3].T @ (np.array(faults.pull_point) - matrix[:3, 3])
    found = []
    if faults.magnet:
        drawn = masses * (shares > MAGNETIC_FROM)
        strength = faults.magnet * faults.pull_distance**2 * drawn / drawn.sum()
        found.append(magnet(point, strength))
    if faults.tether:
        tied = (shares > _TIED).astype(float)
        slack = faults.tether_slack * faults.pull_distance
        # As much at the distance where it is stated.
        stiffness = faults.tether / (faults.pull_distance - slack) * tied / tied.sum()
        found.append(tether(point, stiffness, slack))
    if faults.reeled:
        tied = (shares > _TIED).astype(float)
        found.append(reel(point, faults.reeled * tied / tied.sum()))
    return tuple(found)


def turntable(
    masses: FloatArray, observation: Observation, side: FloatArray, radius: float
) -> PotentialLaw:
    """Return what draws parts away from the upright axis of a table that turns steadily.

    Args:
        masses: of nodes [kg], shape (N,).
        observation: the pose.
        side: pull where the camera looks, level, world [m/s^2], shape (3,).
        radius: distance of the axis from there [m].
    """
    strength = float(np.linalg.norm(side))
    square = strength / radius  # Of the table's speed [1/s^2].
    matrix = observation.world_from_object
    level = np.diag([1.0, 0.0, 1.0]) @ matrix[:3, :3]
    axis = -radius * side / max(strength, 1e-30)
    foot = np.diag([1.0, 0.0, 1.0]) @ (matrix[:3, 3] - axis)
    pull = square * masses
    diagonal = -pull[:, None, None] * (level.T @ level)

    def energy(positions: FloatArray) -> Potential:
        away = positions @ level.T + foot
        return Potential(
            energy=-0.5 * float((pull[:, None] * away**2).sum()),
            gradient=-pull[:, None] * (away @ level),
            diagonal=diagonal,
        )

    return energy


def _away_from(
    point: FloatArray, positions: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return how far nodes are from a point [m], the way there, and that with itself.

    Args:
        point: [m], shape (3,).
        positions: of the nodes [m], shape (N, 3).

    Returns:
        Shape (N,), unit vectors, (N, 3), and their outer products, (N, 3, 3).
    """
    away = positions - point
    distance = np.linalg.norm(away, axis=1)
    unit = away / distance[:, None]
    return distance, unit, unit[:, :, None] * unit[:, None, :]


def magnet(point: FloatArray, strength: FloatArray) -> PotentialLaw:
    """Return a pull towards a point that falls with the square of the distance.

    Args:
        point: [m], shape (3,).
        strength: force times the square of the distance of each node [N m^2], shape (N,).
    """

    def energy(positions: FloatArray) -> Potential:
        distance, unit, outer = _away_from(point, positions)
        return Potential(
            energy=-float((strength / distance).sum()),
            gradient=(strength / distance**2)[:, None] * unit,
            diagonal=(strength / distance**3)[:, None, None] * (np.eye(3) - 3.0 * outer),
        )

    return energy


def reel(point: FloatArray, forces: FloatArray) -> PotentialLaw:
    """Return the cord of a reel, which pulls towards a point as hard at all distances.

    Args:
        point: [m], shape (3,).
        forces: of each node's part [N], shape (N,).
    """

    def energy(positions: FloatArray) -> Potential:
        distance, unit, outer = _away_from(point, positions)
        return Potential(
            energy=float((forces * distance).sum()),
            gradient=forces[:, None] * unit,
            diagonal=(forces / distance)[:, None, None] * (np.eye(3) - outer),
        )

    return energy


def tether(point: FloatArray, stiffness: FloatArray, slack: FloatArray | float) -> PotentialLaw:
    """Return a spring that pulls towards a point once it is taut.

    Args:
        point: [m], shape (3,).
        stiffness: of each node's part [N/m], shape (N,).
        slack: its length without a force [m], or that of each node's part, shape (N,).
    """

    def energy(positions: FloatArray) -> Potential:
        distance, unit, outer = _away_from(point, positions)
        longer = np.maximum(distance - slack, 0.0)
        taut = (stiffness * (longer > 0.0))[:, None, None]
        across = (stiffness * longer / distance)[:, None, None]
        return Potential(
            energy=0.5 * float((stiffness * longer**2).sum()),
            gradient=(stiffness * longer)[:, None] * unit,
            diagonal=taut * outer + across * (np.eye(3) - outer),
        )

    return energy
