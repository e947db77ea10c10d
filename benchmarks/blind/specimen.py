# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body with what goes with it."""

from dataclasses import dataclass

from benchmarks.blind.body import Body
from benchmarks.blind.hexahedra import HexMesh
from benchmarks.blind.shapes import FloatArray


@dataclass(frozen=True)
class Specimen:
    """A body with the faults that go with it into every pose.

    Attributes:
        mesh: the nominal body.
        shares: of the free length at which its nodes lie, shape (N,).
        body: with the true material and the true shape without stress.
        added: further mass of the nodes [kg], shape (N,).
        tip_masses: mass of the nodes that belongs to the half at the tip [kg], shape (N,).
        areas: surface that belongs to each node [m^2], shape (N,).
        center: middle of the held section [m], shape (3,).
        heights: of the Gauss points, -1 at the lower face and 1 at the upper one, shape (C, 8).
    """

    mesh: HexMesh
    shares: FloatArray
    body: Body
    added: FloatArray
    tip_masses: FloatArray
    areas: FloatArray
    center: FloatArray
    heights: FloatArray
