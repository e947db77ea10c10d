# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fixed steps and steps by an error, side by side: error against time after a ledge lets go.

The error is the farthest that any node is off in any frame of 60 Hz from a march with steps of
1/3840 s.
"""

import argparse
from collections.abc import Callable
from dataclasses import dataclass
import time
from typing import Any

from diffcal_ros.fem.motion.moving_body import Motion
from measuring import cantilevers, write
from motion import Cantilever
import numpy as np

_RATE = 60.0
_FINE = 1.0 / 3840.0
_FIXED = tuple(1.0 / rate for rate in (60, 120, 240, 480, 960))
_TOLERANCES = (8e-5, 2e-5, 5e-6, 1.25e-6)


@dataclass(frozen=True)
class Swing:
    """What swings.

    Attributes:
        damping: [Pa s].
        duration: [s].
    """

    damping: float
    duration: float

    def run(self, mesh: Any, **steps: float) -> tuple[Cantilever, Motion]:
        """Let it go."""
        case = Cantilever(mesh, **steps)
        return case, self.again(case)

    def again(self, case: Cantilever) -> Motion:
        """Let the same body go once more."""
        damping = np.full(case.mesh.tet_count, self.damping)
        stamps = np.arange(1, round(_RATE * self.duration) + 1) / _RATE
        return case.run(stamps, damping=damping)


SWINGS = {
    'hardly damped': Swing(10.0, 1.0),
    'swings out': Swing(300.0, 3.0),
    'creeps to rest': Swing(3000.0, 3.0),
}


def _cpu_seconds(work: Callable[[], Any], repeats: int) -> float:
    seconds = []
    for _ in range(repeats):
        begun = time.process_time()
        work()
        seconds.append(time.process_time() - begun)
    return min(seconds)


def _row(mesh: Any, swing: Swing, path: Any, repeats: int, steps: dict[str, float]) -> Any:
    case, motion = swing.run(mesh, **steps)
    wrong = np.linalg.norm(motion.positions - path, axis=2).max(axis=1)
    return {
        **steps,
        'step_count': motion.step_count,
        'halvings': motion.halvings,
        'rungs': sorted(set(motion.rungs)),
        'forward_cpu_s': _cpu_seconds(lambda: swing.again(case), repeats),
        'gradient_cpu_s': _cpu_seconds(lambda: case.tip_gradient(motion), repeats),
        'error_mm': 1e3 * float(wrong.max()),
        'rms_error_mm': 1e3 * float(np.sqrt((wrong**2).mean())),
        'estimated_mm': 1e3 * float(motion.step_errors.sum()),
    }


def main() -> None:
    """Run all swings."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--repeats', type=int, default=1)
    arguments = parser.parse_args()
    mesh, rows = cantilevers()['coarse'], []
    choices = [{'time_step': step} for step in _FIXED]
    choices += [{'tolerance': tolerance} for tolerance in _TOLERANCES]
    for name, swing in SWINGS.items():
        path = swing.run(mesh, time_step=_FINE)[1].positions
        for steps in choices:
            rows.append({'swing': name, **_row(mesh, swing, path, arguments.repeats, steps)})
            print(rows[-1], flush=True)
    write('step_control', {'rows': rows})


if __name__ == '__main__':
    main()
