# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What still air does to the faces of hexahedra that move through it."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_array, eye_array

from benchmarks.blind.hexahedra import CORNERS, HexMesh, shape_functions, shape_gradients
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.springs import around

AIR = 1.2  # [kg/m^3].
_SLOW = 0.5  # [m/s].
# Drag of half a hollow ball with its round side ahead, over that with its mouth ahead: 0.38 over
# 1.42 (Hoerner 1965, Fluid-Dynamic Drag).
_ROUND_SIDE = 0.27
_FUR = 4.0 / 3.0  # The same of fine hairs.
_RUBS = 0.02  # How fast felt is rubbed that holds back by half of its friction [m/s].
_LAMINAR = 1.5  # Power of the speed where a thin layer of air rubs along a face.


@dataclass(frozen=True)
class Drag:
    """Drag at nine Gauss points of each free face.

    Attributes:
        to_points: takes what nodes have to the points, shape (P, N).
        weights: half the air's density times drag coefficient and area of each point [kg/m],
            shape (P,).
        normals: of the faces there, at rest, shape (P, 3); None: speeds count in all directions.
        slow: speed at which a part in proportion to the speed is as large [m/s]; 0: none.
        power: of the speed by which it grows, as large as the square at half a metre per second.
        back: share of it that is felt by what moves against the normals.
        is_oblique: whether it goes with the whole speed as well, where there are normals.
        bends: speed from about which on what drags bends out of the way [m/s]; 0: it does not.
        wind: how fast the air itself goes [m/s], shape (3,); None: it stands.
    """

    to_points: csr_array
    weights: FloatArray
    normals: FloatArray | None = None
    slow: float = 0.0
    power: float = 2.0
    back: float = 1.0
    is_oblique: bool = False
    bends: float = 0.0
    wind: FloatArray | None = None

    def forces(self, velocities: FloatArray) -> FloatArray:
        """Return what holds the nodes back [N], from their velocities [m/s], shapes (N, 3)."""
        moved = there = self.to_points @ velocities
        if self.wind is not None:
            moved = there = there - self.wind
        weights = self.weights
        if self.normals is not None:
            across = (there * self.normals).sum(axis=1, keepdims=True)
            there = across * self.normals
            weights = weights * np.where(across[:, 0] < 0.0, self.back, 1.0)
        speeds = np.linalg.norm(moved if self.is_oblique else there, axis=1) + self.slow
        if self.power != 2.0:
            speeds = _SLOW ** (2.0 - self.power) * speeds ** (self.power - 1.0)
        if self.bends:
            speeds = speeds / np.cbrt(1.0 + (speeds / self.bends) ** 2)
        return np.asarray(self.to_points.T @ ((weights * speeds)[:, None] * there))


def make_drag(mesh: HexMesh, area: float, form: str = 'square') -> Drag:
    """Spread drag coefficient times area [m^2] over the free surface in proportion to its area.

    Args:
        mesh: whose faces meet the air where they are not held.
        area: drag coefficient times area [m^2].
        form: see `Faults.drag_form`.
    """
    places, shares = np.polynomial.legendre.leggauss(3)
    square = np.stack(np.meshgrid(places, places, indexing='ij'), axis=-1).reshape(-1, 2)
    values, nodes, areas, normals = [], [], [], []
    for number, axis, side in mesh.faces:
        cell = mesh.cells[number]
        if np.isin(cell[CORNERS[:, axis] == side], mesh.held).all():
            continue
        local = np.insert(square, axis, float(side), axis=1)
        along = np.einsum('ai,gaj->gji', mesh.nodes[cell], shape_gradients(local))
        one, two = np.delete(along, axis, axis=1).swapaxes(0, 1)
        vectors = np.outer(shares, shares).reshape(-1, 1) * np.cross(one, two)
        areas.append(np.linalg.norm(vectors, axis=1))
        normals.append(vectors / areas[-1][:, None])
        values.append(shape_functions(local))
        nodes.append(np.tile(cell, (len(local), 1)))
    columns, entries = np.concatenate(nodes), np.concatenate(values)
    rows = np.repeat(np.arange(len(columns)), columns.shape[1])
    shape = (len(columns), len(mesh.nodes))
    to_points = csr_array((entries.ravel(), (rows, columns.ravel())), shape=shape)
    own = np.concatenate(areas)
    weights = 0.5 * AIR * area * own / own.sum()
    return Drag(
        to_points,
        weights,
        np.concatenate(normals) if form == 'normal' else None,
        _SLOW if form == 'linear' else 0.0,
        _LAMINAR if form == 'laminar' else 2.0,
    )


