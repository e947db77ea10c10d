# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What sinks as a whole by all of the force on it, as the pan of a balance does."""

from collections.abc import Callable

from benchmarks.blind.body import Body
from benchmarks.blind.equilibrium import find_equilibrium, Load
from benchmarks.blind.shapes import FloatArray

_TOLERANCE = 1e-6  # Of how far a pan sinks [m].


def settle_on_pan(
    body: Body,
    start: FloatArray,
    loads: Callable[[float], Load],
    normal: FloatArray,
    give: Callable[[float], float],
) -> FloatArray:
    """Return node positions at rest on a pan that has sunk as its force asks, shape (N, 3).

    Args:
        body: the elastic body.
        start: first guess [m], shape (N, 3); its held nodes stay.
        loads: on it by how far the pan has sunk [m]; the pan's push is the first potential.
        normal: of the pan, object frame, shape (3,).
        give: by how much it sinks [m] by force [N].
    """
    positions, sunk = start, 0.0
    for _ in range(60):
        load = loads(sunk)
        positions = find_equilibrium(body, load, positions)
        force = -float((load.potentials[0](positions).gradient @ normal).sum())
        # Part of a step: the body pushes less the farther the pan has sunk.
        change = 0.6 * (give(force) - sunk)
        if abs(change) < _TOLERANCE:
            return positions
        sunk += change
    raise RuntimeError('the pan found no rest')
