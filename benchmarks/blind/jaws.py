# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Jaws that close aslant on what they hold and press it out at their mouth, or that are bowed."""

from dataclasses import replace

import numpy as np

from benchmarks.blind.faults import Faults
from benchmarks.blind.rotations import about, applied, rotation
from benchmarks.blind.shapes import bend
from benchmarks.blind.specimen import Specimen


def pinched(specimen: Specimen, faults: Faults) -> Specimen:
    """Press the held section thinner along z; all else starts from where that takes it.

    Friction keeps its width, and the bolt its inner end: what it loses in height it gains in
    length, more on the side on which the jaws are closer.
    """
    if not faults.clamp_pinch:
        return specimen
    mesh, mouth = specimen.mesh, 2.0 * specimen.center
    held = mesh.nodes[mesh.held]
    side = float(np.abs(held[:, 1]).max())
    less = faults.clamp_pinch + faults.clamp_wedge * held[:, 1] / side
    # Of what is at the mouth's middle: by how much it comes out, and how that goes on over y.
    out = mouth[0] * faults.clamp_pinch / (1.0 - faults.clamp_pinch)
    slope = mouth[0] * faults.clamp_wedge / side / (1.0 - faults.clamp_pinch) ** 2
    turn = rotation(np.array([0.0, 0.0, -slope]))
    nodes = applied(about(turn, mouth, np.array([out, 0.0, 0.0])), mesh.nodes)
    nodes[mesh.held] = np.stack(
        [held[:, 0] / (1.0 - less), held[:, 1], held[:, 2] * (1.0 - less)], axis=-1
    )
    return replace(specimen, mesh=replace(mesh, nodes=nodes))


def bowed(specimen: Specimen, faults: Faults) -> Specimen:
    """Bend the held section to an arc from its inner end on; all else starts from its mouth."""
    if not any(faults.clamp_bow):
        return specimen
    mesh, mouth = specimen.mesh, 2.0 * specimen.center
    rate = np.array([0.0, *faults.clamp_bow])
    beyond = about(rotation(mouth[0] * rate), mouth, bend(mouth, 0.0, rate) - mouth)
    nodes = applied(beyond, mesh.nodes)
    nodes[mesh.held] = bend(mesh.nodes[mesh.held], 0.0, rate)
    return replace(specimen, mesh=replace(mesh, nodes=nodes))
