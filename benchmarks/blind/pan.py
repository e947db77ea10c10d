# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What gives way as a whole by all of the load on it, as a balance's pan or a flap does."""

from collections.abc import Callable

from benchmarks.blind.body import Body
from benchmarks.blind.equilibrium import find_equilibrium, Load
from benchmarks.blind.shapes import FloatArray

_TOLERANCE = 1e-6  # Of how far a pan sinks [m], or a flap turns [rad].


def settle_on_pan(
    body: Body,
    start: FloatArray,
    loads: Callable[[float], Load],
    load_of: Callable[[FloatArray, FloatArray], float],
    give: Callable[[float], float],
    part: float,
) -> FloatArray:
    """Return node positions at rest on a pan that has sunk as its load asks, shape (N, 3).

    Args:
        body: the elastic body.
        start: first guess [m], shape (N, 3); its held nodes stay.
        loads: on the body by how far the pan has sunk [m]; the pan's push is the first potential.
        load_of: force on the pan [N] by node positions [m] and slopes of its potential [N],
            shape (N, 3) each; of a flap, which turns, a moment [N m].
        give: by how much it sinks [m] by force, or turns [rad] by moment.
        part: of what is lacking, by which it sinks from round to round: the body pushes less the
            farther the pan has sunk.
    """
    positions, sunk = start, 0.0
    for _ in range(60):
        load = loads(sunk)
        positions = find_equilibrium(body, load, positions)
        force = load_of(positions, load.potentials[0](positions).gradient)
        change = part * (give(force) - sunk)
        if abs(change) < _TOLERANCE:
            return positions
        sunk += change
    raise RuntimeError('the pan found no rest')
