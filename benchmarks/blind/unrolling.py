# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body that was kept bent until it was let go, and comes to be straight again under a load.

What is left of its bend falls by the inverse of the time, as where ties that hold it open in
pairs: the fewer there are, the slower (kinetics of the second order).
"""

from collections.abc import Sequence
from dataclasses import replace

from benchmarks.blind.equilibrium import find_equilibrium, Load
from benchmarks.blind.faults import Faults
from benchmarks.blind.hexahedra import integrate
from benchmarks.blind.rest_shape import stress_free_nodes, true_shape
from benchmarks.blind.setups import Setup
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.specimen import Specimen


def left_bend(faults: Faults, time: float) -> float:
    """Return which share of its bend a body has at a time since the release [s]."""
    return 1.0 / (1.0 + max(time, 0.0) / faults.curvature_time)


def bent(specimen: Specimen, setup: Setup, faults: Faults, share: float) -> Specimen:
    """Return a body that has a share of its bend without stress."""
    y, z = faults.rest_curvature
    milder = replace(faults, rest_curvature=(share * y, share * z))
    shape = true_shape(setup.shape, faults)
    quadrature = integrate(
        stress_free_nodes(specimen.mesh.nodes, shape, milder), specimen.mesh.cells
    )
    return replace(specimen, body=replace(specimen.body, quadrature=quadrature))


def unrolling(
    specimen: Specimen,
    setup: Setup,
    faults: Faults,
    load: Load,
    start: FloatArray,
    times: Sequence[float],
) -> list[FloatArray]:
    """Return where a body rests while it unrolls, object frame [m], shape (N, 3) each.

    Args:
        specimen: the body as it was let go.
        setup: of it.
        faults: say how it was bent, and how fast that goes.
        load: held from the release on.
        start: positions until then [m], shape (N, 3).
        times: since the release [s], ascending, above 0.
    """
    places, found = start, []
    for time in times:
        milder = bent(specimen, setup, faults, left_bend(faults, time))
        places = find_equilibrium(milder.body, load, places)
        found.append(places)
    return found