def make_sail(area: float, at: float, masses: FloatArray, shares: FloatArray) -> Drag:
    """Return the drag of a film that is glued across one place of a body, flat as its broad side.

    Args:
        area: drag coefficient times area [m^2].
        at: share of the free length of that place.
        masses: of nodes, by which they share what acts there [kg], shape (N,).
        shares: of the free length at which they lie, shape (N,).
    """
    weights = around(0.5 * AIR * area, at, masses, shares)
    normals = np.tile([0.0, 0.0, 1.0], (len(masses), 1))
    return Drag(csr_array(eye_array(len(masses))), weights, normals)


def make_cup(area: float, at: float, mouth: float, areas: FloatArray, shares: FloatArray) -> Drag:
    """Return the drag of half a hollow ball that is glued to one place of a body.

    Args:
        area: drag coefficient times area, where it moves with its mouth ahead [m^2].
        at: see `make_sail`.
        mouth: 1 where that looks along the object's z, -1 where it looks the other way.
        areas: surface that belongs to nodes, by which they share what acts there, shape (N,).
        shares: see `make_sail`.
    """
    flat = make_sail(area, at, areas, shares)
    assert flat.normals is not None
    return replace(flat, normals=mouth * flat.normals, back=_ROUND_SIDE)


def make_vane(area: float, at: float, slant: float, areas: FloatArray, shares: FloatArray) -> Drag:
    """Return the drag of a flat plate that stands aslant at one place of a body.

    A stream presses on its face alone, by its speed and by the part of that across the plate
    (Eiffel 1910, La resistance de l'air): what swings up and down is pushed aside by it.

    Args:
        area: drag coefficient times area, where it moves squarely to its face [m^2].
        at: see `make_sail`.
        slant: of its normal, from the object's z towards its y [deg].
        areas: see `make_cup`.
        shares: see `make_sail`.
    """
    flat, angle = make_sail(area, at, areas, shares), np.deg2rad(slant)
    normals = np.tile([0.0, np.sin(angle), np.cos(angle)], (len(areas), 1))
    return replace(flat, normals=normals, is_oblique=True)


def make_tuft(area: float, at: float, bends: float, areas: FloatArray, shares: FloatArray) -> Drag:
    """Return the drag of a tuft of bristles on one place of a body, which bend in the stream.

    From the square of the speed it goes over to its power of four thirds (Alben, Shelley & Zhang
    2002, Nature 420), whatever way it moves.

    Args:
        area: drag coefficient times area, where it moves slowly [m^2].
        at: see `make_sail`.
        bends: speed at which it is that by the square over the cube root of two [m/s].
        areas: see `make_cup`.
        shares: see `make_sail`.
    """
    return replace(make_sail(area, at, areas, shares), normals=None, bends=bends)


def make_fur(area: float, at: float, areas: FloatArray, shares: FloatArray) -> Drag:
    """Return the drag of a fur around a body's outer part, whatever way that moves.

    Hairs are so fine that air goes slowly around each of them: it drags by the speed's power of
    four thirds (White 1991, Viscous Fluid Flow), as much as the square at half a metre per second.

    Args:
        area: drag coefficient times area that has the same drag at that speed [m^2].
        at: share of the free length from which on there is some.
        areas: see `make_cup`.
        shares: see `make_sail`.
    """
    there = areas * (shares >= at)
    weights = 0.5 * AIR * area * there / there.sum()
    return Drag(csr_array(eye_array(len(areas))), weights, power=_FUR)


def make_felts(most: float, at: float, areas: FloatArray, shares: FloatArray) -> Drag:
    """Return what felts hold one place of a body back with: by a dry friction.

    It is the same however fast that moves, but for the slowest, whose hairs go along.

    Args:
        most: all of it [N].
        at: see `make_sail`.
        areas: see `make_cup`.
        shares: see `make_sail`.
    """
    weights = around(most / _SLOW**2, at, areas, shares)
    return Drag(csr_array(eye_array(len(areas))), weights, slow=_RUBS, power=0.0)
