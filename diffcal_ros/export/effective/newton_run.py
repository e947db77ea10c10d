# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Run Newton until a body is at rest, or at given times after it was let go.

By `SolverSemiImplicit`: `SolverVBD` stops each step far from its solution with usual numbers of
iterations. Its steps are short, so that the way to rest is dynamic relaxation with kinetic damping
(Cundall 1976): the body is stopped whenever its kinetic energy has passed a peak, which is where
it passes its rest. Only waves through single tetrahedra are damped besides.
"""

import math

from diffcal_ros.export.exported_body import ExportedBody
from diffcal_ros.export.players import play_newton
from diffcal_ros.export.targets.newton import arrays
from diffcal_ros.fem.motion.inputs import MotionError
from diffcal_ros.fem.statics.equilibrium import EquilibriumError
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# A body is at rest when no vertex moved further than this [m] ...
_STILL = 5e-7
_PATIENCE = 2  # ... during so many times the longest way from one peak to the next.
# In steps: fast waves die out in a few of them, slow modes do not notice.
_SMOOTHING = 0.5
_LOOK = 10  # Steps between two looks at the kinetic energy.
_MOST_STEPS = 400_000


def come_to_rest(body: ExportedBody, start: FloatArray) -> FloatArray:
    """Return where Newton's vertices come to rest; see `simulators.Run`.

    Args:
        body: to be simulated.
        start: vertices where the simulation begins [m], shape (V, 3).

    Raises:
        EquilibriumError: when it falls apart, or moves on for very long.
    """
    stepper = play_newton.Stepper(arrays(body), start, _SMOOTHING)
    energy, longest, peak, since, anchor = 0.0, 0, 0, 0, start
    for step in range(_LOOK, _MOST_STEPS, _LOOK):
        stepper.advance(_LOOK)
        now = float(body.vertex_masses @ (stepper.velocities**2).sum(axis=1))
        if not math.isfinite(now):
            raise EquilibriumError('Newton: the body fell apart on its way to rest')
        if now < energy:
            stepper.stop()
            longest, peak, now = max(longest, step - peak), step, 0.0
            positions = stepper.positions
            if np.abs(positions - anchor).max() > _STILL:
                since, anchor = step, positions
            elif step - since >= _PATIENCE * longest:
                return positions
        energy = now
    raise EquilibriumError(f'Newton did not come to rest within {_MOST_STEPS} steps')


def swing(body: ExportedBody, start: FloatArray, times: FloatArray) -> FloatArray:
    """Return where Newton's vertices are at some times, shape (S, V, 3); see `simulators.Swing`.

    Args:
        body: to be simulated.
        start: vertices where it is let go [m], shape (V, 3).
        times: since then [s], ascending, shape (S,).

    Raises:
        MotionError: when it falls apart.
    """
    stepper = play_newton.Stepper(arrays(body), start)
    frames, taken = np.empty((len(times), *start.shape)), 0
    for frame, time in zip(frames, times, strict=True):
        due = int(time / stepper.step)
        stepper.advance(due - taken)
        taken = due
        # The rest of the way is less than a step.
        frame[:] = stepper.positions + (time - due * stepper.step) * stepper.velocities
    if not np.isfinite(frames).all():
        raise MotionError('Newton: the body fell apart after it was let go')
    return frames
