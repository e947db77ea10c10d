# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A small beam on a ledge that lets go, filmed by the synthetic recorder."""

from pathlib import Path
from typing import Any

from diffcal_ros.synthetic.filming import Timing
from diffcal_ros.synthetic.recorder import SyntheticRecording

from support.recorded_beam import record_beam

RELEASE_TIME = 0.08
DAMPING = 150.0
DENSITY_STD = 20.0
CHANGES: dict[str, Any] = {
    'held.ledge': {'box': {'x': [-float('inf'), 0.0]}},
    'motion': {
        'released': ['ledge'],
        'at': {'start': RELEASE_TIME, 'min': 0.03, 'max': 0.2},
        'hold_out': 4,
    },
    'regions.body.youngs_modulus': 200e3,
    'regions.body.damping': DAMPING,
    # Motion shows only ratios to the density: it was weighed.
    'regions.body.density': {'start': 1080, 'prior': {'mean': 1080, 'std': DENSITY_STD}},
    'fit': ['youngs_modulus', 'damping', 'density', 'release_time', 'rigid_offset'],
}


def record_release(
    folder: Path,
    changes: dict[str, Any] | None = None,
    timing: Timing | None = None,
    **kwargs: Any,
) -> SyntheticRecording:
    """Film half a second of the beam into `folder`/recorded."""
    return record_beam(
        folder,
        {**CHANGES, **(changes or {})},
        timing=timing or Timing(12),
        start_factor=1.3,
        **kwargs,
    )
